"""What the numbers should come to at seven joints, and what they came to.

A bar is judged by the median. Beside it stands the same in the fastest tenth of the rounds, and what the peer took in
the same run: on a slow host all are slow, and the fastest tenth is further off.
"""

from __future__ import annotations

from typing import Any

PEER = "pinocchio"

WAYS = {"times_out": "out=", "times_bind": "bind"}

Results = dict[str, Any]
Value = float | None
NOTHING: tuple[Value, Value] = (None, None)


def bars(results: Results) -> list[Results]:
    """Every bar with its measured value, ``None`` where that could not be measured."""
    return [
        *ratios(results["hot"]),
        *paced(results["paced"]),
        *batch(results["batch"]),
        *absolute(results),
    ]


def bar(
    name: str,
    wanted: float,
    measured: tuple[Value, Value],
    peer: tuple[Value, Value] = NOTHING,
    *,
    at_least: bool = False,
) -> Results:
    """``measured`` and ``peer`` are medians, then what the fastest tenth came to."""
    median, fast = measured
    holds = None if median is None else (median >= wanted if at_least else median <= wanted)
    found = {"name": name, "wanted": wanted, "at_least": at_least, "measured": median, "fast": fast}
    return {**found, "peer": peer[0], "peer_fast": peer[1], "holds": holds}


def pick(rows: list[Results], **wanted: str) -> Results:
    """The first row with these entries, or an empty one."""
    return next((row for row in rows if all(row[key] == value for key, value in wanted.items())), {})


def times(row: Results) -> tuple[Value, Value]:
    """Of a hot loop, µs."""
    return row.get("median_us"), row.get("fast_us")


def ticks(row: Results) -> tuple[Value, Value]:
    """Once a millisecond, µs."""
    return row.get("p50_us"), row.get("p10_us")


def over(slow: Value, fast: Value) -> Value:
    return None if slow is None or fast is None else slow / fast


def ratios(hot: list[Results]) -> list[Results]:
    """Times faster than pinocchio in a hot loop."""
    wanted = [
        ("gravity", "times_out", 8.0),
        ("gravity", "times_bind", 12.0),
        ("jacobian", "times_out", 6.0),
        ("jacobian", "times_bind", 6.0),
        ("kinematics", "times_out", 8.0),
        ("kinematics", "times_bind", 8.0),
    ]
    found = []
    for operation, way, least in wanted:
        peer = pick(hot, library=PEER, operation=operation)
        ours = pick(hot, library="ravengc", operation=operation, way=WAYS[way])
        measured = (peer.get(way), over(peer.get("fast_us"), ours.get("fast_us")))
        name = f"{operation}, {WAYS[way]}: times faster than {PEER}"
        found.append(bar(name, least, measured, times(peer), at_least=True))
    return found


def paced(rows: list[Results]) -> list[Results]:
    """Once a millisecond, in a loop that does nothing else."""
    ours, peer = (alone(pick(rows, **which)) for which in ({"library": "ravengc", "way": "bind"}, {"library": PEER}))
    ratio = (peer.get("times_bind"), over(peer.get("p10_us"), ours.get("p10_us")))
    return [
        bar("gravity at 1 kHz, bind: p50 µs", 3.5, ticks(ours), ticks(peer)),
        bar(f"gravity at 1 kHz, bind: times faster than {PEER}", 5.0, ratio, ticks(peer), at_least=True),
    ]


def alone(row: Results) -> Results:
    """What was measured without other libraries in between, if the row was."""
    found: Results = row.get("alone", {})
    return found


def batch(found: Results) -> list[Results]:
    """Rates of few rounds: the fastest is the best."""
    best, portable, peer = (
        rates(pick(found["rates"], how=how))
        for how in ("ravengc, 1 thread", "ravengc, portable build", f"{PEER}, rneaInParallel, 1 thread")
    )
    return [
        bar("batch on one core, best build: M/s", 18.0, best, peer, at_least=True),
        bar("batch on one core, portable build: M/s", 8.0, portable, peer, at_least=True),
    ]


def rates(row: Results) -> tuple[Value, Value]:
    """Of batches, M/s."""
    return row.get("median"), row.get("best")


def absolute(results: Results) -> list[Results]:
    """Bars that no peer sets."""
    hot, imports = results["hot"], results["imports"]
    bound, out = (pick(hot, library="ravengc", operation="gravity", way=way) for way in ("bind", "out="))
    live = pick(hot, library="ravengc", operation="control_live", way="bind")
    paced_live = alone(pick(results["paced_control"], operation="control_live", way="bind"))
    moving = pick(hot, library="ravengc", operation="moving_base", way="bind")
    peer = times(pick(hot, library=PEER, operation="moving_base"))
    return [
        bar("inverse dynamics on a moving base, bind: µs", 0.45, times(moving), peer),
        bar("control step with a live sensor, bind: µs", 0.35, times(live)),
        bar("control step with a live sensor at 1 kHz, bind: p50 µs", 5.0, ticks(paced_live)),
        bar("heap allocations per control step", 0.0, (live.get("allocations"), None)),
        bar("heap allocations per cycle, bind", 0.0, (bound.get("allocations"), None)),
        bar("heap allocations per cycle, out=", 0.0, (out.get("allocations"), None)),
        bar("gravity error in eps Σ m g r", 8.0, (bound.get("rounding_units"), None)),
        bar("import after numpy: ms", 10.0, (imports.get("ravengc"), None), (imports.get(PEER), None)),
    ]
