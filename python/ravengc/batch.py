"""The functions of a cycle over many configurations at once.

Every ``*_batch`` method takes ``q`` of shape (samples, n), releases the GIL and writes one result per sample.
``threads`` is the number of threads, 0 for one per core. ``out`` is a C-contiguous float64 array that shares no memory
with the inputs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc import _core

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ravengc._core import BaseMotion, Gravity, SpecificForce

    Array = NDArray[np.float64]
    GravityLike = ArrayLike | Gravity | SpecificForce
    BaseLike = BaseMotion | Gravity | SpecificForce | Array

__all__ = ["BatchFunctions"]


class BatchFunctions(_core.Robot):
    """Batch forms: ``gravity`` is (3,), one for all, or (samples, 3); ``base`` is one motion for all, or (samples, 9).

    The nine columns of a base are specific force, angular velocity and angular acceleration. All raise ArgumentError.
    """

    def gravity_torque_batch(
        self, q: ArrayLike, gravity: GravityLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the efforts that hold the arm still, (samples, n).

        Eight samples are computed side by side: beside an angle beyond 1e4 rad the others may differ in the last bits.
        """
        return _core.gravity_torque_batch(self, q, gravity, out, threads)

    def forward_kinematics_batch(
        self, q: ArrayLike, frame: str | None = None, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the poses of a frame in the base frame B, (samples, 4, 4)."""
        return _core.forward_kinematics_batch(self, q, frame, out, threads)

    def jacobian_batch(
        self,
        q: ArrayLike,
        frame: str | None = None,
        axes: str | None = None,
        out: Array | None = None,
        threads: int = 1,
    ) -> Array:
        """Return the Jacobians of a frame, (samples, 6, n), linear rows first."""
        return _core.jacobian_batch(self, q, frame, axes, out, threads)

    def inverse_dynamics_batch(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: BaseLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the efforts for motions on a base that moves, (samples, n)."""
        return _core.inverse_dynamics_batch(self, q, qd, qdd, base, out, threads)

    def base_wrench_batch(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: BaseLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return what the mount exerts, (samples, 6): force, then moment about the base origin."""
        return _core.base_wrench_batch(self, q, qd, qdd, base, out, threads)

    def mass_matrix_batch(self, q: ArrayLike, out: Array | None = None, threads: int = 1) -> Array:
        """Return the mass matrices, (samples, n, n)."""
        return _core.mass_matrix_batch(self, q, out, threads)

    def forward_dynamics_batch(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, base: BaseLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the accelerations under efforts ``tau``, (samples, n)."""
        return _core.forward_dynamics_batch(self, q, qd, tau, base, out, threads)

    def gravity_regressor_batch(
        self, q: ArrayLike, gravity: GravityLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the regressors of the gravity torque, (samples, n, 4 body_count)."""
        return _core.gravity_regressor_batch(self, q, gravity, out, threads)

    def inverse_dynamics_regressor_batch(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: BaseLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the regressors of the inverse dynamics, (samples, n, 10 body_count)."""
        return _core.inverse_dynamics_regressor_batch(self, q, qd, qdd, base, out, threads)

    def disturbance_torque_batch(
        self, q: ArrayLike, qd: ArrayLike | None = None, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the efforts against the disturbance elements, (samples, n); at rest without ``qd``."""
        return _core.disturbance_torque_batch(self, q, qd, out, threads)

    def disturbance_regressor_batch(
        self, q: ArrayLike, qd: ArrayLike | None = None, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return their regressors, (samples, n, columns)."""
        return _core.disturbance_regressor_batch(self, q, qd, out, threads)

    def gravity_stiffness_batch(
        self, q: ArrayLike, gravity: GravityLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the derivatives of the gravity torque by q, (samples, n, n)."""
        return _core.gravity_stiffness_batch(self, q, gravity, out, threads)

    def potential_energy_batch(
        self, q: ArrayLike, gravity: GravityLike, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Return the potential energies, (samples,)."""
        return _core.potential_energy_batch(self, q, gravity, out, threads)

    def center_of_mass_batch(self, q: ArrayLike, out: Array | None = None, threads: int = 1) -> Array:
        """Return the centres of mass in the base frame B, (samples, 3)."""
        return _core.center_of_mass_batch(self, q, out, threads)
