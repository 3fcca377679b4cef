"""Batches: the single calls over many samples, whatever the number of threads, without the interpreter's lock."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from core_calls import (
    CALLS,
    NOT_NUMBERS,
    POTENTIAL_ENERGY,
    ROCKING,
    ROCKING_ROW,
    WRONG_LAYOUTS,
    Call,
    N,
    big_endian,
    deeper,
    longer,
    overlapping,
    read_only,
    strided,
)
from ravengc.errors import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Callable

BATCHES = (*CALLS, POTENTIAL_ENERGY)
SAMPLES = 21
"""More than two blocks of eight lanes, and not a multiple."""

WIDTHS = {"gravity": 3, "base": 9}

every_batch = pytest.mark.parametrize("call", BATCHES, ids=str)
every_array = pytest.mark.parametrize(
    ("call", "name"), [(call, name) for call in BATCHES for name in call.arrays], ids=str
)
in_gravity = pytest.mark.parametrize("call", [call for call in BATCHES if "gravity" in call.inputs], ids=str)
on_base = pytest.mark.parametrize("call", [call for call in BATCHES if "base" in call.inputs], ids=str)


def rows(call: Call, samples: int = SAMPLES) -> dict[str, np.ndarray]:
    """One row per sample for every argument, gravity and base too."""
    random = np.random.default_rng(7)
    return {name: 4.0 * random.uniform(-1, 1, (samples, WIDTHS.get(name, N))) for name in call.inputs}


def batch(robot: rg.Robot, call: Call, arguments: dict[str, Any], **options: Any) -> np.ndarray:
    return getattr(robot, f"{call.name}_batch")(**arguments, **options)


def one_by_one(robot: rg.Robot, call: Call, arguments: dict[str, np.ndarray]) -> np.ndarray:
    """The single call for every row."""
    results = []
    for sample in zip(*arguments.values(), strict=True):
        row = dict(zip(arguments, sample, strict=True))
        if "base" in row:
            force, spin, change = np.split(row["base"], 3)
            row["base"] = rg.BaseMotion(specific_force=force, angular_velocity=spin, angular_acceleration=change)
        results.append(getattr(robot, call.name)(**row))
    return np.array(results).reshape(-1, *call.shape)


@every_batch
def test_a_batch_is_the_single_call_for_every_sample(panda: rg.Robot, call: Call) -> None:
    arguments = rows(call)
    found = batch(panda, call, arguments)
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, one_by_one(panda, call, arguments))


@pytest.mark.parametrize("name", ["dvrk_psm_si", "raven2_gold"])
@pytest.mark.parametrize("call", [CALLS[0], CALLS[3]], ids=str)
def test_batches_of_coupled_and_sliding_robots(name: str, call: Call) -> None:
    robot = rg.load(name)
    arguments = {key: value[:, : WIDTHS.get(key, robot.n)].copy() for key, value in rows(call).items()}
    expected = [one_by_one(robot, Call(call.name, call.inputs, (robot.n,)), arguments)]
    np.testing.assert_array_equal([batch(robot, call, arguments)], expected)


@every_batch
@pytest.mark.parametrize("samples", [0, 1, 7, 8, 9])
def test_few_samples(panda: rg.Robot, call: Call, samples: int) -> None:
    arguments = rows(call, samples)
    found = batch(panda, call, arguments)
    assert found.shape == (samples, *call.shape)
    np.testing.assert_array_equal(found, one_by_one(panda, call, arguments))


@every_batch
def test_threads_change_no_bit(panda: rg.Robot, call: Call) -> None:
    arguments = rows(call, 1537)
    one = batch(panda, call, arguments, threads=1)
    for threads in (2, 3, 0, 1000):
        np.testing.assert_array_equal(batch(panda, call, arguments, threads=threads), one)


@pytest.mark.parametrize("threads", [-1, -(2**40), 2**70])
def test_an_impossible_number_of_threads_is_refused(panda: rg.Robot, threads: int) -> None:
    with pytest.raises(ArgumentError):
        panda.gravity_torque_batch(np.zeros((2, N)), (0, 0, -9.81), threads=threads)


def test_refused_threads_say_what_is_expected(panda: rg.Robot) -> None:
    with pytest.raises(ArgumentError, match=r"threads is -1; expected 0 \(all cores\) or a positive number"):
        panda.mass_matrix_batch(np.zeros((2, N)), threads=-1)


@in_gravity
def test_gravity_may_be_common(panda: rg.Robot, call: Call) -> None:
    q, g = rows(call)["q"], (0.5, -1.0, -9.5)
    expected = batch(panda, call, {"q": q, "gravity": np.tile(g, (SAMPLES, 1))})
    assert np.array_equal(batch(panda, call, {"q": q.tolist(), "gravity": [g] * SAMPLES}), expected)
    for same in (g, list(g), np.array(g), rg.Gravity(*g), rg.Gravity(*g).as_specific_force()):
        np.testing.assert_array_equal(batch(panda, call, {"q": q, "gravity": same}), expected)


@on_base
def test_the_base_motion_may_be_common(panda: rg.Robot, call: Call) -> None:
    arguments = rows(call)
    each = batch(panda, call, arguments | {"base": np.tile(ROCKING_ROW, (SAMPLES, 1))})
    np.testing.assert_array_equal(batch(panda, call, arguments | {"base": [ROCKING_ROW.tolist()] * SAMPLES}), each)
    np.testing.assert_array_equal(batch(panda, call, arguments | {"base": ROCKING}), each)
    at_rest = np.zeros((SAMPLES, 9))
    at_rest[:, 2] = 9.75
    each = batch(panda, call, arguments | {"base": at_rest})
    for same in (rg.Gravity(0, 0, -9.75), rg.SpecificForce(0, 0, 9.75)):
        np.testing.assert_array_equal(batch(panda, call, arguments | {"base": same}), each)


@on_base
@pytest.mark.parametrize("bare", [np.zeros(3), np.zeros((SAMPLES, 3)), (0.0, 0.0, 9.81), None])
def test_a_bare_vector_is_no_base(panda: rg.Robot, call: Call, bare: object) -> None:
    with pytest.raises(ArgumentError, match=r"base .*expected"):
        batch(panda, call, rows(call) | {"base": bare})


def test_three_samples_with_one_gravity_vector(panda: rg.Robot) -> None:
    q = rows(CALLS[0], 3)["q"]
    common, each = (np.array([1.0, 2.0, 3.0]), np.array([[1.0, 2.0, 3.0]] * 3))
    np.testing.assert_array_equal(panda.gravity_torque_batch(q, common), panda.gravity_torque_batch(q, each))


# out=


@every_batch
def test_out_is_written_and_returned(panda: rg.Robot, call: Call) -> None:
    arguments = rows(call)
    out = np.full((SAMPLES, *call.shape), np.nan)
    assert batch(panda, call, arguments, out=out, threads=2) is out
    np.testing.assert_array_equal(out, batch(panda, call, arguments))


@every_batch
@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (longer, "has shape"),
        (deeper, "has shape"),
        (lambda out: out[:-1].copy(), "has shape"),
        (read_only, "is read-only"),
        *WRONG_LAYOUTS,
    ],
)
def test_an_unfit_out_is_refused(
    panda: rg.Robot, call: Call, change: Callable[[np.ndarray], Any], problem: str
) -> None:
    shape = (SAMPLES, *call.shape)
    with pytest.raises(ArgumentError) as refused:
        batch(panda, call, rows(call), out=change(np.ones(shape)))
    for part in ("out ", problem, "expected a", f"float64 array of shape {shape}"):
        assert part in str(refused.value)


@pytest.mark.parametrize(("call", "name"), [(call, name) for call in BATCHES for name in call.inputs], ids=str)
def test_an_out_that_shares_memory_is_refused(panda: rg.Robot, call: Call, name: str) -> None:
    arguments, shape = rows(call), (SAMPLES, *call.shape)
    for given, out in overlapping(arguments[name].size, int(np.prod(shape))):
        shared = arguments | {name: given.reshape(arguments[name].shape)}
        with pytest.raises(ArgumentError, match="out shares memory with an input"):
            batch(panda, call, shared, out=out.reshape(shape))


# Inputs


@every_array
@pytest.mark.parametrize("convert", [np.ndarray.tolist, strided, big_endian, read_only, np.asfortranarray])
def test_rows_of_any_real_kind_are_taken(
    panda: rg.Robot, call: Call, name: str, convert: Callable[[np.ndarray], Any]
) -> None:
    arguments = rows(call)
    expected = batch(panda, call, arguments)
    found = batch(panda, call, arguments | {name: convert(arguments[name])})
    np.testing.assert_array_equal(found, expected)


def test_rows_of_smaller_types_are_taken(panda: rg.Robot) -> None:
    q = np.arange(-35, 35).reshape(10, 7)
    expected = panda.gravity_torque_batch(q.astype(float), (0, 0, -9.75))
    for kind in (np.int8, np.int64, np.float16, np.float32):
        np.testing.assert_array_equal(panda.gravity_torque_batch(q.astype(kind), (0, 0, -9.75)), expected)


@every_array
@pytest.mark.parametrize(("change", "problem"), NOT_NUMBERS)
def test_what_is_no_array_of_numbers_is_refused(
    panda: rg.Robot, call: Call, name: str, change: Callable[[np.ndarray], Any], problem: str
) -> None:
    arguments = rows(call)
    with pytest.raises(ArgumentError, match=f"{name} .*{problem}|{name} has shape"):
        batch(panda, call, arguments | {name: change(arguments[name])})


@every_array
@pytest.mark.parametrize("change", [longer, deeper, np.ravel])
def test_rows_of_another_shape_are_refused(
    panda: rg.Robot, call: Call, name: str, change: Callable[[np.ndarray], np.ndarray]
) -> None:
    arguments = rows(call)
    with pytest.raises(ArgumentError, match=rf"{name} has shape .*expected"):
        batch(panda, call, arguments | {name: change(arguments[name])})


@pytest.mark.parametrize(
    ("call", "name"), [(call, name) for call in BATCHES for name in call.inputs if name != "q"], ids=str
)
def test_a_sample_too_few_is_refused(panda: rg.Robot, call: Call, name: str) -> None:
    arguments = rows(call)
    with pytest.raises(ArgumentError, match=rf"{name} has shape .*expected .*\({SAMPLES}, "):
        batch(panda, call, arguments | {name: arguments[name][:-1].copy()})


@every_batch
def test_a_bad_sample_spoils_no_other(panda: rg.Robot, call: Call) -> None:
    arguments = rows(call)
    expected = batch(panda, call, arguments)
    arguments["q"][10] = np.nan
    found = batch(panda, call, arguments)
    others = np.arange(SAMPLES) != 10
    assert np.isnan(found[10]).any()
    np.testing.assert_allclose(found[others], expected[others], rtol=0, atol=1e-13 * np.abs(expected).max())


# The interpreter's lock


def test_other_threads_run_meanwhile(panda: rg.Robot) -> None:
    """This thread takes the time in the middle half of a batch that another thread computes: it was given the lock."""
    call = next(call for call in CALLS if call.name == "forward_dynamics")
    arguments, times = rows(call, 100_000), []

    def work() -> None:
        times.append(time.perf_counter())
        batch(panda, call, arguments)
        times.append(time.perf_counter())

    worker = threading.Thread(target=work)
    taken = []
    worker.start()
    while worker.is_alive():
        taken.append(time.perf_counter())
    start, end = times
    quarter = (end - start) / 4
    assert any(start + quarter < moment < end - quarter for moment in taken)


def test_batches_in_many_threads_at_once(panda: rg.Robot) -> None:
    arguments = rows(CALLS[0], 2000)
    expected = batch(panda, CALLS[0], arguments)
    results: list[np.ndarray] = []
    workers = [
        threading.Thread(target=lambda: results.append(batch(panda, CALLS[0], arguments, threads=2))) for _ in range(8)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(results) == len(workers)
    for result in results:
        np.testing.assert_array_equal(result, expected)


def test_a_batch_computes_with_the_robot_as_it_was_when_called() -> None:
    """While a payload comes and goes, every batch is computed with it or without it, never with a mixture."""
    robot, arguments = rg.load("panda"), rows(CALLS[0], 20_000)
    without = batch(robot, CALLS[0], arguments)
    robot.set_payload(3.0, (0.0, 0.0, 0.1))
    loaded = batch(robot, CALLS[0], arguments)
    results: list[np.ndarray] = []
    worker = threading.Thread(target=lambda: results.extend(batch(robot, CALLS[0], arguments) for _ in range(20)))
    worker.start()
    while worker.is_alive():
        robot.clear_payload()
        robot.set_payload(3.0, (0.0, 0.0, 0.1))
    assert len(results) == 20
    for result in results:
        assert np.array_equal(result, without) or np.array_equal(result, loaded)
