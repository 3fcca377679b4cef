// pinocchio's C++ on the inputs that benches/native.py writes; benches/native/ravengc.rs is the same for our kernels.
//
// `pinocchio INPUTS OPERATION MILLISECONDS` prints ns per call: the median of passes over all samples.
// `pinocchio INPUTS OPERATION 0` prints what was computed, a sample per line, matrices by rows.

// What pinocchio's own build system defines for everything that includes its headers.
#define BOOST_MPL_LIMIT_LIST_SIZE 30
#define BOOST_MPL_LIMIT_VECTOR_SIZE 30
#define BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS
#define BOOST_FUSION_INVOKE_MAX_ARITY 12

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

namespace pin = pinocchio;
using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Clock = std::chrono::steady_clock;

constexpr double DAMPING = 0.05;

// A link as it is read: its joint's place in the parent's frame, and what it carries.
struct Link {
    pin::SE3 placement;
    pin::Inertia inertia;
};

// A model with what its functions write to.
struct Robot {
    pin::Model model;
    pin::Data data;
    pin::FrameIndex tool;
    pin::Data::Matrix6x jacobian;
    VectorXd rates;
};

// One cycle's inputs: those of the arm, and those of the arm on a floating joint. Resolved
// rates are for the pose `near` on a path, and for a `twist` of the tool: the six numbers of the base's turning again.
struct Sample {
    VectorXd q, v, a;
    Vector3d g;
    VectorXd floating_q, floating_v, floating_a;
    VectorXd near;
    Vector6d twist;
};

// What was read: the arm on a level base, the arm on a floating joint without gravity, and the samples.
struct Inputs {
    Robot fixed, floating;
    std::vector<Sample> samples;
};

VectorXd vector(std::istream &file, int size) {
    VectorXd x(size);
    for (double &entry : x) file >> entry;
    return x;
}

Link link(std::istream &file) {
    Matrix3d rotation, moment;
    const VectorXd rows = vector(file, 9);
    rotation << rows.head<3>().transpose(), rows.segment<3>(3).transpose(), rows.tail<3>().transpose();
    const Vector3d place = vector(file, 3);
    const double mass = vector(file, 1)[0];
    const Vector3d com = vector(file, 3);
    const VectorXd I = vector(file, 6);
    moment << I[0], I[1], I[2], I[1], I[3], I[4], I[2], I[4], I[5];
    return {pin::SE3(rotation, place), pin::Inertia(mass, com, moment)};
}

// The chain of these links on `base`; the model has the universe at 0, so the first link of a fixed arm hangs there.
Robot robot(pin::Model model, pin::JointIndex joint, const std::vector<Link> &links, const Vector3d &tool) {
    for (const Link &link : links) {
        joint = model.addJoint(joint, pin::JointModelRZ(), link.placement, "joint " + std::to_string(joint));
        model.appendBodyToJoint(joint, link.inertia, pin::SE3::Identity());
    }
    const pin::Frame frame("tool", joint, 0, pin::SE3(Matrix3d::Identity(), tool), pin::OP_FRAME);
    const auto index = model.addFrame(frame);
    return {model, pin::Data(model), index, pin::Data::Matrix6x::Zero(6, model.nv), VectorXd::Zero(model.nv)};
}

Robot fixed(const std::vector<Link> &links, const Vector3d &tool, const Vector3d &level) {
    pin::Model model;
    model.gravity.linear() = level;
    return robot(model, 0, links, tool);
}

Robot floating(const std::vector<Link> &links, const Vector3d &tool) {
    pin::Model model;
    model.gravity.setZero();
    const auto base = model.addJoint(0, pin::JointModelFreeFlyer(), pin::SE3::Identity(), "base");
    return robot(model, base, links, tool);
}

// Without gravity the floating base's acceleration is the specific force.
Sample sample(std::istream &file, int n) {
    const VectorXd q = vector(file, n), v = vector(file, n), a = vector(file, n);
    const Vector3d g = vector(file, 3), f = vector(file, 3), w = vector(file, 3), dw = vector(file, 3);
    const VectorXd near = vector(file, n);
    VectorXd floating_q(7 + n), floating_v(6 + n), floating_a(6 + n);
    floating_q << VectorXd::Unit(7, 6), q;
    floating_v << Vector3d::Zero(), w, v;
    floating_a << f, dw, a;
    Vector6d twist;
    twist << w, dw;
    return {q, v, a, g, floating_q, floating_v, floating_a, near, twist};
}

Inputs read(const char *path) {
    std::ifstream file(path);
    file.exceptions(std::ios::failbit | std::ios::badbit);
    int links_count = 0, samples_count = 0;
    file >> links_count >> samples_count;
    std::vector<Link> links;
    for (int i = 0; i < links_count; ++i) links.push_back(link(file));
    const Vector3d tool = vector(file, 3), level = vector(file, 3);
    std::vector<Sample> samples;
    for (int k = 0; k < samples_count; ++k) samples.push_back(sample(file, links_count));
    return {fixed(links, tool, level), floating(links, tool), samples};
}

void gravity(Inputs &arm, const Sample &s) {
    arm.fixed.model.gravity.linear() = s.g;
    pin::computeGeneralizedGravity(arm.fixed.model, arm.fixed.data, s.q);
}

void kinematics(Inputs &arm, const Sample &s) {
    pin::forwardKinematics(arm.fixed.model, arm.fixed.data, s.q);
    pin::updateFramePlacement(arm.fixed.model, arm.fixed.data, arm.fixed.tool);
}

// As fast as computeJointJacobians and getFrameJacobian.
void jacobian(Inputs &arm, const Sample &s) {
    auto &[model, data, tool, out, rates] = arm.fixed;
    pin::computeFrameJacobian(model, data, s.q, tool, pin::LOCAL_WORLD_ALIGNED, out);
}

void inverse_dynamics(Inputs &arm, const Sample &s) { pin::rnea(arm.fixed.model, arm.fixed.data, s.q, s.v, s.a); }

void moving_base(Inputs &arm, const Sample &s) {
    pin::rnea(arm.floating.model, arm.floating.data, s.floating_q, s.floating_v, s.floating_a);
}

// J' (J J' + lambda^2 1)^-1 times the twist.
void resolved_rate(Inputs &arm, const Sample &s) {
    auto &[model, data, tool, J, rates] = arm.fixed;
    pin::computeFrameJacobian(model, data, s.near, tool, pin::LOCAL_WORLD_ALIGNED, J);
    Matrix6d A = J * J.transpose();
    A.diagonal().array() += DAMPING * DAMPING;
    const Vector6d y = A.llt().solve(s.twist);
    rates.noalias() = J.transpose() * y;
}

// Computes from one sample; `numbers` are then what it left behind.
struct Operation {
    void (*call)(Inputs &, const Sample &);
    MatrixXd (*numbers)(const Inputs &);
};

const std::map<std::string, Operation> OPERATIONS{
    {"gravity", {gravity, [](const Inputs &arm) -> MatrixXd { return arm.fixed.data.g; }}},
    {"kinematics",
     {kinematics,
      [](const Inputs &arm) -> MatrixXd { return arm.fixed.data.oMf[arm.fixed.tool].toHomogeneousMatrix(); }}},
    {"jacobian", {jacobian, [](const Inputs &arm) -> MatrixXd { return arm.fixed.jacobian; }}},
    {"inverse_dynamics", {inverse_dynamics, [](const Inputs &arm) -> MatrixXd { return arm.fixed.data.tau; }}},
    {"moving_base",
     {moving_base,
      [](const Inputs &arm) -> MatrixXd { return arm.floating.data.tau.tail(arm.fixed.model.nv); }}},
    {"resolved_rate", {resolved_rate, [](const Inputs &arm) -> MatrixXd { return arm.fixed.rates; }}},
};

void print(Inputs &arm, const Operation &operation) {
    const Eigen::IOFormat row(Eigen::FullPrecision, Eigen::DontAlignCols, " ", " ");
    for (const Sample &sample : arm.samples) {
        operation.call(arm, sample);
        std::cout << operation.numbers(arm).format(row) << '\n';
    }
}

// Time of one call in ns, from a pass over all samples. The compiler must believe that every result is read.
double pass(Inputs &arm, const Operation &operation) {
    const auto begin = Clock::now();
    for (const Sample &sample : arm.samples) {
        operation.call(arm, sample);
        asm volatile("" : : "r"(&arm) : "memory");
    }
    const std::chrono::duration<double, std::nano> taken = Clock::now() - begin;
    return taken.count() / static_cast<double>(arm.samples.size());
}

double median(Inputs &arm, const Operation &operation, std::chrono::milliseconds duration) {
    std::vector<double> passes;
    for (const auto end = Clock::now() + duration; Clock::now() < end;) passes.push_back(pass(arm, operation));
    const auto middle = passes.begin() + static_cast<std::ptrdiff_t>(passes.size() / 2);
    std::nth_element(passes.begin(), middle, passes.end());
    return *middle;
}

int main(int count, char **arguments) {
    if (count != 4) {
        std::cerr << "INPUTS OPERATION MILLISECONDS\n";
        return 2;
    }
    Inputs arm = read(arguments[1]);
    const Operation &operation = OPERATIONS.at(arguments[2]);
    const std::chrono::milliseconds duration(std::atoi(arguments[3]));
    if (duration.count() == 0) {
        print(arm, operation);
    } else {
        std::cout << median(arm, operation, duration) << '\n';
    }
}
