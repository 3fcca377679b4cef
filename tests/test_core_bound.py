"""Bound cycles: arrays are checked once and held; what becomes of them afterwards is an error or is seen, no crash."""

from __future__ import annotations

import gc
import warnings
import weakref
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from core_calls import (
    ARGUMENTS,
    BINDINGS,
    ROCKING,
    VALUES,
    WRONG_LAYOUTS,
    WRONG_SHAPES,
    Binding,
    N,
    Tagged,
    misaligned,
    overlapping,
    read_only,
)
from ravengc.errors import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Callable

every_binding = pytest.mark.parametrize("binding", BINDINGS, ids=str)
every_input = pytest.mark.parametrize(
    ("binding", "name"), [(binding, name) for binding in BINDINGS for name in binding.inputs], ids=str
)
every_array = pytest.mark.parametrize(
    ("binding", "name"), [(binding, name) for binding in BINDINGS for name in (*binding.inputs, "out")], ids=str
)


@every_binding
def test_a_cycle_computes_what_the_call_computes(robot: rg.Robot, binding: Binding) -> None:
    arrays = binding.arrays()
    cycle = binding.bind(robot, arrays)
    for _ in range(3):
        assert cycle() is None
        np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays))
        for name in binding.inputs:
            arrays[name] *= -0.75


def test_the_base_motion_of_a_cycle_is_that_of_a_call(robot: rg.Robot) -> None:
    binding = BINDINGS[1]
    arrays = binding.arrays()
    binding.bind(robot, arrays)()
    np.testing.assert_array_equal(
        arrays["out"], robot.inverse_dynamics(arrays["q"], arrays["qd"], arrays["qdd"], ROCKING)
    )


@pytest.mark.parametrize("frame", ["base", "panda_link3", "tool", None])
def test_frames_and_axes_of_a_cycle(robot: rg.Robot, frame: str | None) -> None:
    q, pose, jacobian = VALUES["q"].copy(), np.zeros((4, 4)), np.zeros((6, N))
    robot.bind_forward_kinematics(q=q, out=pose, frame=frame)()
    np.testing.assert_array_equal(pose, robot.forward_kinematics(q, frame))
    for axes in ("base", "frame"):
        robot.bind_jacobian(q=q, out=jacobian, frame=frame, axes=axes)()
        np.testing.assert_array_equal(jacobian, robot.jacobian(q, frame, axes))


def test_unknown_frames_and_axes_are_refused_when_bound(robot: rg.Robot) -> None:
    q = np.zeros(N)
    with pytest.raises(ArgumentError, match="no frame 'gripper'"):
        robot.bind_forward_kinematics(q=q, out=np.zeros((4, 4)), frame="gripper")
    with pytest.raises(ArgumentError, match="axes is 'world'"):
        robot.bind_jacobian(q=q, out=np.zeros((6, N)), axes="world")


@every_array
@pytest.mark.parametrize(("change", "problem"), [*WRONG_SHAPES, *WRONG_LAYOUTS])
def test_unfit_arrays_are_refused_when_bound(
    robot: rg.Robot, binding: Binding, name: str, change: Callable[[np.ndarray], Any], problem: str
) -> None:
    arrays = binding.arrays()
    wanted = f"float64 array of shape {arrays[name].shape}"
    with pytest.raises(ArgumentError) as refused:
        binding.bind(robot, arrays | {name: change(np.ones_like(arrays[name]))})
    for part in (f"{name} ", problem, "expected a", wanted):
        assert part in str(refused.value)


@every_binding
def test_inputs_may_be_read_only_but_not_out(robot: rg.Robot, binding: Binding) -> None:
    arrays = binding.arrays()
    inputs = {name: read_only(arrays[name]) for name in binding.inputs}
    binding.bind(robot, inputs | {"out": arrays["out"]})()
    np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays))
    with pytest.raises(ArgumentError, match="out is read-only"):
        binding.bind(robot, arrays | {"out": read_only(arrays["out"])})


@every_input
def test_an_out_that_shares_memory_is_refused_when_bound(robot: rg.Robot, binding: Binding, name: str) -> None:
    arrays = binding.arrays()
    size, total = arrays[name].size, arrays["out"].size
    for given, out in overlapping(size, total):
        with pytest.raises(ArgumentError, match="out shares memory with an input"):
            binding.bind(robot, arrays | {name: given, "out": out.reshape(binding.shape)})
    neighbours = np.zeros(size + total)
    given, out = neighbours[:size], neighbours[size:].reshape(binding.shape)
    given[:] = ARGUMENTS[name]
    binding.bind(robot, arrays | {name: given, "out": out})()
    np.testing.assert_array_equal(out, binding.direct(robot, arrays))


@every_binding
def test_one_array_may_be_several_inputs(robot: rg.Robot, binding: Binding) -> None:
    shared, arrays = np.full(N, 0.5), binding.arrays()
    same = {name: shared for name in binding.inputs if arrays[name].shape == (N,)}
    binding.bind(robot, arrays | same)()
    np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays | same))


@every_binding
def test_arrays_are_held_alive_and_let_go(robot: rg.Robot, binding: Binding) -> None:
    arrays = binding.arrays()
    references = [weakref.ref(array) for array in arrays.values()]
    cycle = binding.bind(robot, arrays)
    expected, out = binding.direct(robot, arrays), arrays["out"]
    del arrays
    gc.collect()
    assert all(reference() is not None for reference in references)
    cycle()
    np.testing.assert_array_equal(out, expected)
    del cycle, out
    gc.collect()
    assert all(reference() is None for reference in references)


@every_binding
def test_the_robot_is_held_alive(binding: Binding) -> None:
    robot, arrays = rg.load("panda"), binding.arrays()
    expected = binding.direct(robot, arrays)
    cycle = binding.bind(robot, arrays)
    del robot
    gc.collect()
    cycle()
    np.testing.assert_array_equal(arrays["out"], expected)


def test_a_robot_that_holds_its_cycle_is_collected() -> None:
    robot, arrays = rg.load("panda"), BINDINGS[0].arrays()
    robot.cycle = BINDINGS[0].bind(robot, arrays)
    reference = weakref.ref(arrays["q"])
    del robot, arrays
    gc.collect()
    assert reference() is None


@every_binding
def test_arrays_of_a_subclass_are_bound(robot: rg.Robot, binding: Binding) -> None:
    arrays = {name: array.view(Tagged) for name, array in binding.arrays().items()}
    binding.bind(robot, arrays)()
    np.testing.assert_array_equal(np.asarray(arrays["out"]), binding.direct(robot, arrays))


@every_input
def test_nan_in_nan_out(robot: rg.Robot, binding: Binding, name: str) -> None:
    arrays = binding.arrays()
    cycle = binding.bind(robot, arrays)
    arrays[name][0] = np.nan
    cycle()
    assert np.isnan(arrays["out"]).any()
    arrays[name][0] = 0.5
    cycle()
    assert np.isfinite(arrays["out"]).all()


@every_binding
def test_payload_base_and_tool_take_effect_at_once(robot: rg.Robot, binding: Binding) -> None:
    arrays = binding.arrays()
    cycle = binding.bind(robot, arrays)
    for change in (
        lambda: robot.set_tool(np.diag([1.0, -1.0, -1.0]), (0.0, 0.1, 0.2)),
        lambda: robot.set_payload(2.0, (0.0, 0.0, 0.1)),
        lambda: robot.set_base(np.diag([-1.0, -1.0, 1.0]), (1.0, 0.0, 0.0)),
        robot.clear_payload,
    ):
        change()
        cycle()
        np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays))


# What is done to an array after it was bound


def resize(size: int) -> Callable[[np.ndarray], None]:
    return lambda array: array.resize(size, refcheck=False)


def reshape(array: np.ndarray) -> None:
    array.shape = (1, *array.shape)


def retype(kind: str) -> Callable[[np.ndarray], None]:
    def change(array: np.ndarray) -> None:
        array.dtype = np.dtype(kind)

    return change


def make_read_only(array: np.ndarray) -> None:
    array.flags.writeable = False


def replace_memory(array: np.ndarray) -> None:
    """Unpickle something else into the same object."""
    array.__setstate__(np.arange(5.0).__reduce__()[2])


def repeat_first(array: np.ndarray) -> None:
    array.strides = (0,) * array.ndim


AFTERWARDS = (
    *map(resize, (0, 1, 10_000)),
    *map(retype, ("i8", "f4", ">f8")),
    reshape,
    replace_memory,
    repeat_first,
)


def apply(change: Callable[[np.ndarray], None], array: np.ndarray) -> None:
    """Make the change, which newer versions of NumPy advise against."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        change(array)


@every_array
@pytest.mark.parametrize("change", AFTERWARDS)
def test_arrays_that_changed_are_refused_when_called(
    robot: rg.Robot, binding: Binding, name: str, change: Callable[[np.ndarray], None]
) -> None:
    arrays = binding.arrays()
    cycle = binding.bind(robot, arrays)
    cycle()
    apply(change, arrays[name])
    before = arrays["out"].copy()
    for _ in range(2):
        with pytest.raises(ArgumentError, match=r"resized, reshaped.* after it was bound; bind again"):
            cycle()
    assert arrays["out"].tobytes() == before.tobytes()


@every_binding
def test_an_out_that_became_read_only_is_not_written(robot: rg.Robot, binding: Binding) -> None:
    arrays = binding.arrays()
    cycle = binding.bind(robot, arrays)
    make_read_only(arrays["out"])
    with pytest.raises(ArgumentError, match="bind again"):
        cycle()
    assert np.isnan(arrays["out"]).all()
    for name in binding.inputs:
        make_read_only(arrays[name])
    arrays["out"].flags.writeable = True
    cycle()
    np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays))


@every_array
def test_a_reshaped_array_may_be_put_right_again(robot: rg.Robot, binding: Binding, name: str) -> None:
    arrays = binding.arrays()
    cycle, shape = binding.bind(robot, arrays), arrays[name].shape
    apply(reshape, arrays[name])
    with pytest.raises(ArgumentError, match="bind again"):
        cycle()
    apply(lambda array: setattr(array, "shape", shape), arrays[name])
    cycle()
    np.testing.assert_array_equal(arrays["out"], binding.direct(robot, arrays))


def test_misaligned_memory_is_never_bound(robot: rg.Robot) -> None:
    q = misaligned(VALUES["q"])
    with pytest.raises(ArgumentError, match="q is not aligned; expected a C-contiguous float64 array"):
        robot.bind(q=q, gravity=np.zeros(3), out=np.zeros(N))


def test_a_cycle_is_bound_by_name(robot: rg.Robot) -> None:
    with pytest.raises(TypeError):
        robot.bind(np.zeros(N), np.zeros(3), np.zeros(N))
