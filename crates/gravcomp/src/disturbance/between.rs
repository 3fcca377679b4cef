//! Coil springs between points of two bodies.

use crate::constants::MAX_JOINTS;
use crate::error::{SettingsError, within};
use crate::kinematics::{Axes, Column, vector};
use crate::lanes::{cross, dot};
use crate::motion::{JointsNow, to_coordinates};
use crate::robot::{Carrier, Frame, Joints, Robot};
use crate::sweep;
use nalgebra::{ComplexField, Vector3};

/// A spring of unit stiffness: its ends, points of bodies or of the base, and its length without force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    ends: [(Carrier, Vector3<f64>); 2],
    rest_length: f64,
}

/// Where all bodies are.
pub(super) struct Places<const FUSED: bool> {
    bodies: [Axes<FUSED>; MAX_JOINTS],
    root: Axes<FUSED>,
}

impl<const FUSED: bool> Places<FUSED> {
    #[inline(always)]
    pub(super) fn of(robot: &Robot, now: &JointsNow<'_, 1, FUSED>) -> Self {
        let root = Axes::constant(robot.base().rotation(), robot.base().translation());
        let mut places = Self { bodies: [Axes::BASE; MAX_JOINTS], root };
        sweep::outward(
            robot,
            Axes::BASE,
            #[inline(always)]
            |i, above| {
                places.bodies[i] = above.carry(robot, now, i);
                places.bodies[i]
            },
        );
        places
    }

    /// A point of a body, in B.
    #[inline(always)]
    fn point(&self, carrier: Carrier, point: &Vector3<f64>) -> Column<FUSED> {
        let axes = match carrier {
            Carrier::Base => &Axes::BASE,
            Carrier::Root => &self.root,
            Carrier::Body(body) => self.bodies.get(body).unwrap_or(&self.root),
        };
        axes.place((*point).into())
    }
}

impl Between {
    pub(super) fn new(a: &Frame, b: &Frame, rest_length: f64) -> Result<Self, SettingsError> {
        within("rest_length", rest_length, 0.0, super::LARGEST, "0 to 1e9 m")?;
        if a.body() == b.body() {
            let wanted = "on another body than the first one, with a joint between them";
            return Err(SettingsError { field: "body_b", joint: None, value: f64::NAN, wanted });
        }
        let ends = [a, b].map(|end| (end.carrier, *end.pose.translation()));
        for x in ends.iter().flat_map(|(_, point)| point) {
            within("point", *x, -super::LARGEST, super::LARGEST, "a finite number of at most 1e9")?;
        }
        Ok(Self { ends, rest_length })
    }

    /// ∂/∂q of (l − l₀)²/2 at the coordinates: (1 − l₀/l) dᵀ ∂d/∂q with d from one end to the other and l = |d|.
    ///
    /// A joint that carries one end moves it by z × (p − o) if it turns and by z if it slides; one that carries both, or
    /// none, does not change l. Where the ends meet, a spring with a rest length has no direction, and no effort.
    #[inline(always)]
    pub(super) fn efforts<const FUSED: bool>(&self, robot: &Robot, places: &Places<FUSED>) -> Joints {
        let at = self.ends.map(
            #[inline(always)]
            |(carrier, point)| places.point(carrier, &point),
        );
        let d = vector(&(at[0] - at[1]));
        let squared = dot(&d, &d).0[0];
        let share = if self.rest_length == 0.0 {
            1.0
        } else if squared == 0.0 {
            0.0
        } else {
            1.0 - self.rest_length / ComplexField::sqrt(squared)
        };
        let mut efforts = [[0.0]; MAX_JOINTS];
        for i in 0..robot.bodies() {
            let [first, second] = self.ends.map(
                #[inline(always)]
                |(carrier, _)| carries(robot, i, carrier),
            );
            if first != second {
                let (end, sign) = if first { (&at[0], share) } else { (&at[1], -share) };
                let axes = &places.bodies[i];
                let z = vector(&axes.z);
                let moved = if robot.loads[i].slides { z } else { cross(&z, &vector(&(*end - axes.origin))) };
                efforts[i] = [sign * dot(&d, &moved).0[0]];
            }
        }
        to_coordinates::<1, FUSED>(robot, &mut efforts);
        Joints(efforts.map(
            #[inline(always)]
            |[effort]| effort,
        ))
    }
}

#[inline(always)]
fn carries(robot: &Robot, i: usize, carrier: Carrier) -> bool {
    match carrier {
        Carrier::Base | Carrier::Root => false,
        Carrier::Body(body) => robot.ancestors.get(body).is_some_and(|ancestors| ancestors >> i & 1 == 1),
    }
}
