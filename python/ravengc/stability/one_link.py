"""One link on a base of one degree: every formula of the loop in closed form.

The base, M_b on c and k, moves along y; the link (mass m, centre of mass at l from its joint, across y; inertia J about
the joint, rotor included) is held by K_P, K_D; the law adds rho m l (g + H y''). With G_q = 1 / (J s^2 + K_D s + K_P)

    D(s) = (M_b + m) s^2 + c s + k + Z(s),      Z = m^2 l^2 s^4 G_q (rho H - 1)
    L(s) = rho H m^2 l^2 s^4 G_q / ((M_b + m) s^2 + c s + k - m^2 l^2 s^4 G_q)

The poles are the zeros of D. Where the base swings, at the w with k + Re Z = (M_b + m) w^2, its damping is
c_eff = c + Im Z(iw) / w: a base slower than the joints' PD loop loses rho m^2 l^2 w^4 T / K_P by the lag T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from ravengc._convert import check_type
from ravengc.stability.ranges import within
from ravengc.stability.sensing import Sensing
from ravengc.stability.system import System

__all__ = ["OneLink"]

Complex = Any

RANGES = {
    "base_mass": (1e-6, 1e7, "kg"),
    "base_frequency_hz": (1e-3, 1e4, "Hz"),
    "base_damping_ratio": (0.0, 10.0, ""),
    "mass": (1e-6, 1e6, "kg"),
    "length": (0.0, 1e3, "m"),
    "inertia": (1e-9, 1e9, "kg m^2"),
    "kp": (1e-6, 1e12, "N m/rad"),
    "kd": (0.0, 1e12, "N m s/rad"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class OneLink:
    """The model of the module's text.

    ``base_frequency_hz`` gives k = (M_b + m) w_b^2, ``base_damping_ratio`` c = 2 zeta (M_b + m) w_b. ``inertia`` is J:
    at least m l^2. Raises ConfigError for numbers outside their range.
    """

    base_mass: float
    base_frequency_hz: float
    base_damping_ratio: float
    mass: float
    length: float
    inertia: float
    kp: float
    kd: float
    sensing: Sensing = field(default_factory=Sensing)

    def __post_init__(self) -> None:
        """Check every number against its range."""
        for name, (low, high, unit) in RANGES.items():
            object.__setattr__(self, name, within(getattr(self, name), name, low, high, unit))
        within(self.inertia, "inertia (at least mass * length^2)", self.mass * self.length**2, 1e9, "kg m^2")
        check_type(self.sensing, Sensing, "sensing")

    def with_(self, **changes: Any) -> OneLink:
        """Return the same with some numbers changed; those of :class:`Sensing` too."""
        own = {part.name for part in fields(self)}
        sensing = {name: value for name, value in changes.items() if name not in own}
        changed = {name: value for name, value in changes.items() if name in own}
        return replace(self, **{"sensing": self.sensing.with_(**sensing), **changed})

    @property
    def total(self) -> float:
        """M_b + m, kg."""
        return self.base_mass + self.mass

    @property
    def w_base(self) -> float:
        """w_b, rad/s."""
        return 2.0 * math.pi * self.base_frequency_hz

    @property
    def stiffness(self) -> float:
        """k, N/m."""
        return self.total * self.w_base**2

    @property
    def damping(self) -> float:
        """c, N s/m."""
        return 2.0 * self.base_damping_ratio * self.total * self.w_base

    @property
    def coupling(self) -> float:
        """How the link couples to the base: m l, kg m."""
        return self.mass * self.length

    @property
    def high_frequency_gain(self) -> float:
        """Size of L at high frequency, rho mu / (1 - mu), mu = m^2 l^2 / (J (M_b + m)); infinite for mu = 1.

        With a delay and no low-pass, above 1 it is unstable for any delay.
        """
        mu = self.coupling**2 / (self.inertia * self.total)
        return self.sensing.gain * mu / (1.0 - mu)

    @property
    def lag_damping(self) -> float:
        """What the lag takes from the base's damping, by the rule for slow bases: rho m^2 l^2 w_b^4 T_tot / K_P."""
        return self._lag_rate * self.sensing.lag_s

    @property
    def critical_lag_s(self) -> float:
        """T_tot that takes all of c by that rule: c K_P / (rho m^2 l^2 w_b^4); infinite where nothing is fed."""
        return self.damping / self._lag_rate if self._lag_rate else math.inf

    @property
    def _lag_rate(self) -> float:
        return self.sensing.gain * self.coupling**2 * self.w_base**4 / self.kp

    def joint(self, s: Complex) -> Complex:
        """G_q(s)."""
        return 1.0 / (self.inertia * s * s + self.kd * s + self.kp)

    def reaction(self, s: Complex) -> Complex:
        """Z(s)."""
        return self.coupling**2 * s**4 * self.joint(s) * (self.sensing.response(s) - 1.0)

    def characteristic(self, s: Complex) -> Complex:
        """D(s)."""
        return self.total * s * s + self.damping * s + self.stiffness + self.reaction(s)

    def loop(self, s: Complex) -> Complex:
        """L(s)."""
        arm = self.coupling**2 * s**4 * self.joint(s)
        base = self.total * s * s + self.damping * s + self.stiffness - arm
        return self.sensing.response(s) * arm / base

    def effective_damping(self, w: Complex) -> Complex:
        """Damping of the base, c + Im Z(iw) / w, at a frequency ``w`` (rad/s), N s/m."""
        return self.damping + self.reaction(1j * w).imag / w

    def system(self) -> System:
        """The same as a :class:`System`: y, q; the sensor reads y''."""
        own = np.array(((self.total, self.coupling), (self.coupling, self.inertia)))
        return System(
            mass=own,
            damping=np.diag((self.damping, self.kd)),
            stiffness=np.diag((self.stiffness, self.kp)),
            inputs=np.array(((0.0,), (self.coupling,))),
            reads_acceleration=np.array(((1.0, 0.0),)),
            reads_position=np.zeros((1, 2)),
            base=1,
            sensing=self.sensing,
            turns=(False, True),
        )
