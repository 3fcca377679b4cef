//! Arguments with one row per sample, and the threads that work through them.

use crate::arrays::{Elements, Use, as_double, elements, required};
use crate::errors::argument_error;
use crate::types::{self, base_motion, gravity};
use gravcomp::{BaseMotion, Gravity, Joints, SpecificForce};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use std::ops::Range;

/// Configurations that share the lanes of one kernel call.
pub const WIDTH: usize = 8;

pub type Array<'py> = Bound<'py, PyAny>;

/// Rows of a two-dimensional array.
fn count_of(x: &Array<'_>) -> Option<usize> {
    match x.cast::<PyUntypedArray>().ok()?.shape() {
        [rows, _] => Some(*rows),
        _ => None,
    }
}

/// An argument with one row per sample; the array that owns it is held.
pub struct Rows<'py> {
    array: Array<'py>,
    /// Where its elements are.
    pub at: Elements,
    /// Numbers per sample.
    pub width: usize,
}

impl<'py> Rows<'py> {
    /// A (samples, width) argument; `samples` is known from an earlier one, or read off this one.
    pub fn new(x: &Array<'py>, samples: Option<usize>, width: usize, name: &'static str) -> PyResult<(Self, usize)> {
        if let Some(count) = samples.or_else(|| count_of(x))
            && let Some(at) = elements(x, [count, width], Use::Input(name))
        {
            return Ok((Self { array: x.clone(), at, width }, count));
        }
        let array = as_double(x, name)?;
        let count = match array.cast::<PyUntypedArray>()?.shape() {
            [rows, columns] if *columns == width && samples.is_none_or(|samples| samples == *rows) => *rows,
            shape => return Err(wrong_shape(&array, shape, samples, width, name)),
        };
        let at = required(&array, [count, width], Use::Input(name))?;
        Ok((Self { array, at, width }, count))
    }

    /// The interpreter that the array belongs to.
    pub fn py(&self) -> Python<'py> {
        self.array.py()
    }

    /// The rows as threads see them.
    pub fn lane(&self) -> Lane {
        Lane { at: self.at, width: self.width }
    }
}

fn wrong_shape(array: &Array<'_>, shape: &[usize], samples: Option<usize>, width: usize, name: &str) -> PyErr {
    let found = array.getattr("shape").map_or_else(|_| "?".into(), |shape| shape.to_string());
    let wanted = samples.map_or_else(|| "samples".into(), |samples| samples.to_string());
    let turned =
        matches!(shape, [rows, columns] if *rows == width && samples.is_none_or(|samples| samples == *columns));
    let hint = if turned { "; it looks transposed" } else { "" };
    argument_error(array.py(), format!("{name} has shape {found}; expected ({wanted}, {width}){hint}"))
}

/// Rows as the worker threads see them.
#[derive(Clone, Copy)]
pub struct Lane {
    /// All samples.
    pub at: Elements,
    /// Numbers per sample.
    pub width: usize,
}

impl Lane {
    #[inline(always)]
    pub fn row<const N: usize>(self, k: usize) -> [f64; N] {
        let mut row = [0.0; N];
        self.sample(k).read(&mut row[..self.width]);
        row
    }

    #[inline(always)]
    pub fn joints(self, k: usize) -> Joints {
        Joints(self.row(k))
    }

    /// Where sample `k` lies.
    #[inline(always)]
    pub fn sample(self, k: usize) -> Elements {
        self.at.part(k * self.width, self.width)
    }
}

/// One gravity vector for all samples, or one each.
#[derive(Clone, Copy)]
pub enum GravityOf {
    All(Gravity),
    Each(Lane),
}

impl GravityOf {
    /// The vector that all samples share.
    #[inline(always)]
    pub fn shared(self) -> Option<Gravity> {
        match self {
            Self::All(g) => Some(g),
            Self::Each(_) => None,
        }
    }

    #[inline(always)]
    pub fn at(self, k: usize) -> Gravity {
        match self {
            Self::All(g) => g,
            Self::Each(rows) => Gravity(rows.row::<3>(k).into()),
        }
    }
}

pub fn gravity_of<'py>(x: &Array<'py>, samples: usize) -> PyResult<(GravityOf, Option<Rows<'py>>)> {
    let is_typed = x.is_instance_of::<types::Gravity>() || x.is_instance_of::<types::SpecificForce>();
    let x = if is_typed || x.is_instance_of::<PyUntypedArray>() { x.clone() } else { as_double(x, "gravity")? };
    if count_of(&x).is_none() {
        return Ok((GravityOf::All(gravity(&x)?.0), None));
    }
    let (rows, _) = Rows::new(&x, Some(samples), 3, "gravity")?;
    Ok((GravityOf::Each(rows.lane()), Some(rows)))
}

/// One base motion for all samples, or one each: rows of specific force, angular velocity, angular acceleration.
#[derive(Clone, Copy)]
pub enum BaseOf {
    All(BaseMotion),
    Each(Lane),
}

impl BaseOf {
    #[inline(always)]
    pub fn at(self, k: usize) -> BaseMotion {
        match self {
            Self::All(base) => base,
            Self::Each(rows) => {
                let [fx, fy, fz, wx, wy, wz, ax, ay, az] = rows.row::<9>(k);
                BaseMotion {
                    specific_force: SpecificForce([fx, fy, fz].into()),
                    angular_velocity: [wx, wy, wz].into(),
                    angular_acceleration: [ax, ay, az].into(),
                }
            }
        }
    }
}

pub fn base_of<'py>(x: &Array<'py>, samples: usize) -> PyResult<(BaseOf, Option<Rows<'py>>)> {
    let is_table =
        x.is_instance_of::<PyUntypedArray>() || x.is_instance_of::<PyList>() || x.is_instance_of::<PyTuple>();
    if is_table {
        let (rows, _) = Rows::new(x, Some(samples), 9, "base")?;
        return Ok((BaseOf::Each(rows.lane()), Some(rows)));
    }
    Ok((BaseOf::All(base_motion(x)?), None))
}

/// Threads for `samples`: 0 asks for one per core.
fn thread_count(py: Python<'_>, threads: isize, samples: usize) -> PyResult<usize> {
    let wanted = match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        _ => usize::try_from(threads).map_err(|_| {
            argument_error(py, format!("threads is {threads}; expected 0 (all cores) or a positive number"))
        })?,
    };
    Ok(wanted.min(samples / 256 + 1))
}

/// Runs `work` over the samples without the GIL, split among the threads at multiples of [`WIDTH`].
pub fn run(py: Python<'_>, samples: usize, threads: isize, work: impl Fn(Range<usize>) + Sync) -> PyResult<()> {
    let threads = thread_count(py, threads, samples)?;
    let share = samples.div_ceil(threads).next_multiple_of(WIDTH).max(WIDTH);
    py.detach(|| {
        std::thread::scope(|scope| {
            let part = |first: usize| first..(first + share).min(samples);
            for first in (share..samples).step_by(share) {
                let (work, part) = (&work, part(first));
                let here = part.clone();
                // Where the system gives no more threads, this one does the work.
                if std::thread::Builder::new().spawn_scoped(scope, move || work(part)).is_err() {
                    work(here);
                }
            }
            work(part(0));
        });
    });
    Ok(())
}
