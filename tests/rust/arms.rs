//! Random robots as data that proptest can print and shrink, and what they are doing.

use gravcomp::dh::explicit;
use gravcomp::{BaseMotion, Coupling, DhRow, Frame, Gravity, Inertia, Joint, Joints, Placement, Pose};
use gravcomp::{MAX_JOINTS, Robot, RobotBuilder, SpecificForce};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// One link and the joint that carries it.
#[derive(Clone, Debug)]
pub struct Link {
    /// 0 for frame 0, else one more than the index of the link that carries this one.
    pub parent: usize,
    pub joint: Joint,
    pub placement: Placement,
    pub inertia: Inertia,
}

/// C row by row, and c₀.
#[derive(Clone, Debug)]
pub struct Mimics {
    pub matrix: Vec<Vec<f64>>,
    pub offset: Vec<f64>,
}

/// A robot as it is drawn, before it is built.
#[derive(Clone, Debug)]
pub struct Arm {
    pub links: Vec<Link>,
    pub base: Pose,
    pub tool: Pose,
    /// Index of the link that carries the tool.
    pub tip: usize,
    pub coupling: Option<Mimics>,
}

impl Arm {
    /// Adds the links to `builder`, the first ones on `root`, and returns their frames.
    pub fn grow(&self, builder: &mut RobotBuilder, root: Frame) -> Vec<Frame> {
        let mut frames = vec![root];
        for link in &self.links {
            let frame = builder.link(&frames[link.parent], link.joint, &link.placement, &link.inertia);
            frames.push(frame.expect("an arm has at most 16 bodies"));
        }
        frames.split_off(1)
    }

    pub fn tool_on(&self, frames: &[Frame]) -> Frame {
        frames[self.tip].then(self.tool)
    }

    pub fn build(&self) -> Robot {
        self.build_with_frames().0
    }

    /// The robot, and the frames of its links (fixed ones too) in order.
    pub fn build_with_frames(&self) -> (Robot, Vec<Frame>) {
        let mut builder = RobotBuilder::new();
        let frames = self.grow(&mut builder, Frame::ROOT);
        let coupling = self.coupling.as_ref().map(Mimics::checked);
        (builder.build(self.base, self.tool_on(&frames), coupling).expect("a drawn arm can exist"), frames)
    }

    /// The same mechanism with a coordinate for every joint.
    pub fn uncoupled(&self) -> Self {
        Self { coupling: None, ..self.clone() }
    }

    /// Indices of the links that move, in order: body i is link `moving()[i]`.
    pub fn moving(&self) -> Vec<usize> {
        (0..self.links.len()).filter(|&k| self.links[k].joint != Joint::Fixed).collect()
    }

    pub fn coordinates(&self) -> usize {
        self.coupling.as_ref().map_or(self.moving().len(), |c| c.matrix[0].len())
    }

    /// C q (+ c₀): where the mechanism's joints are, or how fast they go.
    pub fn mechanism(&self, q: &Joints, with_offset: bool) -> Joints {
        let Some(Mimics { matrix, offset }) = &self.coupling else { return *q };
        let mut joints = Joints::default();
        for (i, (row, c0)) in matrix.iter().zip(offset).enumerate() {
            let turned: f64 = row.iter().zip(q.iter()).map(|(c, q)| c * q).sum();
            joints[i] = turned + if with_offset { *c0 } else { 0.0 };
        }
        joints
    }

    /// Link `k` and the links that carry it, outermost first.
    pub fn path(&self, k: usize) -> Vec<usize> {
        std::iter::successors(Some(k), |&k| self.links[k].parent.checked_sub(1)).collect()
    }

    /// Bodies that carry body `i`, are carried by it, or are it: those that feel its position.
    pub fn related(&self, i: usize) -> Vec<usize> {
        let moving = self.moving();
        let carries = |a: usize, b: usize| self.path(moving[b]).contains(&moving[a]);
        (0..moving.len()).filter(|&j| carries(i, j) || carries(j, i)).collect()
    }
}

impl Mimics {
    pub fn checked(&self) -> Coupling {
        Coupling::new(&self.matrix.concat(), &self.offset, self.matrix[0].len()).expect("drawn with full rank")
    }
}

/// What a robot and its base are doing. Entries beyond the robot's own are drawn too: they must not matter.
#[derive(Clone, Debug)]
pub struct State {
    pub q: Joints,
    pub qd: Joints,
    pub qdd: Joints,
    pub base: BaseMotion,
}

impl State {
    /// The gravity field in which a base at rest feels the state's specific force.
    pub fn gravity(&self) -> Gravity {
        self.base.specific_force.into()
    }

    /// The same pose under the same gravity, everything at rest.
    pub fn at_rest(&self) -> Self {
        let still = Joints::default();
        Self { q: self.q, qd: still, qdd: still, base: BaseMotion::at_rest(self.gravity()) }
    }
}

pub fn length() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 3 => -0.8..0.8]
}

pub fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(FRAC_PI_2), Just(-FRAC_PI_2), Just(PI), -PI..PI, -PI..PI]
}

pub fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-size..size, -size..size, -size..size].prop_map(Vector3::from)
}

/// A unit vector: along a coordinate axis, or anywhere.
pub fn axis() -> impl Strategy<Value = Vector3<f64>> {
    let oblique = (0.0..PI, -PI..PI).prop_map(|(polar, azimuth): (f64, f64)| {
        Vector3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    });
    prop_oneof![Just(Vector3::z()), Just(Vector3::x()), Just(Vector3::y()), Just(-Vector3::z()), oblique]
}

/// The rotation about a unit vector.
pub fn turn(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Unit::new_unchecked(*axis), angle).into_inner()
}

pub fn pose() -> impl Strategy<Value = Pose> {
    (axis(), angle(), [length(), length(), length()])
        .prop_map(|(axis, angle, p)| Pose::new(turn(&axis, angle), p.into(), "drawn").expect("a rotation"))
}

pub fn dh_row() -> impl Strategy<Value = DhRow> {
    (angle(), length(), length(), angle()).prop_map(|(alpha, a, d, theta)| DhRow { alpha, a, d, theta })
}

/// A body with mass `m` whose spread is `A Aᵀ`, A lower triangular: I = tr(m A Aᵀ) 1 − m A Aᵀ, so it can exist.
pub fn body(thinnest: f64) -> impl Strategy<Value = Inertia> {
    let widths = [thinnest..0.2, thinnest..0.2, thinnest..0.2];
    (0.1..5.0, vector(0.3), widths, vector(0.1)).prop_map(|(m, com, w, skew): (f64, _, _, Vector3<f64>)| {
        let A = Matrix3::new(w[0], 0.0, 0.0, skew.x, w[1], 0.0, skew.y, skew.z, w[2]);
        let spread: Matrix3<f64> = m * A * A.transpose();
        let I = Matrix3::identity() * spread.trace() - spread;
        Inertia::new(m, com, [I.m11, I.m12, I.m13, I.m22, I.m23, I.m33]).expect("a cloud of mass")
    })
}

fn joint() -> impl Strategy<Value = Joint> {
    prop_oneof![3 => Just(Joint::Revolute), 2 => Just(Joint::Prismatic), 1 => Just(Joint::Fixed)]
}

/// A joint placed by a standard row, a modified row, or an explicit frame and axis.
fn placed_joint() -> impl Strategy<Value = (Joint, Placement)> {
    (joint(), 0..3, dh_row(), pose(), axis()).prop_map(|(joint, kind, row, origin, axis)| {
        let placement = match kind {
            0 => row.standard(),
            1 => row.modified(),
            _ => explicit(origin, &axis, joint),
        };
        (joint, placement.expect("finite numbers and a unit axis"))
    })
}

fn link(body: BoxedStrategy<Inertia>) -> impl Strategy<Value = Link> {
    (0..64_usize, placed_joint(), body).prop_map(|(parent, (joint, placement), inertia)| Link {
        parent,
        joint,
        placement,
        inertia,
    })
}

/// Numbers from which a coupling of any number of bodies can be made.
type Mixture = (usize, usize, Vec<f64>, Vec<f64>);

fn mixture() -> impl Strategy<Value = Option<Mixture>> {
    let own = proptest::sample::select(vec![1.0, -1.0, 0.5, 2.0]);
    let whole = (0..MAX_JOINTS, 0..MAX_JOINTS, vec(own, MAX_JOINTS), vec(-1.0..1.0, MAX_JOINTS * MAX_JOINTS));
    proptest::option::weighted(0.3, whole)
}

/// One joint per coordinate moves with it and with the coordinate before; the others mix all coordinates. Full rank.
fn mimics(bodies: usize, (columns, shift, own, mix): Mixture) -> Mimics {
    let columns = 1 + columns % bodies;
    let entry = |i: usize, j: usize| match (i < columns, j) {
        (true, j) if j == i => own[j],
        (true, j) if j + 1 == i => mix[j],
        (true, _) => 0.0,
        (false, j) => mix[i * MAX_JOINTS + j],
    };
    let row = |i: usize| (0..columns).map(|j| entry((i + shift) % bodies, j)).collect();
    Mimics { matrix: (0..bodies).map(row).collect(), offset: mix[..bodies].to_vec() }
}

/// Parents before children: each link on the one before, or on any earlier one or frame 0. The first link moves.
fn tied(mut links: Vec<Link>, serial: bool) -> Vec<Link> {
    for (k, link) in links.iter_mut().enumerate() {
        link.parent = if serial { k } else { link.parent % (k + 1) };
    }
    if links.iter().all(|link| link.joint == Joint::Fixed) {
        links[0].joint = Joint::Revolute;
    }
    links
}

fn arms_of(body: BoxedStrategy<Inertia>) -> impl Strategy<Value = Arm> {
    let few = vec(link(body.clone()), 1..=8);
    let many = vec(link(body), 9..=MAX_JOINTS);
    let links = (prop_oneof![4 => few, 1 => many], any::<bool>()).prop_map(|(links, serial)| tied(links, serial));
    (links, pose(), pose(), 0..64_usize, mixture()).prop_map(|(links, base, tool, tip, mixture)| {
        let bodies = links.iter().filter(|link| link.joint != Joint::Fixed).count();
        let coupling = mixture.map(|mixture| mimics(bodies, mixture));
        Arm { tip: tip % links.len(), links, base, tool, coupling }
    })
}

/// Any robot: points, rods, plates and massless links among its bodies.
pub fn arms() -> impl Strategy<Value = Arm> {
    arms_of(prop_oneof![1 => Just(Inertia::ZERO), 7 => body(0.0)].boxed())
}

/// Any robot whose links have mass and extent: M is positive definite.
pub fn solid_arms() -> impl Strategy<Value = Arm> {
    arms_of(body(0.02).boxed())
}

pub fn joints(size: f64) -> impl Strategy<Value = Joints> {
    proptest::array::uniform16(-size..size).prop_map(Joints)
}

fn base_motion() -> impl Strategy<Value = BaseMotion> {
    (vector(20.0), vector(3.0), vector(3.0)).prop_map(|(f, angular_velocity, angular_acceleration)| BaseMotion {
        specific_force: SpecificForce(f),
        angular_velocity,
        angular_acceleration,
    })
}

pub fn states() -> impl Strategy<Value = State> {
    (joints(PI), joints(3.0), joints(10.0), base_motion()).prop_map(|(q, qd, qdd, base)| State { q, qd, qdd, base })
}
