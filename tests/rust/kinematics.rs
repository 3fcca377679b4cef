//! Where frames are and how they move.

use crate::arms::{Arm, arms, states, turn};
use crate::builds::{Build, JacobianColumns, builds};
use crate::scale::{DIFFERENCE, ROUNDING, Scale, cases, close, derivative, moved, unit};
use gravcomp::{Frame, JacobianAxes, Joint, Joints, Pose, Robot};
use nalgebra::{Matrix3, Matrix4, Vector3};
use proptest::prelude::*;

/// The frame of link `k` in B: base pose, then before, the joint's motion, after, for each link on the way.
fn composed(arm: &Arm, q: &Joints, k: usize) -> Pose {
    let (moving, q) = (arm.moving(), arm.mechanism(q, true));
    let mut pose = arm.base;
    for link in arm.path(k).into_iter().rev() {
        let placement = &arm.links[link].placement;
        let at = moving.iter().position(|&m| m == link).map_or(0.0, |body| q[body]);
        let motion = match arm.links[link].joint {
            Joint::Revolute => Pose::new(turn(&Vector3::z(), at), Vector3::zeros(), "turn"),
            Joint::Prismatic => Pose::new(Matrix3::identity(), at * Vector3::z(), "slide"),
            Joint::Fixed => Ok(Pose::IDENTITY),
        };
        pose = pose * placement.before * motion.expect("a rotation") * placement.after;
    }
    pose
}

fn homogeneous(pose: &Pose) -> Matrix4<f64> {
    pose.rotation().to_homogeneous() + pose.translation().push(0.0) * Matrix4::<f64>::identity().row(3)
}

/// Velocity of the frame's origin and angular velocity in B for unit speed of coordinate `j`: ṗ and the vector of Ṙ Rᵀ.
fn differences(build: &Build, robot: &Robot, q: &Joints, frame: &Frame, j: usize, rate: f64) -> [f64; 6] {
    let entries = |t| -> [f64; 16] {
        (build.forward_kinematics)(robot, &moved(q, t, &unit(j)), frame).as_slice().try_into().expect("4 x 4")
    };
    let speed = Matrix4::from_column_slice(&derivative(rate, entries));
    let R = (build.forward_kinematics)(robot, q, frame).fixed_view::<3, 3>(0, 0).into_owned();
    let spin = speed.fixed_view::<3, 3>(0, 0) * R.transpose();
    [speed.m14, speed.m24, speed.m34, spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]]
}

fn frames_of(robot: &Robot, links: &[Frame]) -> Vec<Frame> {
    [*robot.tool(), Frame::BASE, Frame::ROOT].into_iter().chain(links.iter().copied()).collect()
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_link_is_where_its_joints_put_it(arm in arms(), state in states()) {
        let ((robot, frames), scale) = (arm.build_with_frames(), Scale::of(&arm, &state));
        for build in builds() {
            for (k, frame) in frames.iter().enumerate() {
                let found = (build.forward_kinematics)(&robot, &state.q, frame);
                let wanted = homogeneous(&composed(&arm, &state.q, k));
                close(build.name, found.as_slice(), wanted.as_slice(), ROUNDING * scale.lever)?;
            }
            let tool = homogeneous(&(composed(&arm, &state.q, arm.tip) * arm.tool));
            let found = (build.forward_kinematics)(&robot, &state.q, robot.tool());
            close(build.name, found.as_slice(), tool.as_slice(), ROUNDING * scale.lever)?;
            let base = (build.forward_kinematics)(&robot, &state.q, &Frame::BASE);
            prop_assert_eq!(base, Matrix4::identity());
            prop_assert_eq!((build.forward_kinematics)(&robot, &state.q, &Frame::ROOT), homogeneous(&arm.base));
        }
    }

    #[test]
    fn link_frames_are_those_of_the_moving_links(arm in arms()) {
        let (robot, frames) = arm.build_with_frames();
        for (body, &k) in arm.moving().iter().enumerate() {
            prop_assert_eq!(robot.link_frame(body), frames[k]);
            prop_assert_eq!(robot.joint(body), arm.links[k].joint);
        }
        prop_assert_eq!(robot.link_frame(robot.bodies()), Frame::BASE);
        prop_assert_eq!(robot.joint(robot.bodies()), Joint::Fixed);
    }

    #[test]
    fn the_jacobian_is_the_slope_of_the_pose(arm in arms(), state in states()) {
        let ((robot, links), scale) = (arm.build_with_frames(), Scale::of(&arm, &state));
        for build in builds() {
            for frame in frames_of(&robot, &links) {
                let jacobian = build.jacobian(&robot, &state.q, &frame, JacobianAxes::Base);
                for j in 0..robot.coordinates() {
                    let slope = differences(&build, &robot, &state.q, &frame, j, scale.gain);
                    close(build.name, jacobian[j].as_slice(), &slope, DIFFERENCE * scale.jacobian())?;
                }
            }
        }
    }

    #[test]
    fn frame_axes_turn_the_jacobian(arm in arms(), state in states()) {
        let ((robot, links), scale) = (arm.build_with_frames(), Scale::of(&arm, &state));
        for build in builds() {
            for frame in frames_of(&robot, &links) {
                let R = (build.forward_kinematics)(&robot, &state.q, &frame).fixed_view::<3, 3>(0, 0).into_owned();
                let [in_base, in_frame]: [JacobianColumns; 2] = [JacobianAxes::Base, JacobianAxes::Frame]
                    .map(|axes| build.jacobian(&robot, &state.q, &frame, axes));
                for j in 0..robot.coordinates() {
                    for rows in [0, 3] {
                        let turned = R * in_frame[j].fixed_rows::<3>(rows);
                        let wanted = in_base[j].fixed_rows::<3>(rows).into_owned();
                        close(build.name, turned.as_slice(), wanted.as_slice(), ROUNDING * scale.jacobian())?;
                    }
                }
            }
        }
    }
}
