"""Settings of a run over a moving surface, each with its unit and range."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

from ravengc.errors import ConfigError
from ravengc.experiments.settings import Settings, setting

__all__ = ["APPROACHES", "METHODS", "MODES", "ORDERS", "PREDICTORS", "TrackSettings"]

MODES = ("scan", "palpate")
METHODS = ("resolved", "naive", "oracle")
APPROACHES = ("smooth", "proportional", "step")
ORDERS = ("tour", "given", "strips")
PredictorName = Literal["switch", "periodic", "autoregressive", "fourier", "hold", "velocity", "acceleration"]
PREDICTORS: tuple[PredictorName, ...] = get_args(PredictorName)

LEAST_BAND = 1.5
"""The upper end of the cycles' frequencies is no less than so many times the lower one."""


@dataclass(frozen=True, kw_only=True)
class TrackSettings(Settings):
    """How a surface is visited. ConfigError for a value of the wrong kind, out of range, or at odds with others.

    ``method``: "resolved" goes for where the surface is predicted to be, with its velocity fed forward; "naive" for
    where it was seen last; "oracle" for where it is. ``approach``: "smooth" closes in within an acceleration,
    "proportional" by ``gain_per_s`` times the error, "step" at ``step_speed`` towards the point.
    """

    mode: str = setting("scan", choices=MODES, doc="dwell at a stand-off, or press by a profile of depths")
    method: str = setting("resolved", choices=METHODS, doc="go for the predicted, the last seen or the true place")
    approach: str = setting("smooth", choices=APPROACHES, doc="how the tool closes in on it")
    feed_forward: bool = setting(True, doc="add the target's velocity (not where method is naive)")
    predictor: str = setting("switch", choices=PREDICTORS, doc="method of prediction")
    band_hz: tuple[float, float] = setting(
        (0.08, 1.0), 0.01, 100.0, "Hz", "lowest and highest frequency of the cycles that are predicted", count=2
    )
    harmonics: int = setting(2, 1, 5, "", "how many of each cycle: more for sharper beats")
    order: str = setting("tour", choices=ORDERS, doc="order of the visits")
    strip_m: float = setting(0.006, 1e-5, 10.0, "m", "width of the strips of that order")
    stand_off_m: float = setting(0.0, -0.1, 1.0, "m", "scan: distance of the tool above the surface")
    dwell_s: float = setting(0.05, 0.001, 600.0, "s", "scan: how long the tool must stay at each point")
    press_times_s: tuple[float, ...] = setting(
        (0.0, 0.3, 0.6, 0.9), 0.0, 600.0, "s", "palpate: times of the profile, from arrival on, increasing"
    )
    press_depths_m: tuple[float, ...] = setting(
        (-0.005, 0.003, 0.003, -0.005), -0.2, 0.05, "m", "palpate: depths below the surface at those times"
    )
    tolerance_m: float = setting(0.5e-3, 1e-6, 1.0, "m", "believed error at which the dwell counts")
    tolerance_rad: float = setting(0.017453292519943295, 1e-6, 3.2, "rad", "the same of the direction")
    covered_m: float = setting(1e-3, 1e-6, 1.0, "m", "true error during the dwell that a covered point may have")
    covered_rad: float = setting(0.03490658503988659, 1e-6, 3.2, "rad", "the same of the direction")
    timeout_s: float = setting(2.0, 0.01, 600.0, "s", "when a point is given up")
    revisits: int = setting(
        2, 0, 100, "", "how often a point is visited again that later pictures do not show covered (resolved)"
    )
    lead_in_s: float = setting(30.0, 0.0, 3600.0, "s", "how long the camera looks before the arm moves")
    settle_s: float = setting(3.0, 0.0, 600.0, "s", "time for the way to the first point, not scored")
    hold_points: int = setting(0, 0, 100, "", "points that are held after the tour")
    hold_s: float = setting(9.0, 0.01, 3600.0, "s", "how long each is held")
    hold_after_s: float = setting(1.0, 0.0, 3600.0, "s", "time for the way there, not scored")
    hold_from_arrival: bool = setting(
        True, doc="score a hold only once the tool is there, or a straight way at full speed would have ended"
    )
    most_s: float = setting(3600.0, 1.0, 86400.0, "s", "when the run ends, whatever is left")
    gain_per_s: float = setting(20.0, 0.1, 1000.0, "1/s", "proportional: velocity per error")
    angular_gain_per_s: float = setting(10.0, 0.1, 1000.0, "1/s", "proportional and step: the same of the direction")
    speed_max: float = setting(0.25, 1e-4, 10.0, "m/s", "closing speed, besides the target's own")
    angular_speed_max: float = setting(2.0, 1e-3, 50.0, "rad/s", "the same of the direction")
    step_speed: float = setting(0.15, 1e-4, 10.0, "m/s", "step: speed towards the point")
    acceleration_max: float = setting(3.7, 0.01, 1000.0, "m/s^2", "smooth: acceleration of the approach")
    angular_acceleration_max: float = setting(15.0, 0.1, 1e4, "rad/s^2", "smooth: the same of the direction")
    closing_gain_per_s: float = setting(100.0, 0.1, 1000.0, "1/s", "smooth: velocity per error close to the point")
    upright_near_m: float = setting(0.02, 0.0, 10.0, "m", "farther from its point the tool leans to the mean normal")
    upright_far_m: float = setting(0.06, 0.0, 10.0, "m", "farther than this it is along the mean normal")
    null_gain: float = setting(3.0, 0.0, 100.0, "1/s", "how strongly joints are drawn to the middle of their ranges")
    rate_hz: float = setting(1000.0, 50.0, 10000.0, "Hz", "control cycles per second")
    trace_hz: float = setting(100.0, 0.1, 10000.0, "Hz", "rows of the trace per second")
    start_q: tuple[float, ...] = setting(
        (0.0,), -1e3, 1e3, "rad, m", "joint positions at the start; one number: the middle of every range"
    )

    def check(self) -> None:
        """Raise ConfigError where a profile, a gain or a dwell does not fit the rest."""
        times, depths = self.press_times_s, self.press_depths_m
        if len(times) != len(depths) or len(times) < 2:
            problem = f"{len(times)} and {len(depths)} numbers; expected as many, two at least"
            raise ConfigError(f"press_times_s and press_depths_m have {problem}")
        if times[0] != 0.0 or any(late <= early for early, late in pairwise(times)):
            raise ConfigError(f"press_times_s is {times}; expected 0 first, then increasing times")
        fastest = max(self.gain_per_s, self.closing_gain_per_s, self.angular_gain_per_s)
        if fastest > self.rate_hz:
            raise ConfigError(f"a gain of {fastest:g} 1/s needs a rate_hz above it, not {self.rate_hz:g}")
        low, high = self.band_hz
        if high < LEAST_BAND * low:
            least = f"expected the second {LEAST_BAND:g} times the first or more"
            raise ConfigError(f"band_hz is {low:g} to {high:g}; {least}")
        if self.upright_near_m >= self.upright_far_m:
            limits = f"{self.upright_near_m:g} and {self.upright_far_m:g}"
            raise ConfigError(f"upright_near_m and upright_far_m are {limits}; expected the first below the second")
        if self.hold_points and self.hold_after_s >= self.hold_s:
            raise ConfigError(f"hold_after_s is {self.hold_after_s:g}; expected less than hold_s, {self.hold_s:g}")

    @property
    def visit_s(self) -> float:
        """How long the tool stays at a point: the dwell, or the whole profile."""
        return self.dwell_s if self.mode == "scan" else self.press_times_s[-1]
