"""Quantities with units: exact where the decimal is, alike however the unit is written, refused where none fits."""

from __future__ import annotations

import math
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ravengc.errors import UnitsError
from ravengc.units import Dimension, to_si, to_si_vector

FINITE = st.floats(-1e6, 1e6)

EXACT = [
    ("494 g", "mass", 0.494),
    ("13 mm", "length", 0.013),
    ("13mm", "length", 0.013),
    ("-137.71 mm", "length", -0.13771),
    ("1 in", "length", 0.0254),
    ("90 deg", "angle", math.pi / 2),
    ("-180°", "angle", -math.pi),
    ("205 deg", "angle", math.radians(205)),
    ("1 rev", "angle", 2 * math.pi),
    ("0.5 N*m", "torque", 0.5),
    ("0.5 N·m", "torque", 0.5),
    ("0.5 N.m", "torque", 0.5),
    ("500 mNm", "torque", 0.5),
    ("2 kg*m^2", "inertia", 2.0),
    ("2 kg m²", "inertia", 2.0),
    ("2e6 g*mm**2", "inertia", 2e-3),
    ("3 m/s^2", "acceleration", 3.0),
    ("3 m*s^-2", "acceleration", 3.0),
    ("1 gn", "acceleration", 9.80665),
    ("60 rpm", "angular velocity", 2 * math.pi),
    ("180 deg/s", "angular velocity", math.pi),
    ("1 kHz", "frequency", 1000.0),
    ("15 ms", "time", 0.015),
    ("5 µs", "time", 5e-6),
    ("2 N*m/rad", "angular stiffness", 2.0),
    ("2 N*m*s/rad", "angular damping", 2.0),
    ("2 N/m", "stiffness", 2.0),
    ("+.5e1 N", "force", 5.0),
]


@pytest.mark.parametrize(("text", "dimension", "expected"), EXACT)
def test_text_to_si(text: str, dimension: Dimension, expected: float) -> None:
    assert to_si(text, dimension) == pytest.approx(expected, rel=1e-15, abs=0.0)


@given(FINITE)
def test_a_plain_number_and_its_si_text_are_itself(value: float) -> None:
    assert to_si(value, "length") == value
    assert to_si(f"{value!r} m", "length") == value
    assert to_si(f"{value!r} rad", "angle") == value


@given(FINITE)
def test_ways_to_write_one_unit_agree(value: float) -> None:
    texts = ("N*m", "Nm", "N m", "N·m", "kg*m^2/s^2", "kg m²/s²", "m*N")
    assert len({to_si(f"{value!r} {unit}", "torque") for unit in texts}) == 1
    assert to_si(f"{value!r} deg", "angle") == pytest.approx(math.radians(value), rel=1e-15, abs=1e-300)


@pytest.mark.parametrize("dimension", get_args(Dimension))
def test_a_unit_fits_one_dimension(dimension: Dimension) -> None:
    units = {
        "length": "mm", "angle": "deg", "mass": "g", "inertia": "kg*m^2", "time": "ms", "frequency": "Hz",
        "velocity": "m/s", "angular velocity": "rpm", "acceleration": "m/s^2", "angular acceleration": "rad/s^2",
        "force": "N", "torque": "N*m", "stiffness": "N/m", "angular stiffness": "N*m/rad", "damping": "N*s/m",
        "angular damping": "N*m*s/rad",
    }  # fmt: skip
    for other, unit in units.items():
        if other == dimension:
            assert math.isfinite(to_si(f"1 {unit}", dimension))
        else:
            with pytest.raises(UnitsError, match=f"expected an? {dimension}"):
                to_si(f"1 {unit}", dimension)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("75 degs", "did you mean 'deg'"),
        ("494 grams", "did you mean 'g'"),
        ("3 KG", "did you mean 'kg'"),
        ("0.5", "has no unit; write 0.5 without quotes"),
        ("", "no quantity"),
        ("deg", "no quantity"),
        ("1 2 deg", "cannot read the unit"),
        ("1 m^0", "cannot read the unit"),
        ("1 (m)", "cannot read the unit"),
        ("1 rad" + "*um/mm" * 10, "cannot read the unit"),
        ("1 x" + " " * 4_000_000 + "y", "no quantity"),
        ("nan deg", "no quantity"),
        ("١ deg", "no quantity"),
        ("1e999 deg", "not finite"),
        (math.inf, "not finite"),
        (math.nan, "not finite"),
        (10**400, "not finite"),
        (True, "expected a number"),
        (None, "expected a number"),
        ([1.0], "expected a number"),
    ],
)
def test_what_is_no_angle_is_refused(value: object, words: str) -> None:
    with pytest.raises(UnitsError, match="tilt") as caught:
        to_si(value, "angle", "tilt")
    assert words in str(caught.value)


def test_a_vector_is_all_with_units_or_all_without() -> None:
    lengths: tuple[Dimension, ...] = ("length",) * 3
    assert to_si_vector([1, 2.0, 3], lengths) == (1.0, 2.0, 3.0)
    assert to_si_vector(["1 m", "2 mm", "3 cm"], lengths) == (1.0, 0.002, 0.03)
    with pytest.raises(UnitsError, match="mixes entries with and without a unit"):
        to_si_vector(["1 m", 0, 0], lengths, "com")
    with pytest.raises(UnitsError, match=r"com\[1\]: '2 deg' is an angle, expected a length"):
        to_si_vector(["1 m", "2 deg", "3 m"], lengths, "com")


@given(
    st.one_of(st.text(), st.from_regex(r"\A[0-9]{1,3} ?[a-zA-Z°µ²*/.^0-9-]{1,8}\Z")),
    st.sampled_from(get_args(Dimension)),
)
def test_any_text_is_a_finite_number_or_a_units_error(text: str, dimension: Dimension) -> None:
    try:
        value = to_si(text, dimension)
    except UnitsError:
        value = 0.0
    assert math.isfinite(value)
