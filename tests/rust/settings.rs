//! What was set last is all that a robot remembers: base, tool, and payload with the tool that it was attached to.

use crate::arms::{Arm, State, arms, body, pose, states};
use crate::builds::builds;
use crate::same_bits::everything;
use crate::scale::cases;
use gravcomp::{Frame, Inertia, Pose, Robot};
use proptest::collection::vec;
use proptest::prelude::*;

/// What may change at run time.
#[derive(Clone, Copy, Debug)]
enum Change {
    Base(Pose),
    /// On frame 0, on the base frame B, or on the link whose number is what remains.
    Tool(usize, Pose),
    Payload(Inertia),
    NoPayload,
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let one = prop_oneof![
        pose().prop_map(Change::Base),
        (0..64_usize, pose()).prop_map(|(on, pose)| Change::Tool(on, pose)),
        body(0.0).prop_map(Change::Payload),
        Just(Change::NoPayload),
    ];
    vec(one, 0..8)
}

/// Base, tool, payload and the tool of its time: the words that repeat a history.
struct Last {
    base: Pose,
    tool: Frame,
    payload: Option<(Inertia, Frame)>,
}

/// Makes the changes and keeps count.
fn change(robot: &mut Robot, links: &[Frame], history: &[Change]) -> Last {
    let frames: Vec<Frame> = [Frame::ROOT, Frame::BASE].into_iter().chain(links.iter().copied()).collect();
    let mut last = Last { base: *robot.base(), tool: *robot.tool(), payload: None };
    for &change in history {
        match change {
            Change::Base(base) => {
                robot.set_base(base);
                last.base = base;
            }
            Change::Tool(on, pose) => {
                last.tool = frames[on % frames.len()].then(pose);
                robot.set_tool(last.tool);
            }
            Change::Payload(payload) => {
                robot.set_payload(payload);
                last.payload = Some((payload, last.tool));
            }
            Change::NoPayload => {
                robot.clear_payload();
                last.payload = None;
            }
        }
    }
    last
}

/// A robot as it was built, set once.
fn set_once(arm: &Arm, last: &Last) -> Robot {
    let mut robot = arm.build();
    if let Some((payload, tool)) = last.payload {
        robot.set_tool(tool);
        robot.set_payload(payload);
    }
    robot.set_tool(last.tool);
    robot.set_base(last.base);
    robot
}

fn bits(robot: &Robot, state: &State) -> Vec<Vec<u64>> {
    let computed = builds().map(|build| everything(&build, robot, state));
    let inertias = (0..robot.bodies()).map(|i| robot.inertia(i)).chain([robot.base_inertia()]);
    computed.chain(inertias.map(|inertia| inertia.parameters().map(f64::to_bits).to_vec())).collect()
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_history_is_its_last_words(arm in arms(), history in changes(), state in states()) {
        let (mut robot, links) = arm.build_with_frames();
        let last = change(&mut robot, &links, &history);
        let again = set_once(&arm, &last);
        prop_assert_eq!((again.base(), again.tool()), (robot.base(), robot.tool()));
        prop_assert_eq!(bits(&again, &state), bits(&robot, &state));
        prop_assert_eq!(bits(&robot.clone(), &state), bits(&robot, &state));
    }

    #[test]
    fn what_is_taken_back_leaves_no_trace(arm in arms(), history in changes(), state in states()) {
        let (mut robot, links) = arm.build_with_frames();
        change(&mut robot, &links, &history);
        robot.clear_payload();
        robot.set_tool(arm.tool_on(&links));
        robot.set_base(arm.base);
        prop_assert_eq!(bits(&robot, &state), bits(&arm.build(), &state));
    }
}
