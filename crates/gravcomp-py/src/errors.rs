//! Rust errors as the Python package's own exceptions.

use gravcomp::ModelError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// An exception type of `ravengc.errors`, looked up once.
fn exception<'py>(
    py: Python<'py>,
    cell: &'static PyOnceLock<Py<PyType>>,
    name: &str,
) -> PyResult<&'py Bound<'py, PyType>> {
    cell.import(py, "ravengc.errors", name)
}

/// `ravengc.errors.ModelError`; `place` says which link or table it is about.
pub fn model_error(py: Python<'_>, place: &str, error: &ModelError) -> PyErr {
    static CELL: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(exception(py, &CELL, "ModelError"), format!("{place}: {error}"))
}

/// `ravengc.errors.ArgumentError`: an argument of a call with the wrong length, dtype, layout or overlap.
#[cold]
pub fn argument_error(py: Python<'_>, message: String) -> PyErr {
    static CELL: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(exception(py, &CELL, "ArgumentError"), message)
}

/// `ravengc.errors.ConfigError`: a setting that is missing.
#[cold]
pub fn configuration_error(py: Python<'_>, message: String) -> PyErr {
    static CELL: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(exception(py, &CELL, "ConfigError"), message)
}

fn raise(kind: PyResult<&Bound<'_, PyType>>, message: String) -> PyErr {
    match kind {
        Ok(kind) => PyErr::from_type(kind.clone(), message),
        Err(lookup) => lookup,
    }
}
