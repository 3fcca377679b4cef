//! How stiff gravity can be, proven: a bound on every entry of ∂g/∂q, whatever the angles.
//!
//! For joints i ≤ j on one path, |∂gᵢ/∂qⱼ| = |(g × zᵢ) · Dⱼ| (see `energy`), with Dⱼ = zⱼ × uⱼ for a joint that turns, Mⱼ zⱼ for one
//! that slides, and 0 if i slides. uⱼ, the first moment that joint j carries, is made of vectors that keep their length:
//!
//! > uⱼ = hⱼ + Σ over the joints c that body j carries of Mc pc + Fc Rz(qc) uc.
//!
//! Where c turns, what uc has along its axis stays where it is in body j, and what it has across only turns: so each uⱼ is a
//! vector fixed in body j, `fixed`, and something no longer than `loose`. Where c slides, it adds Mc qc along its axis.

use crate::constants::MAX_JOINTS;
use crate::robot::{Joints, Robot};
use core::ops::RangeInclusive;
use nalgebra::{ComplexField, Vector3};

/// Which gravities occur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Field {
    /// One direction in base axes, of length 1.
    Along(Vector3<f64>),
    /// All directions: the base may stand anyhow.
    Anyhow,
}

/// Part of a first moment: fixed in the body's axes, and of bounded length.
#[derive(Clone, Copy, Debug)]
struct Moment {
    fixed: Vector3<f64>,
    loose: f64,
}

impl Moment {
    const ZERO: Self = Self { fixed: Vector3::new(0.0, 0.0, 0.0), loose: 0.0 };

    /// Longest that it can be across z.
    fn across(&self) -> f64 {
        length(self.fixed.x, self.fixed.y) + self.loose
    }
}

fn length(x: f64, y: f64) -> f64 {
    ComplexField::sqrt(x * x + y * y)
}

/// `a b`, and 0 where `a` is, even if `b` is infinite: what is not there has no effect however far it goes.
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a * b }
}

/// Writes a bound on |∂gᵢ/∂qⱼ| in a field of 1 m/s², coordinates × coordinates, row by row: for any angles, and coordinates
/// within `lower` and `upper` as far as shifts depend on them (infinite bounds give infinite entries). Nothing is written
/// where `out` has no room for it.
pub fn stiffness_bound(robot: &Robot, lower: &Joints, upper: &Joints, field: Field, out: &mut [f64]) {
    let n = robot.coordinates();
    let Some(out) = out.get_mut(..n * n) else { return };
    out.fill(0.0);
    let mut carried = [Moment::ZERO; MAX_JOINTS];
    for j in (0..robot.bodies()).rev() {
        let moment = carry(robot, &mut carried, j, &shifts(robot, lower, upper, j));
        let reach = if robot.loads[j].slides { robot.loads[j].carried } else { moment.across() };
        for i in (0..=j).filter(|&i| robot.carries(i, j) && !robot.loads[i].slides) {
            add(robot, out, (i, j), product(across(robot, i, field), reach));
        }
    }
}

/// The first moment of what joint `j` carries; adds what body `j`'s parent sees of it.
fn carry(robot: &Robot, carried: &mut [Moment; MAX_JOINTS], j: usize, shifts: &RangeInclusive<f64>) -> Moment {
    let load = &robot.loads[j];
    let own = Moment { fixed: load.first_moment + carried[j].fixed, loose: carried[j].loose };
    let (stays, loose) = if load.slides {
        let middle = 0.5 * (shifts.start() + shifts.end());
        let middle = if middle.is_finite() { middle } else { 0.0 };
        let half = (shifts.end() - middle).max(middle - shifts.start());
        (own.fixed + Vector3::new(0.0, 0.0, load.carried * middle), own.loose + product(load.carried, half))
    } else {
        (Vector3::new(0.0, 0.0, own.fixed.z), own.across())
    };
    if robot.parents[j] != j {
        let parent = &mut carried[robot.parents[j]];
        parent.fixed += load.offset_moment + load.rotation * stays;
        parent.loose += loose;
    }
    own
}

/// Where joint `j` of the mechanism can slide to.
fn shifts(robot: &Robot, lower: &Joints, upper: &Joints, j: usize) -> RangeInclusive<f64> {
    let Some(coupling) = robot.coupling() else { return lower[j]..=upper[j] };
    let offset = coupling.offset()[j];
    let (mut least, mut most) = (offset, offset);
    for (k, column) in coupling.columns().iter().enumerate().filter(|(_, column)| column[j] != 0.0) {
        let (a, b) = (column[j] * lower[k], column[j] * upper[k]);
        (least, most) = (least + a.min(b), most + a.max(b));
    }
    least..=most
}

/// Largest |g × zᵢ| in a field of 1 m/s². The axis of a joint that nothing turns stands still in base axes.
fn across(robot: &Robot, i: usize, field: Field) -> f64 {
    let turned = (0..i).any(|k| robot.carries(k, i) && !robot.loads[k].slides);
    match field {
        Field::Along(g) if !turned => g.cross(&still_axis(robot, i)).norm(),
        _ => 1.0,
    }
}

/// zᵢ in base axes where only sliding joints carry joint `i`.
fn still_axis(robot: &Robot, i: usize) -> Vector3<f64> {
    let mut axis = Vector3::z();
    let mut body = i;
    loop {
        axis = robot.loads[body].rotation * axis;
        if robot.parents[body] == body {
            return axis;
        }
        body = robot.parents[body];
    }
}

/// Adds the bound of entry (i, j) of the mechanism, and of (j, i), to the coordinates': |C|ᵀ B |C|.
fn add(robot: &Robot, out: &mut [f64], (i, j): (usize, usize), bound: f64) {
    let n = robot.coordinates();
    let Some(coupling) = robot.coupling() else {
        (out[i * n + j], out[j * n + i]) = (bound, bound);
        return;
    };
    for (a, of_a) in coupling.columns().iter().enumerate() {
        for (b, of_b) in coupling.columns().iter().enumerate() {
            let both = of_a[i].abs() * of_b[j].abs() + if i == j { 0.0 } else { of_a[j].abs() * of_b[i].abs() };
            out[a * n + b] += product(both, bound);
        }
    }
}
