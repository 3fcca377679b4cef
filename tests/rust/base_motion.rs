//! A base that moves: the same as one more joint that nobody commands; and what its sensor reads.

use crate::arms::{Arm, State, arms, axis, pose, states, turn, vector};
use crate::builds::builds;
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::dh::explicit;
use gravcomp::{BaseMotion, Frame, Gravity, ImuSample, Inertia, Joint, Joints, ModelError, Mounting, Pose, Robot};
use gravcomp::{RobotBuilder, STANDARD_GRAVITY, SpecificForce};
use nalgebra::{Matrix3, Vector3, Vector6};
use proptest::prelude::*;

/// The joint that moves the base: where it stands on the floor, its axis, and the arm's base in the moved frame.
#[derive(Clone, Debug)]
struct Rocker {
    joint: Joint,
    origin: Pose,
    axis: Vector3<f64>,
    mount: Pose,
}

fn rockers() -> impl Strategy<Value = Rocker> {
    let joint = prop_oneof![Just(Joint::Revolute), Just(Joint::Prismatic)];
    (joint, pose(), axis(), pose()).prop_map(|(joint, origin, axis, mount)| Rocker { joint, origin, axis, mount })
}

impl Rocker {
    /// The arm on a massless link that the joint moves; the arm's base pose in B stands on the mount.
    fn carry(&self, arm: &Arm) -> Robot {
        let mut builder = RobotBuilder::new();
        let placement = explicit(self.origin, &self.axis, self.joint).expect("a unit axis");
        let rock = builder.link(&Frame::ROOT, self.joint, &placement, &Inertia::ZERO).expect("the first body");
        let frames = arm.grow(&mut builder, rock.then(self.mount * arm.base));
        builder.build(Pose::IDENTITY, arm.tool_on(&frames), None).expect("a drawn arm can exist")
    }

    /// Motion of the arm's B, in its axes, when the floor moves so and the joint is at (q, q̇, q̈).
    fn motion(&self, floor: &BaseMotion, [q, qd, qdd]: [f64; 3]) -> BaseMotion {
        let turns = self.joint == Joint::Revolute;
        let (Q, d) = if turns { (turn(&self.axis, q), 0.0) } else { (Matrix3::identity(), q) };
        let (R, z) = (self.origin.rotation() * Q, self.axis);
        let p = self.origin.translation() + self.origin.rotation() * (d * z);
        let (w, dw) = (floor.angular_velocity, floor.angular_acceleration);
        let f = R.transpose() * (floor.specific_force.0 + dw.cross(&p) + w.cross(&w.cross(&p)));
        let (w, dw) = (R.transpose() * w, R.transpose() * dw);
        let (w, dw, f) = if turns {
            (w + qd * z, dw + qd * w.cross(&z) + qdd * z, f)
        } else {
            (w, dw, f + 2.0 * qd * w.cross(&z) + qdd * z)
        };
        let (S, r) = (self.mount.rotation().transpose(), self.mount.translation());
        BaseMotion {
            specific_force: SpecificForce(S * (f + dw.cross(r) + w.cross(&w.cross(r)))),
            angular_velocity: S * w,
            angular_acceleration: S * dw,
        }
    }

    /// The share of the mount's wrench that the joint's actuator would carry.
    fn effort(&self, wrench: &Vector6<f64>) -> f64 {
        let (S, r) = (self.mount.rotation(), self.mount.translation());
        let (force, moment) = (S * wrench.fixed_rows::<3>(0), S * wrench.fixed_rows::<3>(3));
        match self.joint {
            Joint::Revolute => self.axis.dot(&(moment + r.cross(&force))),
            _ => self.axis.dot(&force),
        }
    }
}

/// The joint's own number, then the arm's.
fn after(first: f64, rest: &Joints) -> Joints {
    Joints(core::array::from_fn(|i| if i == 0 { first } else { rest[i - 1] }))
}

/// All that moves or is fixed to the base, with its centre in B.
fn total(robot: &Robot, center: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let moving: f64 = (0..robot.bodies()).map(|body| robot.inertia(body).mass()).sum();
    let fixed = robot.base_inertia();
    (moving + fixed.mass(), moving * center + fixed.first_moment())
}

proptest! {
    #![proptest_config(cases(1000))]

    /// N + 1 joints on a moving floor and N joints on the base that the first one moves feel the same; and the wrench
    /// through the mount is what the first joint carries, so the base's power is accounted for.
    #[test]
    fn a_rocking_base_is_one_more_joint(arm in arms(), rocker in rockers(), state in states(), rock in vector(3.0)) {
        let arm = arm.uncoupled();
        prop_assume!(arm.moving().len() < 16);
        let (whole, robot) = (rocker.carry(&arm), arm.build());
        let base = rocker.motion(&state.base, rock.into());
        let State { q, qd, qdd, base: floor } = &state;
        let [on_base, on_floor] = [base, *floor].map(|base| Scale::of(&arm, &State { base, ..state.clone() }).moment());
        let bound = ROUNDING * (on_base + on_floor) * (1.0 + rocker.mount.translation().norm());
        let n = robot.coordinates();
        for build in builds() {
            let (q1, qd1, qdd1) = (after(rock.x, q), after(rock.y, qd), after(rock.z, qdd));
            let outer = (build.inverse_dynamics)(&whole, &q1, &qd1, &qdd1, floor);
            let inner = (build.inverse_dynamics)(&robot, q, qd, qdd, &base);
            close(build.name, &outer[1..=n], &inner[..n], bound)?;
            let wrench = (build.base_wrench)(&robot, q, qd, qdd, &base);
            close("mount", &[outer[0]], &[rocker.effort(&wrench)], bound)?;
        }
    }

    #[test]
    fn the_mount_of_a_resting_arm_carries_its_weight(arm in arms(), state in states()) {
        let (robot, state) = (arm.build(), state.at_rest());
        let (g, bound) = (state.gravity().0, ROUNDING * Scale::of(&arm, &state).moment());
        for build in builds() {
            let center = (build.center_of_mass)(&robot, &state.q);
            prop_assume!(center.x.is_finite());
            let (mass, moment) = total(&robot, &center);
            let wrench = (build.base_wrench)(&robot, &state.q, &state.qd, &state.qdd, &state.base);
            let (force, turning) = (-mass * g, -moment.cross(&g));
            close(build.name, wrench.as_slice(), &[force.as_slice(), turning.as_slice()].concat(), bound)?;
        }
    }

    /// A sensor at r on a base that turns about B's origin reads the base's own motion and that of its place.
    #[test]
    fn an_imu_anywhere_tells_the_motion_of_the_base_origin(
        mounting in pose(), g in vector(20.0), a in vector(5.0), w in vector(3.0), dw in vector(3.0)
    ) {
        let (R, r) = (mounting.rotation(), mounting.translation());
        let there = a + dw.cross(r) + (w * w.dot(r) - r * w.norm_squared());
        let sample = ImuSample {
            specific_force: R.transpose() * (there - g),
            angular_velocity: R.transpose() * w,
            angular_acceleration: R.transpose() * dw,
        };
        let base = BaseMotion::from_imu(&sample, &Mounting::new(*R, *r).expect("a rotation"));
        close("f", base.specific_force.0.as_slice(), (a - g).as_slice(), 1e-13)?;
        close("w", base.angular_velocity.as_slice(), w.as_slice(), 1e-14)?;
        close("dw", base.angular_acceleration.as_slice(), dw.as_slice(), 1e-14)?;
    }

    #[test]
    fn gravity_and_specific_force_are_opposite(v in vector(20.0)) {
        let (g, f) = (Gravity(v), SpecificForce(v));
        prop_assert_eq!(SpecificForce::from(g).0, -v);
        prop_assert_eq!(Gravity::from(f).0, -v);
        prop_assert_eq!(Gravity::from(SpecificForce::from(g)), g);
        let base = BaseMotion::at_rest(g);
        prop_assert_eq!(base.specific_force.0, -v);
        prop_assert_eq!((base.angular_velocity, base.angular_acceleration), (Vector3::zeros(), Vector3::zeros()));
    }

    #[test]
    fn mirrored_mountings_are_refused(mounting in pose(), row in 0..3_usize) {
        let mut mirror = *mounting.rotation();
        mirror.row_mut(row).neg_mut();
        let refused = Mounting::new(mirror, Vector3::zeros());
        prop_assert_eq!(refused, Err(ModelError::Mirrored { field: "sensor mounting" }));
    }
}

#[test]
fn level_gravity_points_down_and_its_accelerometer_up() {
    assert_eq!(Gravity::LEVEL.0, Vector3::new(0.0, 0.0, -STANDARD_GRAVITY));
    assert_eq!(SpecificForce::from(Gravity::LEVEL).0, Vector3::new(0.0, 0.0, STANDARD_GRAVITY));
}

#[test]
fn an_imu_at_the_base_origin_needs_no_mounting() {
    let sample = ImuSample { specific_force: Vector3::new(1.0, 2.0, 3.0), ..ImuSample::default() };
    let base = BaseMotion::from_imu(&sample, &Mounting::default());
    assert_eq!(base, BaseMotion::at_rest(Gravity(-sample.specific_force)));
}
