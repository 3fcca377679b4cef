//! Rust errors as the Python package's own exceptions.

use gravcomp::ModelError;
use gravcomp::control::SettingsError;
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
    outsized(py, &format!("{place}: {error}"))
}

/// `ravengc.errors.ModelError` for a number that is too large.
pub fn outsized(py: Python<'_>, message: &str) -> PyErr {
    static CELL: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(exception(py, &CELL, "ModelError"), message.to_owned())
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

/// `ravengc.errors.LimitError`: a limit that is none.
#[cold]
fn limit_error(py: Python<'_>, message: String) -> PyErr {
    static CELL: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(exception(py, &CELL, "LimitError"), message)
}

/// A declaration of the core that cannot be meant, in Python's words: LimitError for a limit, else ConfigError. `whose` it is
/// stands behind the field; `value` is what was declared, where that is no number.
#[cold]
pub fn refused(py: Python<'_>, what: &str, error: &SettingsError, whose: &str, value: Option<&str>) -> PyErr {
    let number = format!("{:?}", error.value);
    let message =
        format!("{what}: {}{whose} is {}; it should be {}", error.field, value.unwrap_or(&number), error.wanted);
    let is_limit = ["tau", "limits", "q"].iter().any(|start| error.field.starts_with(start));
    if is_limit { limit_error(py, message) } else { configuration_error(py, message) }
}

/// " of 'joint'" for the coordinate that an error is about; nothing for one about no coordinate.
pub fn of_joint(error: &SettingsError, names: &[String]) -> String {
    let name = error.joint.and_then(|joint| names.get(joint));
    name.map_or_else(String::new, |name| format!(" of '{}'", cut(name)))
}

/// `messages.did_you_mean`: the end of a message that names the near one of `options`, or nothing.
pub fn did_you_mean(py: Python<'_>, word: &str, options: &[String]) -> String {
    let near = || py.import("ravengc.messages")?.call_method1("did_you_mean", (word, options))?.extract();
    near().unwrap_or_default()
}

/// The beginning of a name that may be of any length.
pub fn cut(name: &str) -> String {
    name.chars().take(80).collect()
}

fn raise(kind: PyResult<&Bound<'_, PyType>>, message: String) -> PyErr {
    match kind {
        Ok(kind) => PyErr::from_type(kind.clone(), message),
        Err(lookup) => lookup,
    }
}
