//! No entry point touches the heap: a counting allocator sees nothing in a million cycles.

use crate::builds::{Build, WIDTH, builds};
use gravcomp::accelerometer::{self, Policy, Sample};
use gravcomp::control::{Event, Inputs, Kernels, Law, Settings};
use gravcomp::dh::explicit;
use gravcomp::elastic::{self, Stiffness, Variant};
use gravcomp::predictor::Settings as PredictorSettings;
use gravcomp::resolved_rate::{self, Goal, Priority};
use gravcomp::{
    Accelerometer, BaseMotion, Controller, Coupling, DhRow, ElasticGravity, Frame, Gravity, ImuSample, Inertia,
    JacobianAxes, Joint, Joints, MAX_JOINTS, ResolvedRate,
};
use gravcomp::{Mounting, PARAMETERS, Pose, Predictor, Robot, RobotBuilder, SpecificForce, Transmission};
use nalgebra::{Matrix3, Vector3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

/// The system's allocator with a count of the calls that each thread makes.
struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    CALLS.with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call is handed on to the system's allocator as it came; the count is a plain thread-local number.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count();
        // SAFETY: `block` came from `alloc` above, so from the system's allocator, with this layout.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Of a chain of seven joints.
const CYCLES: u32 = 1_000_000;

/// Of what takes longer: matrices, and everything on a tree of sixteen bodies.
const SLOW_CYCLES: u32 = 50_000;

/// Calls of the allocator while `cycle` runs, again and again, at angles that differ.
pub fn calls_during(cycles: u32, mut cycle: impl FnMut(&Joints)) -> u64 {
    let before = CALLS.get();
    let mut q = Joints::default();
    for k in 0..cycles {
        q[k as usize % MAX_JOINTS] += 0.01;
        cycle(&q);
    }
    CALLS.get() - before
}

/// Seven joints in a chain, the fourth one sliding, as stiff on paper as an arm of that size is.
pub fn chain() -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for k in 0..7 {
        let joint = if k == 3 { Joint::Prismatic } else { Joint::Revolute };
        let row = DhRow { alpha: 1.57, a: 0.1, d: 0.2, theta: 0.3 }.modified().expect("finite");
        frame = builder.link(&frame, joint, &row, &brick()).expect("seven bodies");
    }
    builder.build(Pose::IDENTITY, frame, None).expect("seven bodies")
}

/// Sixteen bodies on branches, driven by four coordinates.
fn tree() -> Robot {
    let (mut builder, mut frames) = (RobotBuilder::new(), vec![Frame::ROOT]);
    for (k, height) in (0..MAX_JOINTS).zip(1_u8..) {
        let joint = if k % 3 == 1 { Joint::Prismatic } else { Joint::Revolute };
        let placement = explicit(Pose::IDENTITY, &Vector3::new(1.0, 0.5, height.into()), joint).expect("an axis");
        frames.push(builder.link(&frames[k / 2], joint, &placement, &brick()).expect("sixteen bodies"));
    }
    let C: Vec<f64> = (0..MAX_JOINTS).flat_map(|i| (0..4).map(move |j| if i % 4 == j { 1.0 } else { 0.1 })).collect();
    let coupling = Coupling::new(&C, &[0.1; MAX_JOINTS], 4).expect("full rank");
    builder.build(Pose::IDENTITY, frames[MAX_JOINTS], Some(coupling)).expect("sixteen bodies")
}

fn brick() -> Inertia {
    Inertia::new(2.0, Vector3::new(0.05, 0.01, 0.1), [0.02, 0.0, 0.001, 0.03, 0.0, 0.025]).expect("a body")
}

fn moving_base() -> BaseMotion {
    BaseMotion {
        specific_force: SpecificForce(Vector3::new(0.5, -1.0, 9.5)),
        angular_velocity: Vector3::new(0.1, 0.2, 0.3),
        angular_acceleration: Vector3::new(1.0, -2.0, 0.5),
    }
}

/// The allocator's calls of every entry point of a build, by name.
fn calls_of(build: &Build, robot: &Robot, cycles: u32) -> Vec<(&'static str, u64)> {
    let (g, base, tool) = (Gravity::LEVEL, moving_base(), *robot.tool());
    let mut Y = vec![0.0; robot.coordinates() * PARAMETERS * robot.bodies()];
    vec![
        ("gravity_torque", calls_during(cycles, |q| sink((build.gravity_torque)(robot, q, &g)))),
        (
            "gravity_torques",
            calls_during(cycles / 8, |q| {
                sink((build.gravity_torques)(robot, &q.map(|q| [q; WIDTH]), &[[1.0; WIDTH]; 3]));
            }),
        ),
        ("forward_kinematics", calls_during(cycles, |q| sink((build.forward_kinematics)(robot, q, &tool)))),
        ("jacobian", calls_during(cycles, |q| sink(build.jacobian(robot, q, &tool, JacobianAxes::Frame)))),
        ("inverse_dynamics", calls_during(cycles, |q| sink((build.inverse_dynamics)(robot, q, q, q, &base)))),
        ("base_wrench", calls_during(cycles, |q| sink((build.base_wrench)(robot, q, q, q, &base)))),
        ("mass_matrix", calls_during(SLOW_CYCLES, |q| sink(build.mass_matrix(robot, q)))),
        ("forward_dynamics", calls_during(SLOW_CYCLES, |q| sink((build.forward_dynamics)(robot, q, q, q, &base)))),
        ("gravity_stiffness", calls_during(SLOW_CYCLES, |q| sink(build.gravity_stiffness(robot, q, &g)))),
        ("potential_energy", calls_during(cycles, |q| sink((build.potential_energy)(robot, q, &g)))),
        ("center_of_mass", calls_during(cycles, |q| sink((build.center_of_mass)(robot, q)))),
        (
            "gravity_regressor",
            calls_during(SLOW_CYCLES, |q| (build.gravity_regressor)(robot, q, &g, black_box(&mut Y))),
        ),
        (
            "inverse_dynamics_regressor",
            calls_during(SLOW_CYCLES, |q| {
                (build.inverse_dynamics_regressor)(robot, q, q, q, &base, black_box(&mut Y));
            }),
        ),
    ]
}

fn sink<T>(x: T) {
    black_box(x);
}

#[test]
fn the_count_sees_the_heap() {
    assert_eq!(calls_during(10, |q| sink(Box::new(*q))), 20);
}

#[test]
fn a_chain_computes_without_the_heap() {
    for build in builds() {
        for (name, calls) in calls_of(&build, &chain(), CYCLES) {
            assert_eq!(calls, 0, "{}::{name}", build.name);
        }
    }
}

#[test]
fn a_coupled_tree_computes_without_the_heap() {
    for build in builds() {
        for (name, calls) in calls_of(&build, &tree(), SLOW_CYCLES) {
            assert_eq!(calls, 0, "{}::{name}", build.name);
        }
    }
}

#[test]
fn huge_angles_and_nan_take_no_heap_either() {
    let (robot, g) = (chain(), Gravity::LEVEL);
    for build in builds() {
        for bad in [1e5, 1e300, f64::NAN, f64::INFINITY] {
            let calls = calls_during(1000, |q| {
                sink((build.gravity_torque)(&robot, &Joints(q.map(|q| q + bad)), &g));
            });
            assert_eq!(calls, 0, "{} at {bad}", build.name);
        }
    }
}

#[test]
fn changes_between_cycles_take_no_heap() {
    let mut robot = tree();
    let mounting = Mounting::new(Matrix3::identity(), Vector3::x()).expect("a rotation");
    let gears = Transmission::new(&[2.0, 0.0, 1.0, -3.0], &[0.1, 0.2]).expect("can be inverted");
    let calls = calls_during(SLOW_CYCLES, |q| {
        let payload = Inertia::new(q[0].abs(), Vector3::x(), [0.0; 6]).expect("a point mass");
        let pose = Pose::new(Matrix3::identity(), Vector3::new(q[1], 0.0, 0.0), "base").expect("a rotation");
        robot.set_payload(payload);
        robot.set_base(pose);
        robot.set_tool(robot.link_frame(3).then(pose));
        let sample = ImuSample { specific_force: Vector3::new(q[2], 0.0, 9.8), ..ImuSample::default() };
        sink(BaseMotion::from_imu(&sample, &mounting));
        sink(robot.inertia(0));
        robot.clear_payload();
        sink(gears.motor_efforts(&gears.joint_positions(q)));
        sink(gears.joint_efforts(&gears.motor_positions(q)));
    });
    assert_eq!(calls, 0);
}

#[test]
fn building_a_robot_takes_no_heap() {
    assert_eq!(calls_during(1000, |_| sink(chain())), 0);
}

#[test]
fn the_accelerometer_takes_no_heap_whatever_comes_in() {
    for policy in [Policy::Paper, Policy::Strict] {
        let settings = accelerometer::Settings { policy, ..accelerometer::Settings::default() };
        let mut chain = Accelerometer::new(settings).expect("the defaults make sense");
        let (mut seq, mut now_ns) = (0, 0);
        let calls = calls_during(CYCLES, |q| {
            (seq, now_ns) = (seq + 1, now_ns + 1_000_000);
            let spell = seq / 1000 % 4;
            let specific_force = Vector3::new(q[0].sin(), if spell == 1 { f64::NAN } else { q[1].cos() }, 9.8);
            let sample = Sample { seq, stamp_ns: now_ns, specific_force, angular_velocity: Some(Vector3::x()) };
            sink(chain.step(now_ns, Some(&sample).filter(|_| spell != 2 && seq % 10 == 0)));
            if spell == 3 {
                chain.acknowledge();
            }
        });
        assert_eq!(calls, 0);
        assert!(chain.counters().accepted > 0);
    }
    assert_eq!(calls_during(1000, |_| sink(Accelerometer::new(accelerometer::Settings::default()))), 0);
}

fn elastic_calls(robot: &Robot, cycles: u32) -> u64 {
    let n = robot.coordinates();
    let (lower, upper, mut bound) = (Joints([-1.0; MAX_JOINTS]), Joints([1.0; MAX_JOINTS]), vec![0.0; n * n]);
    let mut calls = calls_during(100, |_| {
        elastic::stiffness_bound(robot, &lower, &upper, elastic::Field::Anyhow, black_box(&mut bound));
        sink(Stiffness::coupled(&[1.0, 0.5, 0.5, 1.0], 2));
    });
    for variant in [Variant::Desired, Variant::Motor, Variant::Biased, Variant::QuasiStatic, Variant::Link] {
        let settings = elastic::Settings { variant, contraction: 0.05, iterations: 9, tolerance: 1e-9 };
        let mut law = ElasticGravity::new(Stiffness::each(&[1000.0; MAX_JOINTS][..n]).expect("positive"), settings);
        calls += calls_during(cycles, |q| {
            sink(gravcomp::portable::elastic_gravity(robot, &mut law, q, q, q, &Gravity::LEVEL));
        });
    }
    calls
}

#[test]
fn laws_of_elastic_joints_take_no_heap() {
    let (robot, base) = (chain(), moving_base());
    for variant in [Variant::Desired, Variant::Motor, Variant::Biased, Variant::QuasiStatic, Variant::Link] {
        let settings = elastic::Settings { variant, contraction: 0.05, iterations: 9, tolerance: 1e-9 };
        let springs = ElasticGravity::new(Stiffness::each(&[1000.0; 7]).expect("positive"), settings);
        let law =
            Controller::new(Settings::of(Law::PdBaseMotion, 7), Kernels::PORTABLE).expect("settings that make sense");
        let mut law = law.with_elastic(springs).expect("springs that fit");
        law.arm();
        let calls = calls_during(SLOW_CYCLES, |q| {
            let inputs = Inputs {
                q,
                qd: None,
                q_link: Some(q),
                q_desired: q,
                qd_desired: q,
                base: &base,
                disturbances: None,
                armable: true,
            };
            sink(law.step(&robot, &inputs));
        });
        assert_eq!(calls, 0, "{variant:?}");
    }
}

#[test]
fn gravity_for_elastic_joints_takes_no_heap() {
    assert_eq!(elastic_calls(&chain(), CYCLES / 8), 0);
    assert_eq!(elastic_calls(&tree(), SLOW_CYCLES), 0);
}

#[test]
fn control_laws_take_no_heap_whatever_comes_in() {
    let (robot, base) = (chain(), moving_base());
    for law in Law::ALL {
        let limited =
            Settings { jump: Joints([0.5; MAX_JOINTS]), modulus: Joints([6.3; MAX_JOINTS]), ..Settings::of(law, 7) };
        let mut controller = Controller::new(limited, Kernels::PORTABLE).expect("settings that make sense");
        controller.arm();
        let mut cycle = 0;
        let calls = calls_during(CYCLES / 8, |q| {
            cycle += 1;
            let bad = if cycle / 1000 % 3 == 1 { f64::NAN } else { 0.0 };
            let wrapped = Joints(q.map(|q| q % 6.3 + bad));
            let inputs = Inputs {
                q: &wrapped,
                qd: None,
                q_link: Some(q),
                q_desired: q,
                qd_desired: q,
                base: &base,
                disturbances: None,
                armable: true,
            };
            sink(controller.step(&robot, &inputs));
            if cycle % 3000 == 0 {
                controller.acknowledge();
            }
        });
        assert_eq!(calls, 0, "{law:?}");
        assert!(controller.counters().of(Event::Fault) > 1);
    }
}

#[test]
fn the_predictor_learns_and_predicts_without_the_heap() {
    let mut predictor = Predictor::new(PredictorSettings::default()).expect("the defaults make sense");
    let mut t: f64 = 0.0;
    let calls = calls_during(SLOW_CYCLES, |q| {
        t += 1.0 / 30.0;
        let place = Vector3::new(t.sin(), (1.3 * t).cos(), q[0].sin()) * 0.01;
        sink(predictor.update(t, &place));
        sink((predictor.predict(t + 0.1), predictor.velocity(t + 0.1), predictor.covariance(t + 0.1)));
        sink((predictor.amplitude(), predictor.frequency(), predictor.chosen(), predictor.notes()));
        if q[0] > 20.0 {
            predictor.reset();
        }
    });
    assert_eq!(calls, 0);
}

#[test]
fn resolved_rate_takes_no_heap_whatever_comes_in() {
    for build in builds() {
        for priority in Priority::ALL {
            for robot in [chain as fn() -> Robot, tree] {
                assert_eq!(calls_of_rates(&build, &robot(), priority), 0);
            }
        }
    }
}

fn calls_of_rates(build: &Build, robot: &Robot, priority: Priority) -> u64 {
    let settings = resolved_rate::Settings {
        priority,
        qd_max: Joints([1.0; MAX_JOINTS]),
        qdd_max: Joints([10.0; MAX_JOINTS]),
        ..resolved_rate::Settings::of(robot.coordinates())
    };
    let mut rate = ResolvedRate::new(settings).expect("settings that make sense");
    calls_during(SLOW_CYCLES / 10, |q| {
        for twist in [[1.0; 6], [f64::NAN; 6]] {
            let inputs = resolved_rate::Inputs {
                q,
                goal: Goal::Move(&twist),
                base_twist: Some(&twist),
                base_in_doubt: false,
                dt: 1e-3,
            };
            (build.resolved_rate)(robot, &mut rate, &inputs);
            black_box(rate.output());
        }
    })
}
