//! One arm described in two ways is one arm: DH conventions, payload and fixed link, base pose given early or late.

use crate::arms::{Arm, State, arms, body, dh_row, pose, states};
use crate::builds::{Build, builds};
use crate::same_bits::everything;
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::{Carrier, DhRow, Frame, Inertia, Joint, Placement, Pose, Robot, RobotBuilder};
use nalgebra::{Matrix3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;

/// Torques, mass matrix, tool pose and base wrench of two descriptions agree.
fn same(build: &Build, a: &Robot, b: &Robot, state: &State, scale: &Scale) -> Result<(), TestCaseError> {
    let n = a.coordinates();
    let State { q, qd, qdd, base } = state;
    let held = [a, b].map(|robot| (build.gravity_torque)(robot, q, &state.gravity()));
    close("gravity", &held[0][..n], &held[1][..n], ROUNDING * scale.torque())?;
    let tau = [a, b].map(|robot| (build.inverse_dynamics)(robot, q, qd, qdd, base));
    close("dynamics", &tau[0][..n], &tau[1][..n], ROUNDING * scale.torque())?;
    let M = [a, b].map(|robot| build.mass_matrix(robot, q));
    close("M", &M[0].as_flattened()[..16 * n], &M[1].as_flattened()[..16 * n], ROUNDING * scale.mass_matrix())?;
    let tool = [a, b].map(|robot| (build.forward_kinematics)(robot, q, robot.tool()));
    close("tool", tool[0].as_slice(), tool[1].as_slice(), ROUNDING * scale.lever)?;
    let wrench = [a, b].map(|robot| (build.base_wrench)(robot, q, qd, qdd, base));
    close("wrench", wrench[0].as_slice(), wrench[1].as_slice(), ROUNDING * scale.moment())
}

/// A link of a standard table: its row, and its body in the distal frame.
type Row = (DhRow, Joint, Inertia);

fn tables() -> impl Strategy<Value = Vec<Row>> {
    let joint = prop_oneof![Just(Joint::Revolute), Just(Joint::Prismatic)];
    vec((dh_row(), joint, body(0.0)), 1..=8)
}

fn serial(links: impl IntoIterator<Item = (Joint, Placement, Inertia)>, base: Pose) -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for (joint, placement, inertia) in links {
        frame = builder.link(&frame, joint, &placement, &inertia).expect("few links");
    }
    builder.build(base, frame, None).expect("at least one joint")
}

fn standard(table: &[Row], base: Pose) -> Robot {
    serial(table.iter().map(|(row, joint, body)| (*joint, row.standard().expect("finite"), *body)), base)
}

/// The same arm in modified rows: α and a of a row move to the next one, the last ones to a fixed tip, and a body moves
/// from its distal to its proximal frame.
fn modified(table: &[Row], base: Pose) -> Robot {
    let mut before = DhRow::default();
    let mut links = Vec::new();
    for (row, joint, body) in table {
        let proximal = DhRow { alpha: before.alpha, a: before.a, ..*row };
        let distal = DhRow { alpha: row.alpha, a: row.a, d: 0.0, theta: 0.0 }.modified().expect("finite").before;
        links.push((*joint, proximal.modified().expect("finite"), body.seen_from(&distal)));
        before = *row;
    }
    let tip = DhRow { alpha: before.alpha, a: before.a, d: 0.0, theta: 0.0 };
    links.push((Joint::Fixed, tip.modified().expect("finite"), Inertia::ZERO));
    serial(links, base)
}

fn described(table: &[Row], base: Pose) -> Arm {
    let link = |(k, (row, joint, body)): (usize, &Row)| crate::arms::Link {
        parent: k,
        joint: *joint,
        placement: row.standard().expect("finite"),
        inertia: *body,
    };
    let links: Vec<_> = table.iter().enumerate().map(link).collect();
    Arm { tip: links.len() - 1, links, base, tool: Pose::IDENTITY, coupling: None }
}

/// RRBot of the Gazebo tutorials: links of 0.9 m between axles, 1 kg in their middle, x of frame 0 up.
fn rrbot_base() -> Pose {
    let up = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    Pose::new(up, Vector3::zeros(), "base").expect("a rotation")
}

fn rrbot(com: f64, rows: &[Placement; 3]) -> Robot {
    let body = Inertia::new(1.0, Vector3::new(com, 0.0, 0.0), [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]).expect("a body");
    let [first, second, tip] = *rows;
    let links = [(Joint::Revolute, first, body), (Joint::Revolute, second, body), (Joint::Fixed, tip, Inertia::ZERO)];
    serial(links, rrbot_base())
}

fn row(a: f64, d: f64) -> DhRow {
    DhRow { alpha: 0.0, a, d, theta: 0.0 }
}

/// The payload as one more fixed link on the tool frame.
fn with_fixed_link(arm: &Arm, payload: &Inertia) -> Arm {
    let placement = Placement { before: arm.tool, after: Pose::IDENTITY };
    let link = crate::arms::Link { parent: arm.tip + 1, joint: Joint::Fixed, placement, inertia: *payload };
    Arm { links: arm.links.iter().cloned().chain([link]).collect(), ..arm.clone() }
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn standard_and_modified_rows_describe_one_arm(table in tables(), base in pose(), state in states()) {
        let scale = Scale::of(&described(&table, base), &state);
        for build in builds() {
            same(&build, &standard(&table, base), &modified(&table, base), &state, &scale)?;
        }
    }

    #[test]
    fn the_two_tables_of_rrbot_are_one_arm(state in states()) {
        let standard = rrbot(-0.45, &[row(0.9, 0.0), row(0.9, 0.1), row(0.0, 0.0)].map(|row| row.standard().expect("finite")));
        let modified = rrbot(0.45, &[row(0.0, 0.0), row(0.9, 0.1), row(0.9, 0.0)].map(|row| row.modified().expect("finite")));
        let body = Inertia::new(1.0, Vector3::new(-0.45, 0.0, 0.0), [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]).expect("a body");
        let table = [(row(0.9, 0.0), Joint::Revolute, body), (row(0.9, 0.1), Joint::Revolute, body)];
        let scale = Scale::of(&described(&table, rrbot_base()), &state);
        for build in builds() {
            same(&build, &standard, &modified, &state, &scale)?;
        }
    }

    #[test]
    fn a_payload_is_one_more_fixed_link(arm in arms(), payload in body(0.0), state in states()) {
        let (mut loaded, welded) = (arm.build(), with_fixed_link(&arm, &payload).build());
        loaded.set_payload(payload);
        let scale = Scale::of(&arm, &state).with(&payload);
        for build in builds() {
            same(&build, &loaded, &welded, &state, &scale)?;
        }
    }

    #[test]
    fn a_payload_taken_off_leaves_no_trace(arm in arms(), payload in body(0.0), state in states()) {
        let (plain, mut robot) = (arm.build(), arm.build());
        robot.set_payload(payload);
        robot.set_payload(Inertia::ZERO);
        for build in builds() {
            prop_assert_eq!(everything(&build, &robot, &state), everything(&build, &plain, &state));
        }
    }

    #[test]
    fn a_payload_stays_where_it_was_attached(arm in arms(), payload in body(0.0), tool in pose(), state in states()) {
        let (mut before, mut after) = (arm.build(), arm.build());
        before.set_payload(payload);
        after.set_payload(payload);
        after.set_tool(Frame::ROOT.then(tool));
        for build in builds() {
            let [a, b] = [&before, &after].map(|robot| (build.gravity_torque)(robot, &state.q, &state.gravity()));
            prop_assert_eq!(a, b);
        }
        prop_assert_eq!(after.tool(), &Frame::ROOT.then(tool));
    }

    #[test]
    fn a_payload_on_the_base_burdens_only_the_mount(
        arm in arms(), payload in body(0.0), tool in pose(), on_root in any::<bool>(), state in states()
    ) {
        let (plain, mut robot) = (arm.build(), arm.build());
        robot.set_tool(if on_root { Frame::ROOT.then(tool) } else { Frame::BASE.then(tool) });
        robot.set_payload(payload);
        let place = if on_root { arm.base * tool } else { tool };
        let wanted = plain.base_inertia() + payload.seen_from(&place);
        close("inertia", &robot.base_inertia().parameters(), &wanted.parameters(), 1e-12 * (1.0 + wanted.mass()))?;
        for build in builds() {
            let [a, b] = [&plain, &robot].map(|robot| (build.gravity_torque)(robot, &state.q, &state.gravity()));
            prop_assert_eq!(a, b);
        }
    }

    #[test]
    fn a_base_set_later_is_a_base_given(arm in arms(), base in pose(), payload in body(0.0), state in states()) {
        let (mut early, mut late) = (Arm { base, ..arm.clone() }.build(), arm.build());
        early.set_payload(payload);
        late.set_payload(payload);
        late.set_base(base);
        prop_assert_eq!(late.base(), &base);
        for build in builds() {
            prop_assert_eq!(everything(&build, &late, &state), everything(&build, &early, &state));
        }
    }

    #[test]
    fn a_tool_on_a_link_is_carried_by_its_body(arm in arms()) {
        let (robot, frames) = arm.build_with_frames();
        let carrier = arm.path(arm.tip).into_iter().find_map(|k| arm.moving().iter().position(|&m| m == k));
        prop_assert_eq!(robot.tool().body(), carrier);
        prop_assert_eq!(frames[arm.tip].body(), carrier);
        prop_assert_ne!(Carrier::Base, Carrier::Root);
    }
}
