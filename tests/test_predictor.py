"""The target predictor: the core against the reference, what a target of each kind is owed, and wrong arguments."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import ravengc as rg
from misuse import WRONG
from ravengc._core import NOTES
from ravengc.errors import ArgumentError, ConfigError, RavenGCError
from ravengc.reference import prediction
from ravengc.track import lujan

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

METHODS = ("hold", "velocity", "acceleration", "periodic", "autoregressive", "fourier", "switch")
DIRECTION = np.array([0.95, 0.27, 0.15])


def breathing(
    seconds: float, *, seed: int, noise: float = 3e-4, rate: float = 30.0
) -> Iterator[tuple[float, NDArray[Any]]]:
    """Noisy samples of breaths after Lujan, each with a size and a length of its own."""
    rng = np.random.default_rng(seed)
    begin, size, length = 0.0, 0.015, 4.0
    for t in np.arange(0.0, seconds, 1.0 / rate):
        while t - begin > length:
            begin += length
            size, length = 0.015 * (1 + 0.1 * rng.standard_normal()), 4.0 * (1 + 0.1 * rng.uniform(-1, 1))
        place = size * np.sin(np.pi * (t - begin) / length) ** 4 * DIRECTION
        yield float(t), place + noise * rng.standard_normal(3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("horizon", "rate"), [(0.077, 30.0), (0.5, 10.0)])
def test_core_and_reference_say_the_same(method: str, horizon: float, rate: float) -> None:
    core = rg.Predictor(rate, method=method, horizon_s=horizon)
    reference = prediction.Predictor(rate, horizon)
    for t, y in breathing(28.0, seed=1, rate=rate):
        assert core.update(t, y)
        reference.update(t, y)
        for ahead in (0.3 * horizon, horizon, 1.6 * horizon):
            np.testing.assert_allclose(core.predict(t + ahead), reference.predict(t + ahead, method), rtol=0, atol=1e-8)
    if method == "periodic":
        assert core.frequency == pytest.approx(reference.periodic.x[1] / (2 * np.pi), rel=1e-6)


@settings(max_examples=8, deadline=None)
@given(
    rate=st.sampled_from([8.0, 10.0, 15.0]),
    horizon=st.floats(0.05, 0.5),
    harmonics=st.integers(2, 5),  # a single one rests at both of its ends alike
    band=st.sampled_from([(0.08, 1.0), (0.1, 3.5)]),
    seed=st.integers(0, 99),
    method=st.sampled_from(["periodic", "switch"]),
)
def test_core_and_reference_agree_whatever_is_declared(
    rate: float, horizon: float, harmonics: int, band: tuple[float, float], seed: int, method: str
) -> None:
    core = rg.Predictor(rate, method=method, horizon_s=horizon, band=band, harmonics=harmonics)
    reference = prediction.Predictor(rate, horizon, band=band, harmonics=harmonics)
    for t, y in breathing(25.0, seed=seed, rate=rate):
        assume(core.update(t, y))
        reference.update(t, y)
    np.testing.assert_allclose(core.predict(t + horizon), reference.predict(t + horizon, method), rtol=0, atol=1e-7)


@settings(max_examples=15, deadline=None)
@given(
    hz=st.floats(0.12, 0.7),
    size=st.floats(2e-3, 3e-2),
    phase=st.floats(0, 6.3),
    method=st.sampled_from(["periodic", "switch"]),
)
def test_a_sine_is_learnt(hz: float, size: float, phase: float, method: str) -> None:
    predictor = rg.Predictor(30.0, axes=1, method=method, horizon_s=0.1)
    for k in range(1500):
        predictor.update(k / 30, [size * np.sin(2 * np.pi * hz * k / 30 + phase)])
    at = 1499 / 30 + 0.1
    assert predictor.predict(at)[0] == pytest.approx(size * np.sin(2 * np.pi * hz * at + phase), abs=0.01 * size)
    assert predictor.frequency == pytest.approx(hz, rel=0.01)
    assert predictor.amplitude is not None
    assert predictor.amplitude[0] == pytest.approx(2 * size, rel=0.02)


def test_frequency_and_amplitude_are_within_their_margins() -> None:
    """Two standard deviations: of breaths that vary by a tenth, nineteen in twenty samples find theirs within them."""
    within: list[tuple[bool, bool]] = []
    margins = []
    for seed in range(4):
        motion, rng = lujan(seed=seed, direction=DIRECTION), np.random.default_rng(seed)
        predictor = rg.Predictor(30.0, method="periodic", horizon_s=0.1)
        stamps = np.arange(0.0, 90.0, 1.0 / 30.0)
        breath = np.searchsorted(motion.starts, stamps, side="right") - 1
        for t, place, k in zip(stamps, motion.positions(stamps), breath, strict=True):
            predictor.update(t, place + 3e-4 * rng.standard_normal(3))
            if t > 25.0:
                hz, size = predictor.frequency, predictor.amplitude
                hz_margin, size_margin = predictor.frequency_margin, predictor.amplitude_margin
                assert hz is not None
                assert size is not None
                assert hz_margin is not None
                assert size_margin is not None
                real = motion.amplitudes[k] * abs(motion.direction)
                within.append((abs(hz - 1.0 / motion.periods[k]) <= hz_margin, abs(size - real)[0] <= size_margin[0]))
                margins.append((hz_margin, size_margin[0]))
    assert (np.mean(within, axis=0) >= 0.95).all()
    assert (np.median(margins, axis=0) < (0.05, 0.004)).all()


@settings(max_examples=15, deadline=None)
@given(place=st.lists(st.floats(-1, 1), min_size=3, max_size=3), method=st.sampled_from(METHODS))
def test_a_still_target_is_held(place: list[float], method: str) -> None:
    predictor = rg.Predictor(30.0, method=method)
    for k in range(600):
        predictor.update(k / 30, place)
    np.testing.assert_allclose(predictor.predict(20.05), place, rtol=0, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(
    stream=st.lists(
        st.tuples(st.floats(allow_nan=True), st.lists(st.floats(allow_nan=True), min_size=2, max_size=2)), max_size=60
    ),
    method=st.sampled_from(METHODS),
)  # fmt: skip
def test_no_stream_raises_or_makes_infinities(stream: list[tuple[float, list[float]]], method: str) -> None:
    predictor = rg.Predictor(30.0, axes=2, method=method)
    for stamp, place in stream:
        predictor.update(stamp, place)
        for at in (stamp, 0.0, np.nan):
            assert np.isfinite(predictor.predict(at)).all()
            assert np.isfinite(predictor.velocity(at)).all()
    counters = predictor.counters
    assert counters["received"] == len(stream) >= counters["accepted"]


def test_velocity_is_the_slope_of_the_prediction() -> None:
    for method in METHODS:
        predictor = rg.Predictor(30.0, method=method, horizon_s=0.1)
        for t, y in breathing(25.0, seed=2):
            predictor.update(t, y)
        slope = (predictor.predict(t + 0.1 + 1e-5) - predictor.predict(t + 0.1 - 1e-5)) / 2e-5
        np.testing.assert_allclose(predictor.velocity(t + 0.1), slope, rtol=1e-4, atol=1e-7)


def test_spikes_at_five_hertz_change_nothing() -> None:
    """With and without a spike of 20 mm in every twentieth sample, the switch is as good, and better than hold."""
    errors = {}
    for name, method, size in (("clean", "switch", 0.0), ("spiky", "switch", 0.02), ("hold", "hold", 0.0)):
        rng, squares = np.random.default_rng(5), []
        predictor = rg.Predictor(5.0, method=method, horizon_s=0.2)
        samples = list(breathing(120.0, seed=3, rate=5.0))
        for k, (t, y) in enumerate(samples[:-1]):
            spike = size * rng.standard_normal(3) * 2 if k % 20 == 19 else 0.0
            predictor.update(t, y + spike)
            if t > 40 and k % 20 != 18:
                squares.append(((predictor.predict(t + 0.2) - samples[k + 1][1]) ** 2).sum())
        errors[name] = np.sqrt(np.mean(squares))
    assert errors["spiky"] < 1.25 * errors["clean"]
    assert errors["spiky"] < 0.7 * errors["hold"]


def test_out_is_filled_and_returned() -> None:
    predictor = rg.Predictor(30.0)
    predictor.update(0.0, [1.0, 2.0, 3.0])
    out, square = np.zeros(3), np.zeros((3, 3))
    assert predictor.predict(0.1, out) is out
    assert out.tolist() == [1.0, 2.0, 3.0]
    assert predictor.velocity(0.1, out=out) is out
    assert out.tolist() == [0.0, 0.0, 0.0]
    assert predictor.covariance(0.1, square) is square
    assert (np.diag(square) > 0).all()


def test_bound_arrays_get_what_predict_and_velocity_return() -> None:
    for axes in (1, 2, 3):
        predictor = rg.Predictor(30.0, axes=axes)
        out, velocity = np.zeros(axes), np.zeros(axes)
        both, place = predictor.bind(out=out, velocity=velocity), predictor.bind(out=out)
        both(0.0)
        assert not out.any()
        for t, y in breathing(20.0, seed=4):
            predictor.update(t, y[:axes])
            for at in (t + 0.05, t - 0.3, t + 3.0, -np.inf):
                both(at)
                assert out.tolist() == predictor.predict(at).tolist()
                assert velocity.tolist() == predictor.velocity(at).tolist()
        out[:] = np.nan
        place(t)
        assert out.tolist() == predictor.predict(t).tolist()
        both(np.nan)
        assert out.tolist() == predictor.predict(np.nan).tolist()
        assert "no_time" in predictor.notes


def test_bound_arrays_are_checked() -> None:
    predictor, out = rg.Predictor(30.0, axes=2), np.zeros(2)
    for arrays, said in (
        ({"out": np.zeros(3)}, "out"),
        ({"out": out, "velocity": np.zeros((2, 1))}, "velocity"),
        ({"out": out, "velocity": out}, "shares memory"),
    ):
        with pytest.raises(ArgumentError, match=said):
            predictor.bind(**arrays)
    step = predictor.bind(out=out)
    with pytest.raises(TypeError, match="at_s"):
        step("now")
    out.setflags(write=False)
    with pytest.raises(ArgumentError):
        step(0.0)


def test_notes_are_named_and_reset_forgets() -> None:
    predictor = rg.Predictor(30.0)
    assert predictor.notes == ("no_data",)
    assert predictor.status == 1 << list(NOTES).index("no_data")
    predictor.update(np.nan, [0, 0, 0])
    assert "not_finite" in predictor.notes
    predictor.update(1.0, [1, 1, 1])
    predictor.reset()
    assert "no_data" in predictor.notes
    assert predictor.predict(1.0).tolist() == [0.0, 0.0, 0.0]
    assert predictor.counters["received"] == 2
    assert predictor.chosen == "hold"
    assert (predictor.frequency, predictor.frequency_margin) == (None, None)
    assert (predictor.amplitude, predictor.amplitude_margin) == (None, None)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"method": "swich"}, "'switch'"),
        ({"rate_hz": 0.0}, "rate_hz is 0.0"),
        ({"axes": 4}, "1, 2 or 3"),
        ({"band": (1.0, 0.5)}, "band"),
        ({"band": (0.08, 20.0)}, "half the rate"),
        ({"noise": -1.0}, "noise is -1.0"),
        ({"horizon_s": 3.0}, "horizon_s"),
        ({"harmonics": 0}, "harmonics"),
        ({"speed_limit": np.nan}, "speed_limit"),
        ({"start_s": 1.0}, "start_s"),
    ],
)
def test_settings_that_cannot_be_meant_are_named(change: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        rg.Predictor(**({"rate_hz": 30.0} | change))


def test_wrong_kinds_are_named() -> None:
    predictor = rg.Predictor(30.0)
    with pytest.raises(ArgumentError, match="position"):
        predictor.update(0.0, [1.0, 2.0])
    with pytest.raises(ArgumentError, match="out"):
        predictor.predict(0.0, np.zeros(2))
    good = {
        "rate_hz": 30.0, "axes": 3, "method": "switch", "latency_s": 0.0, "horizon_s": 0.1, "band": (0.08, 1.0),
        "noise": 3e-4, "harmonics": 2, "speed_limit": 0.5, "jump_m": 0.003, "longest_s": 1.0, "start_s": 12.0,
    }  # fmt: skip
    assert rg.Predictor(**good)
    for function, arguments in (
        (predictor.update, {"stamp_s": 0.0, "position": [0.0, 0.0, 0.0]}),
        (predictor.predict, {"at_s": 0.1, "out": np.zeros(3)}),
        (predictor.velocity, {"at_s": 0.1, "out": np.zeros(3)}),
        (predictor.covariance, {"at_s": 0.1, "out": np.zeros((3, 3))}),
        (predictor.bind, {"out": np.zeros(3), "velocity": np.zeros(3)}),
        (rg.Predictor, good),
    ):
        for name, value in itertools.product(arguments, WRONG):
            error = _raised(function, arguments | {name: value})
            # A number of the right kind may clash with another setting, which is named then.
            is_named = error is None or isinstance(error, ConfigError) or name in _told(error)
            assert is_named, f"{name}={value!r}: {error!r}"


def _raised(function: Callable[..., object], arguments: dict[str, Any]) -> Exception | None:
    try:
        function(**arguments)
    except (RavenGCError, TypeError, OverflowError, ValueError) as error:
        return error
    return None


def _told(error: Exception) -> str:
    """The message with the notes that a traceback shows beneath it."""
    return "\n".join([str(error), *getattr(error, "__notes__", [])])


def test_a_band_is_any_two_numbers() -> None:
    for band in ([0.1, 1.0], np.array([0.1, 1.0])):
        assert rg.Predictor(30.0, band=band).frequency is None
    for band in ((0.1,), (0.1, 1.0, 2.0), "ab"):
        with pytest.raises(ArgumentError, match="band"):
            rg.Predictor(30.0, band=band)
