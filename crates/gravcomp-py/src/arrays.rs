//! NumPy arrays without borrow bookkeeping: checked by hand, read to the stack first, written last.
//!
//! A call reads all its inputs before it writes `out`, and refuses an `out` that shares memory with an input. Elements move
//! by relaxed atomic loads and stores, which cost nothing here and keep a data race with another thread (free-threaded
//! Python, or code that released the GIL) a wrong number instead of undefined behaviour.

use crate::errors::argument_error;
use gravcomp::{Joints, MAX_JOINTS};
use numpy::npyffi::{
    NPY_ARRAY_ALIGNED, NPY_ARRAY_C_CONTIGUOUS, NPY_ARRAY_WRITEABLE, NpyTypes, PY_ARRAY_API, PyArrayObject,
    get_type_object, npy_intp,
};
use numpy::{PyArrayDescr, PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use std::ffi::c_int;
use std::mem::MaybeUninit;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicU64, Ordering};

/// `float64` in native byte order.
fn double(py: Python<'_>) -> &Bound<'_, PyArrayDescr> {
    static DOUBLE: PyOnceLock<Py<PyArrayDescr>> = PyOnceLock::new();
    DOUBLE.get_or_init(py, || numpy::dtype::<f64>(py).unbind()).bind(py)
}

/// A C-contiguous, aligned float64 array: where its elements are, and how many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elements {
    data: *mut f64,
    len: usize,
}

// SAFETY: the pointer is only followed through atomic accesses while the array that owns the memory is held.
unsafe impl Send for Elements {}
// SAFETY: as above.
unsafe impl Sync for Elements {}

impl Elements {
    /// The elements in order, read as the iterator goes.
    #[inline(always)]
    pub fn iter(self) -> impl Iterator<Item = f64> {
        (0..self.len).map(move |i| {
            // SAFETY: i < len, the array is contiguous, aligned and alive.
            f64::from_bits(unsafe { AtomicU64::from_ptr(self.data.add(i).cast()) }.load(Ordering::Relaxed))
        })
    }

    /// Overwrites the elements in order, as far as there are values.
    #[inline(always)]
    pub fn write_all(self, values: impl Iterator<Item = f64>) {
        for (i, x) in (0..self.len).zip(values) {
            // SAFETY: i < len, the array is contiguous, aligned, writeable and alive.
            unsafe { AtomicU64::from_ptr(self.data.add(i).cast()) }.store(x.to_bits(), Ordering::Relaxed);
        }
    }

    /// Reads the first `out.len()` elements.
    #[inline(always)]
    pub fn read(self, out: &mut [f64]) {
        for (x, element) in out.iter_mut().zip(self.iter()) {
            *x = element;
        }
    }

    /// Overwrites the first `values.len()` elements.
    #[inline(always)]
    pub fn write(self, values: &[f64]) {
        self.write_all(values.iter().copied());
    }

    /// Overwrites all elements, at most `N`, with what `compute` leaves in as many numbers on the stack, zero at first.
    #[inline(always)]
    pub fn compute<const N: usize>(self, compute: impl FnOnce(&mut [f64])) {
        let mut buffer = [MaybeUninit::<f64>::uninit(); N];
        let used = &mut buffer[..self.len.min(N)];
        for x in used.iter_mut() {
            x.write(0.0);
        }
        // SAFETY: all of `used` has just been written.
        let values = unsafe { std::slice::from_raw_parts_mut(used.as_mut_ptr().cast(), used.len()) };
        compute(values);
        self.write(values);
    }

    /// The elements `range`, for a range within the length.
    #[inline(always)]
    pub fn part(self, start: usize, len: usize) -> Self {
        debug_assert!(start + len <= self.len);
        // SAFETY: callers stay within the length.
        Self { data: unsafe { self.data.add(start) }, len }
    }

    /// Shares memory with `other`.
    #[inline(always)]
    pub fn overlaps(self, other: Self) -> bool {
        let (a, b) = (self.data as usize, other.data as usize);
        a < b + 8 * other.len && b < a + 8 * self.len
    }
}

/// What an array is for: decides whether it must be writeable, and names it in errors.
#[derive(Clone, Copy, Debug)]
pub enum Use {
    /// Read once. A subclass of ndarray may mean more than its elements (a mask), so it is converted instead.
    Input(&'static str),
    /// Held, and read again and again.
    Held(&'static str),
    /// Written.
    Output(&'static str),
}

impl Use {
    fn name(self) -> &'static str {
        match self {
            Self::Input(name) | Self::Held(name) | Self::Output(name) => name,
        }
    }

    fn flags(self) -> i32 {
        let contiguous = NPY_ARRAY_C_CONTIGUOUS | NPY_ARRAY_ALIGNED;
        match self {
            Self::Input(_) | Self::Held(_) => contiguous,
            Self::Output(_) => contiguous | NPY_ARRAY_WRITEABLE,
        }
    }

    /// `x` if it is an array of a kind that may be used as it is.
    #[inline(always)]
    fn as_it_is<'a, 'py>(self, x: &'a Bound<'py, PyAny>) -> Option<&'a Bound<'py, PyUntypedArray>> {
        match self {
            Self::Input(_) => x.cast_exact().ok(),
            Self::Held(_) | Self::Output(_) => x.cast().ok(),
        }
    }
}

/// The elements of `array` if it is a float64 array of exactly this shape with the layout that its use needs.
#[inline(always)]
pub fn elements<const D: usize>(array: &Bound<'_, PyAny>, shape: [usize; D], purpose: Use) -> Option<Elements> {
    let array = purpose.as_it_is(array)?;
    // SAFETY: a PyUntypedArray is a live PyArrayObject.
    let raw: &PyArrayObject = unsafe { &*array.as_array_ptr() };
    if usize::try_from(raw.fields.nd) != Ok(D) || raw.fields.flags & purpose.flags() != purpose.flags() {
        return None;
    }
    // SAFETY: `dimensions` holds `nd` = D sizes.
    let dimensions = unsafe { std::slice::from_raw_parts(raw.fields.dimensions, D) };
    let same_shape = dimensions.iter().zip(shape).all(|(&a, b)| a.cast_unsigned() == b);
    let is_double = raw.fields.descr.cast() == double(array.py()).as_ptr();
    if !same_shape || !(is_double || array.dtype().is_equiv_to(double(array.py()))) {
        return None;
    }
    Some(Elements { data: raw.fields.data.cast(), len: shape.iter().product() })
}

/// An array held for as long as a cycle is bound to it.
pub struct Pinned {
    array: Py<PyAny>,
    elements: Elements,
    shape: [usize; 2],
    name: &'static str,
    flags: i32,
    descr: *mut std::ffi::c_void,
}

// SAFETY: `descr` is only compared, never followed.
unsafe impl Send for Pinned {}
// SAFETY: as above.
unsafe impl Sync for Pinned {}

impl Pinned {
    /// Holds `array` if it has exactly this shape and the layout that its use needs.
    pub fn new<const D: usize>(array: &Bound<'_, PyAny>, shape: [usize; D], purpose: Use) -> PyResult<Self> {
        let elements = required(array, shape, purpose)?;
        let mut padded = [0; 2];
        padded[..D].copy_from_slice(&shape);
        // SAFETY: `required` has seen that this is a live array.
        let descr = unsafe { (*array.as_ptr().cast::<PyArrayObject>()).fields.descr.cast() };
        Ok(Self {
            array: array.clone().unbind(),
            elements,
            shape: padded,
            name: purpose.name(),
            flags: purpose.flags(),
            descr,
        })
    }

    /// The array itself.
    pub fn array(&self) -> &Py<PyAny> {
        &self.array
    }

    /// What it is called, and where its elements are.
    pub fn named(&self) -> (&'static str, Elements) {
        (self.name, self.elements)
    }

    /// Where the elements are.
    #[inline(always)]
    pub fn elements(&self) -> Elements {
        self.elements
    }

    /// The array still has the memory, shape, type and layout that it was bound with, and may still be written to if it
    /// is `out`: `resize`, `shape =`, `dtype =`, `strides =` and `setflags` can change them.
    #[inline(always)]
    pub fn unchanged(&self, py: Python<'_>) -> bool {
        // SAFETY: an array, and held.
        let raw = unsafe { &(*self.array.bind(py).as_ptr().cast::<PyArrayObject>()).fields };
        // SAFETY: `dimensions` holds `nd` sizes.
        let size = |axis: usize| unsafe { *raw.dimensions.add(axis) }.cast_unsigned();
        let same_shape = match raw.nd {
            1 => self.shape == [size(0), 0],
            2 => self.shape == [size(0), size(1)],
            _ => false,
        };
        same_shape
            && raw.data.cast() == self.elements.data
            && raw.descr.cast() == self.descr
            && raw.flags & self.flags == self.flags
    }
}

/// The arrays of a cycle. Memory that several of them share as views is checked once, as the array that they are views of.
#[derive(Default)]
pub(crate) struct Pins(Vec<Pinned>);

impl Pins {
    /// Holds `array` if it has exactly this shape and the layout that its use needs; says where its elements are.
    pub fn hold<const D: usize>(
        &mut self,
        array: &Bound<'_, PyAny>,
        shape: [usize; D],
        purpose: Use,
    ) -> PyResult<Elements> {
        let pin = Pinned::new(array, shape, purpose)?;
        let elements = pin.elements;
        let pin = owner(array, purpose).unwrap_or(pin);
        match self.0.iter_mut().find(|held| held.array.is(&pin.array)) {
            Some(held) => held.flags |= pin.flags,
            None => self.0.push(pin),
        }
        Ok(elements)
    }

    /// None of them was changed: see [`Pinned::unchanged`].
    #[inline(always)]
    pub fn unchanged(&self, py: Python<'_>) -> bool {
        self.0.iter().all(|pin| pin.unchanged(py))
    }

    /// The arrays themselves.
    pub fn arrays(&self) -> impl Iterator<Item = &Py<PyAny>> {
        self.0.iter().map(Pinned::array)
    }
}

/// The double array of one or two dimensions that `array` is a view of, if there is one with the same layout.
fn owner(array: &Bound<'_, PyAny>, purpose: Use) -> Option<Pinned> {
    // SAFETY: callers have seen that this is a live array; its base is null or a live object.
    let base =
        unsafe { Bound::from_borrowed_ptr_or_opt(array.py(), (*array.as_ptr().cast::<PyArrayObject>()).fields.base) };
    let base = base?;
    let shape = base.cast_exact::<PyUntypedArray>().ok()?.shape().to_vec();
    match *shape.as_slice() {
        [n] => Pinned::new(&base, [n], purpose).ok(),
        [m, n] => Pinned::new(&base, [m, n], purpose).ok(),
        _ => None,
    }
}

/// As [`elements`], with an error that says what is wrong.
#[inline(always)]
pub fn required<const D: usize>(array: &Bound<'_, PyAny>, shape: [usize; D], purpose: Use) -> PyResult<Elements> {
    match elements(array, shape, purpose) {
        Some(found) => Ok(found),
        None => Err(wrong_array(array, &shape, purpose)),
    }
}

/// A new array of this shape, its elements still to be written; MemoryError where there is no room for it.
#[inline(always)]
fn fresh<const D: usize>(py: Python<'_>, shape: [usize; D]) -> PyResult<(Bound<'_, PyAny>, Elements)> {
    let mut dimensions = shape.map(|size| npy_intp::try_from(size).unwrap_or(npy_intp::MAX));
    let rank = c_int::try_from(D).unwrap_or(c_int::MAX);
    let descr = double(py).clone().into_dtype_ptr();
    // SAFETY: NumPy takes over `descr`, reads `rank` = D dimensions, and returns a new array, or null with an error set.
    let array = unsafe {
        let kind = get_type_object(py, NpyTypes::PyArray_Type);
        let (at, none) = (dimensions.as_mut_ptr(), null_mut());
        let raw = PY_ARRAY_API.PyArray_NewFromDescr(py, kind, descr, rank, at, none, null_mut(), 0, null_mut());
        Bound::from_owned_ptr_or_err(py, raw)?
    };
    // SAFETY: a live PyArrayObject.
    let data = unsafe { (*array.as_ptr().cast::<PyArrayObject>()).fields.data.cast() };
    Ok((array, Elements { data, len: shape.iter().product() }))
}

/// An `out` of this shape, or a fresh array; `inputs` must not share its memory.
#[inline(always)]
pub fn output<'py, const D: usize>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: [usize; D],
    inputs: &[Option<Elements>],
) -> PyResult<(Bound<'py, PyAny>, Elements)> {
    let Some(out) = out else { return fresh(py, shape) };
    let found = required(out, shape, Use::Output("out"))?;
    if inputs.iter().flatten().any(|input| input.overlaps(found)) {
        return Err(argument_error(py, "out shares memory with an input; give it an array of its own".into()));
    }
    Ok((out.clone(), found))
}

/// The numbers of a one-dimensional argument, copied, and where they lie if they were read in place.
///
/// A float64 array is read as it is; anything else that NumPy can turn into one safely is converted.
#[inline(always)]
pub fn read<const N: usize>(
    x: &Bound<'_, PyAny>,
    len: usize,
    name: &'static str,
) -> PyResult<([f64; N], Option<Elements>)> {
    let mut values = [0.0; N];
    if let Some(found) = elements(x, [len], Use::Input(name)) {
        found.read(&mut values[..len.min(N)]);
        return Ok((values, Some(found)));
    }
    converted(x, len, name, &mut values)?;
    Ok((values, None))
}

/// As [`read`], for one number per coordinate.
#[inline(always)]
pub fn read_joints(x: &Bound<'_, PyAny>, n: usize, name: &'static str) -> PyResult<(Joints, Option<Elements>)> {
    let (values, found) = read::<MAX_JOINTS>(x, n, name)?;
    Ok((Joints(values), found))
}

/// The same into its place, where it is given.
pub fn read_given(x: Option<&Bound<'_, PyAny>>, n: usize, name: &'static str, into: &mut Joints) -> PyResult<()> {
    if let Some(x) = x {
        *into = read_joints(x, n, name)?.0;
    }
    Ok(())
}

/// Lists, tuples and arrays of other real types or layouts, by way of `numpy.asarray`.
#[cold]
fn converted(x: &Bound<'_, PyAny>, len: usize, name: &'static str, values: &mut [f64]) -> PyResult<()> {
    let array = as_double(x, name)?;
    required(&array, [len], Use::Input(name))?.read(&mut values[..len]);
    Ok(())
}

/// `x` as a C-contiguous float64 array; itself if it is one.
#[cold]
pub fn as_double<'py>(x: &Bound<'py, PyAny>, name: &'static str) -> PyResult<Bound<'py, PyAny>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = x.py();
    let asarray =
        ASARRAY.get_or_try_init(py, || py.import("ravengc._convert")?.getattr("as_double").map(Bound::unbind))?;
    asarray.bind(py).call1((x, name))
}

#[cold]
fn wrong_array(array: &Bound<'_, PyAny>, shape: &[usize], purpose: Use) -> PyErr {
    let py = array.py();
    let name = purpose.name();
    let wanted = match shape {
        [n] => format!("({n},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    };
    let Ok(found) = array.cast::<PyUntypedArray>() else {
        let kind = array.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string());
        let article = if kind.starts_with(['a', 'e', 'i', 'o', 'u', 'A', 'E', 'I', 'O', 'U']) { "an" } else { "a" };
        return argument_error(py, format!("{name} is {article} {kind}; expected a float64 array of shape {wanted}"));
    };
    // SAFETY: a PyUntypedArray is a live PyArrayObject.
    let flags = unsafe { (*found.as_array_ptr()).fields.flags };
    let problem = if found.shape() != shape {
        format!("has shape {}", found.getattr("shape").map_or_else(|_| "?".into(), |s| s.to_string()))
    } else if !found.dtype().is_equiv_to(double(py)) {
        format!("has dtype {}", found.dtype())
    } else if flags & NPY_ARRAY_C_CONTIGUOUS == 0 {
        "is not C-contiguous".into()
    } else if flags & NPY_ARRAY_ALIGNED == 0 {
        "is not aligned".into()
    } else {
        "is read-only".into()
    };
    argument_error(py, format!("{name} {problem}; expected a C-contiguous float64 array of shape {wanted}"))
}
