//! The robot: a tree of bodies lowered once to the tables that the kernels read.

use crate::constants::MAX_JOINTS;
use crate::coupling::Coupling;
use crate::dh::Placement;
use crate::error::ModelError;
use crate::joint::Joint;
use crate::spatial::{Inertia, Pose};
use core::ops::{Deref, DerefMut};
use nalgebra::{Matrix3, Vector3};

/// One number per coordinate: positions (rad, m), rates, or efforts (N·m, N). Entries beyond the robot's own are ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joints(pub [f64; MAX_JOINTS]);

impl Joints {
    /// The first [`MAX_JOINTS`] numbers of `x`, then zeros.
    #[inline]
    #[must_use]
    pub fn from_slice(x: &[f64]) -> Self {
        let mut joints = Self::default();
        for (to, from) in joints.0.iter_mut().zip(x) {
            *to = *from;
        }
        joints
    }
}

impl Deref for Joints {
    type Target = [f64; MAX_JOINTS];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Joints {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// What a frame stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// The base frame B: z up when the arm is mounted level.
    Base,
    /// Frame 0 of the links, which the robot's base pose places in B.
    Root,
    /// A moving body.
    Body(usize),
}

/// A frame rigidly attached to a body or to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub(crate) carrier: Carrier,
    pub(crate) pose: Pose,
}

impl Frame {
    /// The base frame B.
    pub const BASE: Self = Self { carrier: Carrier::Base, pose: Pose::IDENTITY };

    /// Frame 0 of the links: the parent of a robot's first link.
    pub const ROOT: Self = Self { carrier: Carrier::Root, pose: Pose::IDENTITY };

    /// The frame that `pose` places in this one.
    #[must_use]
    pub fn then(&self, pose: Pose) -> Self {
        Self { carrier: self.carrier, pose: self.pose * pose }
    }

    /// The moving body that carries the frame.
    #[must_use]
    pub const fn body(&self) -> Option<usize> {
        match self.carrier {
            Carrier::Body(body) => Some(body),
            Carrier::Base | Carrier::Root => None,
        }
    }
}

/// A moving body as it was given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body {
    pub parent: Option<usize>,
    pub joint: Joint,
    /// The joint's frame at coordinate zero, in the parent body's frame (in frame 0 for a body on the base).
    pub before: Pose,
    /// The link frame of the robot's file in the body's frame.
    pub link: Pose,
    /// Without payload, in the body's frame.
    pub inertia: Inertia,
}

/// What the gravity kernel reads of a body: 136 bytes, side by side, because a paced loop runs on cold caches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    /// F: body axes at coordinate zero in the parent's axes.
    pub rotation: Matrix3<f64>,
    /// M p: mass carried by the joint times the joint's place in the parent's frame.
    pub offset_moment: Vector3<f64>,
    /// m c: the body's own first moment.
    pub first_moment: Vector3<f64>,
    /// M: mass of the body and all that it carries.
    pub carried: f64,
    /// The joint is prismatic.
    pub slides: bool,
}

/// What the dynamics kernels read of a body beyond its [`Load`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// p: the joint's place in the parent's frame.
    pub position: Vector3<f64>,
    /// m, the body's own.
    pub mass: f64,
    /// I about the body frame's origin, the body's own.
    pub second_moment: Matrix3<f64>,
}

const NO_LOAD: Load = Load {
    rotation: *Pose::IDENTITY.rotation(),
    offset_moment: Vector3::new(0.0, 0.0, 0.0),
    first_moment: Vector3::new(0.0, 0.0, 0.0),
    carried: 0.0,
    slides: false,
};

const NO_LINK: Link =
    Link { position: Vector3::new(0.0, 0.0, 0.0), mass: 0.0, second_moment: *Inertia::ZERO.second_moment() };

const NO_BODY: Body =
    Body { parent: None, joint: Joint::Fixed, before: Pose::IDENTITY, link: Pose::IDENTITY, inertia: Inertia::ZERO };

/// A robot of 1 to 16 moving bodies. Built by [`RobotBuilder`]; every number in it has been checked.
///
/// Payload, tool and base pose may change between cycles; that neither allocates nor costs more than one cycle.
#[derive(Clone, Debug)]
pub struct Robot {
    bodies: usize,
    serial: bool,
    pub(crate) loads: [Load; MAX_JOINTS],
    pub(crate) links: [Link; MAX_JOINTS],
    /// 1 for a revolute joint, 0 for a prismatic one.
    pub(crate) turning: [f64; MAX_JOINTS],
    /// All bits set for a body, none beyond the last one: side by side for the sines.
    pub(crate) used: [u64; MAX_JOINTS],
    /// Parent of each body; a body on the base has its own index.
    pub(crate) parents: [usize; MAX_JOINTS],
    /// Bit j of entry i is set where body j is body i or carries it.
    pub(crate) ancestors: [u16; MAX_JOINTS],
    coupling: Option<Coupling>,
    tool: Frame,
    base: Pose,
    base_inertia: Inertia,
    payload: Inertia,
    payload_on: Carrier,
    given: [Body; MAX_JOINTS],
}

impl Robot {
    /// Coordinates: the length of q and of τ.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.coupling.map_or(self.bodies, |c| c.coordinates())
    }

    /// Moving bodies, at most [`MAX_JOINTS`].
    #[inline(always)]
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.bodies.min(MAX_JOINTS)
    }

    /// Each body rides on the one before it.
    #[inline(always)]
    #[must_use]
    pub(crate) const fn serial(&self) -> bool {
        self.serial
    }

    /// How the mechanism's joints follow the coordinates, where they are not the same.
    #[inline(always)]
    #[must_use]
    pub const fn coupling(&self) -> Option<&Coupling> {
        self.coupling.as_ref()
    }

    /// Body `i` is `body` or carries it.
    #[inline(always)]
    #[must_use]
    pub(crate) const fn carries(&self, i: usize, body: usize) -> bool {
        self.ancestors[body] >> i & 1 == 1
    }

    /// Kind of joint of a body.
    #[must_use]
    pub fn joint(&self, body: usize) -> Joint {
        self.given.get(body).map_or(Joint::Fixed, |b| b.joint)
    }

    /// The link frame of body `body` as the robot's file defines it; the base frame B beyond the last body.
    #[must_use]
    pub fn link_frame(&self, body: usize) -> Frame {
        if body < self.bodies() {
            Frame { carrier: Carrier::Body(body), pose: self.given[body].link }
        } else {
            Frame::BASE
        }
    }

    /// The tool frame.
    #[inline(always)]
    #[must_use]
    pub const fn tool(&self) -> &Frame {
        &self.tool
    }

    /// Replaces the tool frame. A payload stays where it is.
    pub fn set_tool(&mut self, tool: Frame) {
        self.tool = tool;
    }

    /// Pose of frame 0 of the links in the base frame B.
    #[must_use]
    pub const fn base(&self) -> &Pose {
        &self.base
    }

    /// Replaces the pose of frame 0 in the base frame B. Frames on [`Carrier::Root`] move with it.
    pub fn set_base(&mut self, base: Pose) {
        self.base = base;
        self.refresh();
    }

    /// Attaches a payload given in the tool frame, in place of the one before.
    pub fn set_payload(&mut self, payload: Inertia) {
        self.payload = payload.seen_from(&self.tool.pose);
        self.payload_on = self.tool.carrier;
        self.refresh();
    }

    /// Takes the payload off; nothing is left of it.
    pub fn clear_payload(&mut self) {
        self.payload = Inertia::ZERO;
        self.payload_on = Carrier::Base;
        self.refresh();
    }

    /// Inertia of body `body` with what is rigidly attached to it, payload included, in its link frame.
    #[must_use]
    pub fn inertia(&self, body: usize) -> Inertia {
        self.loaded(body).seen_from(&self.given[body].link.inverse())
    }

    /// What is fixed to the base, payload included, seen from the base frame B.
    #[must_use]
    pub fn base_inertia(&self) -> Inertia {
        let own = self.base_inertia.seen_from(&self.base);
        match self.payload_on {
            Carrier::Base => own + self.payload,
            Carrier::Root => own + self.payload.seen_from(&self.base),
            Carrier::Body(_) => own,
        }
    }

    /// Body `body` with the payload if it carries it, in the body's frame.
    fn loaded(&self, body: usize) -> Inertia {
        let own = self.given[body].inertia;
        if self.payload_on == Carrier::Body(body) { own + self.payload } else { own }
    }

    /// Recomputes the tables from what was given: the base pose, bodies and payload.
    fn refresh(&mut self) {
        let mut carried = [0.0; MAX_JOINTS];
        for i in (0..self.bodies()).rev() {
            let body = self.given[i];
            let inertia = self.loaded(i);
            carried[i] += inertia.mass();
            if let Some(parent) = body.parent {
                carried[parent] += carried[i];
            }
            let before = if body.parent.is_none() { self.base * body.before } else { body.before };
            let turning = if body.joint == Joint::Revolute { 1.0 } else { 0.0 };
            self.turning[i] = turning;
            self.used[i] = u64::MAX;
            self.loads[i] = Load {
                rotation: *before.rotation(),
                offset_moment: carried[i] * before.translation(),
                first_moment: *inertia.first_moment(),
                carried: carried[i],
                slides: body.joint == Joint::Prismatic,
            };
            self.links[i] =
                Link { position: *before.translation(), mass: inertia.mass(), second_moment: *inertia.second_moment() };
        }
    }
}

/// Collects links, parents first, and checks each as it comes.
#[derive(Clone, Debug)]
pub struct RobotBuilder {
    bodies: usize,
    given: [Body; MAX_JOINTS],
    base_inertia: Inertia,
}

impl Default for RobotBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl RobotBuilder {
    /// No links yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { bodies: 0, given: [NO_BODY; MAX_JOINTS], base_inertia: Inertia::ZERO }
    }

    /// Adds a link on the frame of its parent (the first one on [`Frame::ROOT`]) and returns the link's own frame.
    ///
    /// `inertia` is in the link frame. A fixed link is merged into the body that carries it.
    ///
    /// # Errors
    /// [`ModelError::BodyCount`] for a moving body too many.
    pub fn link(
        &mut self,
        parent: &Frame,
        joint: Joint,
        placement: &Placement,
        inertia: &Inertia,
    ) -> Result<Frame, ModelError> {
        if joint == Joint::Fixed {
            let frame = parent.then(placement.before * placement.after);
            let seen = inertia.seen_from(&frame.pose);
            match frame.body() {
                Some(body) => self.given[body].inertia = self.given[body].inertia + seen,
                None => self.base_inertia = self.base_inertia + seen,
            }
            return Ok(frame);
        }
        let Some(body) = self.given.get_mut(self.bodies) else {
            return Err(ModelError::BodyCount { found: MAX_JOINTS + 1 });
        };
        *body = Body {
            parent: parent.body(),
            joint,
            before: parent.pose * placement.before,
            link: placement.after,
            inertia: inertia.seen_from(&placement.after),
        };
        self.bodies += 1;
        Ok(Frame { carrier: Carrier::Body(self.bodies - 1), pose: placement.after })
    }

    /// The finished robot: `base` places frame 0 in the base frame B, `tool` is the default frame.
    ///
    /// # Errors
    /// [`ModelError::BodyCount`] without a moving body; [`ModelError::CouplingShape`] for a coupling of another robot.
    pub fn build(self, base: Pose, tool: Frame, coupling: Option<Coupling>) -> Result<Robot, ModelError> {
        if self.bodies == 0 {
            return Err(ModelError::BodyCount { found: 0 });
        }
        if let Some(c) = coupling.filter(|c| c.bodies() != self.bodies) {
            return Err(ModelError::CouplingShape { found: (c.bodies(), c.coordinates()), bodies: self.bodies });
        }
        let mut robot = Robot {
            bodies: self.bodies,
            serial: (0..self.bodies).all(|i| self.given[i].parent == i.checked_sub(1)),
            loads: [NO_LOAD; MAX_JOINTS],
            links: [NO_LINK; MAX_JOINTS],
            turning: [0.0; MAX_JOINTS],
            used: [0; MAX_JOINTS],
            parents: [0; MAX_JOINTS],
            ancestors: [0; MAX_JOINTS],
            coupling,
            tool,
            base,
            base_inertia: self.base_inertia,
            payload: Inertia::ZERO,
            payload_on: Carrier::Base,
            given: self.given,
        };
        for i in 0..self.bodies {
            let above = self.given[i].parent.map_or(0, |parent| robot.ancestors[parent]);
            robot.parents[i] = self.given[i].parent.unwrap_or(i);
            robot.ancestors[i] = above | 1 << i;
        }
        robot.refresh();
        Ok(robot)
    }
}
