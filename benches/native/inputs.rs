//! The file of inputs: numbers, separated by blanks, in an order that `Inputs::read` follows.

use gravcomp::spatial::{Inertia, Pose};
use gravcomp::{BaseMotion, Frame, Gravity, Joint, Joints, ModelError, Placement, Robot, RobotBuilder, SpecificForce};
use nalgebra::{Matrix3, Vector3};
use std::str::{FromStr, SplitWhitespace};

/// The arm and what it is to compute with.
pub struct Inputs {
    pub robot: Robot,
    pub samples: Vec<Sample>,
}

/// One cycle's inputs; `rest` is the level base. Resolved rates are for the pose `near` on a path, and for a `twist` of the
/// tool: the six numbers of the base's turning again.
pub struct Sample {
    pub q: Joints,
    pub qd: Joints,
    pub qdd: Joints,
    pub g: Gravity,
    pub moving: BaseMotion,
    pub rest: BaseMotion,
    pub near: Joints,
    pub twist: [f64; 6],
}

impl Inputs {
    /// Counts of links and samples, the links, the tool, gravity at rest, the samples.
    pub fn read(text: &str) -> Result<Self, ModelError> {
        let mut numbers = Numbers(text.split_whitespace());
        let (links, samples) = (numbers.next(), numbers.next());
        let robot = numbers.robot(links)?;
        let rest = BaseMotion::at_rest(Gravity(numbers.vector()));
        let samples = (0..samples).map(|_: usize| numbers.sample(links, rest)).collect();
        Ok(Self { robot, samples })
    }
}

/// The numbers that are still to be read.
struct Numbers<'a>(SplitWhitespace<'a>);

impl Numbers<'_> {
    fn next<T: FromStr>(&mut self) -> T {
        self.0.next().and_then(|word| word.parse().ok()).expect("the file of inputs holds another number")
    }

    fn array<const N: usize>(&mut self) -> [f64; N] {
        [0.0; N].map(|_| self.next())
    }

    fn vector(&mut self) -> Vector3<f64> {
        self.array().into()
    }

    fn joints(&mut self, n: usize) -> Joints {
        Joints::from_slice(&(0..n).map(|_| self.next()).collect::<Vec<_>>())
    }

    /// A chain of `n` links, each turning about the z axis of its own frame, with a tool that is not turned.
    fn robot(&mut self, n: usize) -> Result<Robot, ModelError> {
        let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
        for _ in 0..n {
            let rotation = Matrix3::from_row_slice(&self.array::<9>());
            let placement = Placement { before: Pose::new(rotation, self.vector(), "link")?, after: Pose::IDENTITY };
            let inertia = Inertia::new(self.next(), self.vector(), self.array())?;
            frame = builder.link(&frame, Joint::Revolute, &placement, &inertia)?;
        }
        let tool = Pose::new(Matrix3::identity(), self.vector(), "tool")?;
        builder.build(Pose::IDENTITY, frame.then(tool), None)
    }

    fn sample(&mut self, n: usize, rest: BaseMotion) -> Sample {
        let (q, qd, qdd) = (self.joints(n), self.joints(n), self.joints(n));
        let g = Gravity(self.vector());
        let moving = BaseMotion {
            specific_force: SpecificForce(self.vector()),
            angular_velocity: self.vector(),
            angular_acceleration: self.vector(),
        };
        let (w, dw) = (moving.angular_velocity, moving.angular_acceleration);
        let near = self.joints(n);
        Sample { q, qd, qdd, g, moving, rest, near, twist: [w.x, w.y, w.z, dw.x, dw.y, dw.z] }
    }
}
