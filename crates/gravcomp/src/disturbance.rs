//! What acts on the coordinates beside the masses: cables, springs, friction, offsets.
//!
//! Each element says which efforts the actuators must exert against it, as gravity torque does: springs give +∂U/∂q,
//! friction +F sign(v). They depend on q and q̇ alone: they are fixed to the base and do not turn with gravity.
//!
//! > τ = Σ w φ(s, ṡ),  s = vᵀq,
//!
//! with w the direction that an element acts along and v the one that it reads ([`Along`]), and for springs between two
//! bodies ([`Disturbances::between`]) τ = ∂U/∂q with U = k (l − l₀)²/2.
//!
//! | [`Shape`] | φ | parameters |
//! |---|---|---|
//! | `Polynomial` | weight · Σ c_k s^k | c₀, c₁, … |
//! | `Cable` | the same, a polynomial for each piece | of all pieces |
//! | `LinearSpring` | k (s − rest) | k |
//! | `Friction` | blend(ṡ) (F + S exp(−(ṡ/v_S)²)) + D ṡ | F, D, and with v_S S |
//! | `Constant` | τ₀ | τ₀ |
//! | `Harmonic` | a cos(ν s) + b sin(ν s) | a, b |
//!
//! All of it is linear in the parameters: torque and regressor are the same φ. The direction of motion comes in by [`Blend`],
//! as in the gravity compensation of the da Vinci Research Kit (H. Lin, C. W. V. Hui, Y. Wang, A. Deguet, P. Kazanzides,
//! K. W. S. Au, "A reliable gravity compensation control strategy for dVRK robotic arms with nonlinear disturbance forces",
//! IEEE Robotics and Automation Letters 4(4), 2019).

mod along;
mod between;
mod blend;
mod shape;

pub use along::Along;
pub use blend::{Blend, Direction};
pub use shape::{Pieces, Range, Shape};

use crate::error::{SettingsError, within};
use crate::motion::JointsNow;
use crate::robot::{Frame, Joints, Robot};
use between::Between;

/// Most elements of an arm.
pub const MAX_ELEMENTS: usize = 64;

/// Most parameters of all elements together.
pub const MAX_PARAMETERS: usize = 256;

/// Largest parameter (SI); what is larger is a slip, and could overflow.
const LARGEST: f64 = 1e9;

/// One element; its parameters start at `first`. There is no heap to put the large kind on, and most are of that kind.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant)]
enum Element {
    Along { acts: Along, reads: Along, shape: Shape, first: usize, count: usize },
    Between { spring: Between, first: usize },
}

/// The disturbance elements of one arm. Total and without heap; NaN in, NaN out.
#[derive(Clone, Debug)]
pub struct Disturbances {
    count: usize,
    columns: usize,
    springs: bool,
    elements: [Option<Element>; MAX_ELEMENTS],
    parameters: [f64; MAX_PARAMETERS],
}

impl Default for Disturbances {
    fn default() -> Self {
        Self::new()
    }
}

impl Disturbances {
    /// None yet: 30 KB, made once and kept wherever the arm's other tables are.
    #[must_use]
    #[allow(clippy::large_stack_arrays)]
    pub const fn new() -> Self {
        Self { count: 0, columns: 0, springs: false, elements: [None; MAX_ELEMENTS], parameters: [0.0; MAX_PARAMETERS] }
    }

    /// Adds an element that reads `reads` and acts along `acts`.
    ///
    /// # Errors
    /// [`SettingsError`] says which number it is, and what would be right.
    pub fn along(
        &mut self,
        acts: Along,
        reads: Along,
        shape: Shape,
        parameters: &[f64],
    ) -> Result<&mut Self, SettingsError> {
        let (first, count) = (self.columns, parameters.len());
        let shape = shape.checked(count)?;
        self.add(&Element::Along { acts, reads, shape, first, count }, parameters)
    }

    /// Adds a spring of `stiffness` (N/m) and `rest_length` (m) between the origins of two frames.
    ///
    /// # Errors
    /// [`SettingsError`] for numbers below zero and for two frames of one body.
    pub fn between(
        &mut self,
        a: &Frame,
        b: &Frame,
        rest_length: f64,
        stiffness: f64,
    ) -> Result<&mut Self, SettingsError> {
        within("stiffness", stiffness, 0.0, LARGEST, "0 to 1e9 N/m")?;
        let spring = Between::new(a, b, rest_length)?;
        self.add(&Element::Between { spring, first: self.columns }, &[stiffness])?;
        self.springs = true;
        Ok(self)
    }

    fn add(&mut self, element: &Element, parameters: &[f64]) -> Result<&mut Self, SettingsError> {
        for &parameter in parameters {
            within("parameter", parameter, -LARGEST, LARGEST, "a finite number of at most 1e9")?;
        }
        let columns = self.columns + parameters.len();
        let refused = |field, value, wanted| Err(SettingsError { field, joint: None, value, wanted });
        #[allow(clippy::cast_precision_loss)] // a count
        let (Some(free), Some(into)) =
            (self.elements.get_mut(self.count), self.parameters.get_mut(self.columns..columns))
        else {
            return refused("parameters", columns as f64, "at most 256, of at most 64 elements");
        };
        *free = Some(*element);
        into.copy_from_slice(parameters);
        (self.count, self.columns) = (self.count + 1, columns);
        Ok(self)
    }

    /// Parameters of all elements, in order: the torque is the regressor times these.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        self.parameters.get(..self.columns).unwrap_or(&[])
    }

    /// There are springs between bodies, which need to know where bodies are.
    #[must_use]
    pub(crate) const fn has_springs(&self) -> bool {
        self.springs
    }

    fn elements(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter().take(self.count).flatten()
    }

    /// Calls `give(acts, column, φ)` for every parameter of every element along joints whose φ is not zero.
    #[inline(always)]
    fn each_along(&self, q: &Joints, qd: &Joints, mut give: impl FnMut(&Along, usize, f64)) {
        for element in self.elements() {
            if let Element::Along { acts, reads, shape, first, count } = element {
                shape.values(
                    *count,
                    reads.dot(q),
                    reads.dot(qd),
                    #[inline(always)]
                    |k, phi| give(acts, first + k, phi),
                );
            }
        }
    }

    /// Calls `give(column, efforts)` for every spring between bodies, efforts at the coordinates for a unit of stiffness.
    #[inline(always)]
    fn each_spring<const FUSED: bool>(
        &self,
        robot: &Robot,
        now: &JointsNow<'_, 1, FUSED>,
        mut give: impl FnMut(usize, &Joints),
    ) {
        let places = between::Places::of(robot, now);
        for element in self.elements() {
            if let Element::Between { spring, first } = element {
                give(*first, &spring.efforts(robot, &places));
            }
        }
    }

    /// Efforts that the elements along joints take.
    #[inline(always)]
    pub(crate) fn efforts(&self, q: &Joints, qd: &Joints) -> Joints {
        let mut tau = Joints::default();
        self.each_along(
            q,
            qd,
            #[inline(always)]
            |acts, column, phi| acts.add(phi * self.parameter(column), &mut tau),
        );
        tau
    }

    /// Adds those of the springs between bodies.
    #[inline(always)]
    pub(crate) fn add_springs<const FUSED: bool>(
        &self,
        robot: &Robot,
        now: &JointsNow<'_, 1, FUSED>,
        tau: &mut Joints,
    ) {
        self.each_spring(
            robot,
            now,
            #[inline(always)]
            |column, efforts| {
                let stiffness = self.parameter(column);
                for (tau, effort) in tau.iter_mut().zip(efforts.iter()) {
                    *tau += stiffness * effort;
                }
            },
        );
    }

    /// Writes the columns of the elements along joints into `out`, a row of all parameters per coordinate.
    #[inline(always)]
    pub(crate) fn write_along(&self, q: &Joints, qd: &Joints, out: &mut [f64]) {
        out.fill(0.0);
        self.each_along(
            q,
            qd,
            #[inline(always)]
            |acts, column, phi| {
                acts.each(
                    #[inline(always)]
                    |j, share| self.put(out, j, column, share * phi),
                );
            },
        );
    }

    /// Writes those of the springs between bodies.
    #[inline(always)]
    pub(crate) fn write_springs<const FUSED: bool>(
        &self,
        robot: &Robot,
        now: &JointsNow<'_, 1, FUSED>,
        out: &mut [f64],
    ) {
        self.each_spring(
            robot,
            now,
            #[inline(always)]
            |column, efforts| {
                for (j, &effort) in efforts.iter().enumerate().take(robot.coordinates()) {
                    self.put(out, j, column, effort);
                }
            },
        );
    }

    #[inline(always)]
    fn put(&self, out: &mut [f64], row: usize, column: usize, value: f64) {
        if let Some(entry) = out.get_mut(row * self.columns + column) {
            *entry = value;
        }
    }

    #[inline(always)]
    fn parameter(&self, column: usize) -> f64 {
        self.parameters.get(column).copied().unwrap_or(0.0)
    }
}
