//! A value that Python threads share, read without a lock where the GIL is the lock.

use pyo3::Python;
#[cfg(not(Py_GIL_DISABLED))]
use std::cell::UnsafeCell;
#[cfg(Py_GIL_DISABLED)]
use std::sync::RwLock;

/// A value behind the GIL; on a free-threaded interpreter, behind a readers-writer lock.
pub struct Shared<T> {
    #[cfg(not(Py_GIL_DISABLED))]
    value: UnsafeCell<T>,
    #[cfg(Py_GIL_DISABLED)]
    value: RwLock<T>,
}

/// Python's allocator aligns objects to 16 bytes: what needs more goes into a box.
const fn fits_python<T>() {
    assert!(align_of::<T>() <= 16, "put the value into a Box");
}

// SAFETY: the value is only reached through `with` and `change`, which hold the GIL (or the lock) for as long as they use it.
#[cfg(not(Py_GIL_DISABLED))]
unsafe impl<T: Send> Sync for Shared<T> {}

#[cfg(not(Py_GIL_DISABLED))]
impl<T> Shared<T> {
    /// Puts the value behind the GIL.
    pub fn new(value: T) -> Self {
        const { fits_python::<T>() };
        Self { value: UnsafeCell::new(value) }
    }

    /// Reads the value; `read` is plain Rust and calls nothing that could run Python code.
    #[inline(always)]
    pub fn with<R>(&self, _py: Python<'_>, read: impl FnOnce(&T) -> R) -> R {
        // SAFETY: the GIL is held, and `read` never gives it up, so nobody writes meanwhile.
        read(unsafe { &*self.value.get() })
    }

    /// Changes the value; the same holds for `change`.
    pub fn change<R>(&self, _py: Python<'_>, change: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: the GIL is held, and `change` never gives it up, so nobody reads or writes meanwhile.
        change(unsafe { &mut *self.value.get() })
    }
}

#[cfg(Py_GIL_DISABLED)]
impl<T> Shared<T> {
    /// Puts the value behind the lock.
    pub fn new(value: T) -> Self {
        const { fits_python::<T>() };
        Self { value: RwLock::new(value) }
    }

    /// Reads the value.
    #[inline(always)]
    pub fn with<R>(&self, _py: Python<'_>, read: impl FnOnce(&T) -> R) -> R {
        read(&self.value.read().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// Changes the value.
    pub fn change<R>(&self, _py: Python<'_>, change: impl FnOnce(&mut T) -> R) -> R {
        change(&mut self.value.write().unwrap_or_else(std::sync::PoisonError::into_inner))
    }
}
