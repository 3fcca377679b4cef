"""The methods of the compiled core: what they take, what they refuse and how they say so."""

from __future__ import annotations

import array
import copy
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from core_calls import (
    CALLS,
    NOT_NUMBERS,
    POTENTIAL_ENERGY,
    VALUES,
    WRONG_LAYOUTS,
    WRONG_SHAPES,
    Call,
    N,
    Tagged,
    big_endian,
    misaligned,
    overlapping,
    read_only,
    strided,
)
from ravengc.errors import ArgumentError, RavenGCError

if TYPE_CHECKING:
    from collections.abc import Callable

    import ravengc as rg

every_call = pytest.mark.parametrize("call", CALLS, ids=str)
every_array = pytest.mark.parametrize(
    ("call", "name"), [(call, name) for call in (*CALLS, POTENTIAL_ENERGY) for name in call.arrays], ids=str
)
Q, G = VALUES["q"], VALUES["gravity"]


# out=


@every_call
def test_a_fresh_result_is_a_new_float64_array(panda: rg.Robot, call: Call) -> None:
    one, two = call(panda), call(panda)
    assert type(one) is np.ndarray
    assert one.shape == call.shape
    assert one.dtype == np.float64
    assert one.flags.c_contiguous
    assert not np.shares_memory(one, two)
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(one, call(panda, out=None))


@every_call
def test_out_is_written_and_returned(panda: rg.Robot, call: Call) -> None:
    out = np.full(call.shape, np.nan)
    assert call(panda, out=out) is out
    np.testing.assert_array_equal(out, call(panda))


@every_call
def test_out_may_be_of_a_subclass(panda: rg.Robot, call: Call) -> None:
    out = np.zeros(call.shape).view(Tagged)
    assert call(panda, out=out) is out
    np.testing.assert_array_equal(np.asarray(out), call(panda))


@every_call
def test_arguments_go_by_position_too(panda: rg.Robot, call: Call) -> None:
    positional = getattr(panda, call.name)(*call.arguments().values())
    np.testing.assert_array_equal(positional, call(panda))


@every_call
@pytest.mark.parametrize(("change", "problem"), [*WRONG_SHAPES, *WRONG_LAYOUTS, (read_only, "is read-only")])
def test_an_unfit_out_is_refused(
    panda: rg.Robot, call: Call, change: Callable[[np.ndarray], Any], problem: str
) -> None:
    out = change(np.ones(call.shape))
    before = copy.deepcopy(out)
    with pytest.raises(ArgumentError) as refused:
        call(panda, out=out)
    wanted = str(call.shape)
    for part in ("out ", problem, "expected a", "float64 array of shape " + wanted):
        assert part in str(refused.value)
    np.testing.assert_array_equal(out, before)


@pytest.mark.parametrize("call", [call for call in CALLS if len(call.shape) == 2], ids=str)
def test_out_by_columns_is_refused(panda: rg.Robot, call: Call) -> None:
    with pytest.raises(ArgumentError, match="out is not C-contiguous"):
        call(panda, out=np.zeros(call.shape, order="F"))


@pytest.mark.parametrize(("call", "name"), [(call, name) for call in CALLS for name in call.arrays], ids=str)
def test_an_out_that_shares_memory_with_an_input_is_refused(panda: rg.Robot, call: Call, name: str) -> None:
    values = VALUES[name]
    for given, out in overlapping(values.size, int(np.prod(call.shape))):
        given[:] = values
        with pytest.raises(ArgumentError, match="out shares memory with an input; give it an array of its own"):
            call(panda, out=out.reshape(call.shape), **{name: given})
        np.testing.assert_array_equal(given, values)


@every_call
def test_neighbours_in_one_buffer_are_no_overlap(panda: rg.Robot, call: Call) -> None:
    size = int(np.prod(call.shape))
    buffer = np.zeros(N + size + N)
    buffer[:N] = Q
    out = buffer[N : N + size].reshape(call.shape)
    np.testing.assert_array_equal(call(panda, q=buffer[:N], out=out), call(panda))


def test_a_converted_input_may_overlap_because_it_was_copied(panda: rg.Robot) -> None:
    buffer = np.zeros(2 * N)
    buffer[::2] = Q
    expected = panda.gravity_torque(Q, G)
    np.testing.assert_array_equal(panda.gravity_torque(buffer[::2], G, out=buffer[:N]), expected)


# Inputs


CONVERSIONS: tuple[Callable[[np.ndarray], Any], ...] = (
    np.ndarray.tolist,
    tuple,
    strided,
    big_endian,
    misaligned,
    read_only,
    lambda values: values.astype(np.float32),
    lambda values: values.astype(np.longdouble),
    lambda values: values[::-1].copy()[::-1],
    lambda values: values.view(Tagged),
    lambda values: array.array("d", values.tolist()),
    memoryview,
)


@every_array
@pytest.mark.parametrize("convert", CONVERSIONS)
def test_arrays_of_any_real_kind_are_taken(
    panda: rg.Robot, call: Call, name: str, convert: Callable[[np.ndarray], Any]
) -> None:
    np.testing.assert_array_equal(call(panda, **{name: convert(VALUES[name])}), call(panda))


@pytest.mark.parametrize("kind", [np.int8, np.int32, np.int64, np.uint16, np.float16, int])
def test_whole_numbers_and_small_floats_are_taken(panda: rg.Robot, kind: type) -> None:
    q = [kind(k) for k in range(N)]
    expected = panda.gravity_torque(np.arange(7.0), G)
    np.testing.assert_array_equal(panda.gravity_torque(q, G), expected)
    np.testing.assert_array_equal(panda.gravity_torque(np.array(q, dtype=kind), G), expected)


@every_array
@pytest.mark.parametrize(("change", "problem"), NOT_NUMBERS)
def test_what_is_no_array_of_numbers_is_refused(
    panda: rg.Robot, call: Call, name: str, change: Callable[[np.ndarray], Any], problem: str
) -> None:
    with pytest.raises(ArgumentError, match=f"{name} .*{problem}"):
        call(panda, **{name: change(VALUES[name])})


@every_array
def test_masked_entries_are_refused(panda: rg.Robot, call: Call, name: str) -> None:
    values = VALUES[name]
    with pytest.raises(ArgumentError, match=f"{name} has masked entries"):
        call(panda, **{name: np.ma.masked_array(values, mask=values == values[0])})
    np.testing.assert_array_equal(call(panda, **{name: np.ma.masked_array(values)}), call(panda))


@every_array
@pytest.mark.parametrize(("change", "problem"), WRONG_SHAPES)
@pytest.mark.parametrize("convert", [lambda values: values, lambda values: values.astype(np.float32)])
def test_inputs_of_another_shape_are_refused(
    panda: rg.Robot,
    call: Call,
    name: str,
    change: Callable[[np.ndarray], np.ndarray],
    problem: str,
    convert: Callable[[np.ndarray], np.ndarray],
) -> None:
    with pytest.raises(ArgumentError) as refused:
        call(panda, **{name: convert(change(VALUES[name]))})
    for part in (f"{name} {problem}", f"expected a C-contiguous float64 array of shape ({VALUES[name].size},)"):
        assert part in str(refused.value)


def test_an_error_is_also_a_value_error(panda: rg.Robot) -> None:
    with pytest.raises(ValueError, match="q has shape"):
        panda.gravity_torque([1.0], G)
    assert issubclass(ArgumentError, RavenGCError)


@every_array
def test_nan_in_nan_out(panda: rg.Robot, call: Call, name: str) -> None:
    bad = VALUES[name].copy()
    bad[-1] = np.nan
    assert np.isnan(call(panda, **{name: bad})).any()
    if (call.name, name) == ("gravity_torque", "q"):
        assert np.isnan(call(panda, q=bad)).all()


class Meddler:
    """Converts itself to an array, and does something else on the way."""

    def __init__(self, values: np.ndarray, deed: Callable[[], object]) -> None:
        self.values = values
        self.deed = deed

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        self.deed()
        return self.values


def test_the_robot_may_be_used_and_changed_while_arguments_are_converted(robot: rg.Robot) -> None:
    def deed() -> None:
        robot.set_payload(1.0, (0.0, 0.0, 0.1))
        robot.gravity_torque(Q, G)
        robot.bind(q=Q, gravity=G, out=np.zeros(N))()

    found = robot.gravity_torque(Meddler(Q, deed), G)
    np.testing.assert_array_equal(found, robot.gravity_torque(Q, G))
    robot.set_payload(2.0, Meddler(np.zeros(3), deed))
    robot.set_base(Meddler(np.eye(3), deed))
    robot.set_tool(Meddler(np.eye(3), deed))


def test_an_error_in_a_conversion_comes_through(panda: rg.Robot) -> None:
    with pytest.raises(ZeroDivisionError):
        panda.gravity_torque(Meddler(Q, lambda: 1 / 0), G)
