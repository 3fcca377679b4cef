"""What the numbers should come to at seven joints, and what they came to."""

from __future__ import annotations

from typing import Any

PEER = "pinocchio"

WAYS = {"times_out": "out=", "times_bind": "bind"}

Results = dict[str, Any]


def bars(results: Results) -> list[Results]:
    """Every bar with its measured value, ``None`` where that could not be measured."""
    return [
        *ratios(results["hot"]),
        *paced(results["paced"]),
        *batch(results["batch"]),
        *absolute(results),
    ]


def bar(name: str, wanted: float, measured: float | None, *, at_least: bool = False) -> Results:
    holds = None if measured is None else (measured >= wanted if at_least else measured <= wanted)
    return {"name": name, "wanted": wanted, "at_least": at_least, "measured": measured, "holds": holds}


def pick(rows: list[Results], **wanted: str) -> Results:
    """The first row with these entries, or an empty one."""
    return next((row for row in rows if all(row[key] == value for key, value in wanted.items())), {})


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
    return [
        bar(
            f"{operation}, {WAYS[way]}: times faster than {PEER}",
            least,
            pick(hot, library=PEER, operation=operation).get(way),
            at_least=True,
        )
        for operation, way, least in wanted
    ]


def paced(rows: list[Results]) -> list[Results]:
    """Once a millisecond, in a loop that does nothing else."""
    ours, peer = (alone(pick(rows, **which)) for which in ({"library": "ravengc", "way": "bind"}, {"library": PEER}))
    return [
        bar("gravity at 1 kHz, bind: p50 µs", 3.5, ours.get("p50_us")),
        bar(f"gravity at 1 kHz, bind: times faster than {PEER}", 5.0, peer.get("times_bind"), at_least=True),
    ]


def alone(row: Results) -> Results:
    """What was measured without other libraries in between, if the row was."""
    found: Results = row.get("alone", {})
    return found


def batch(found: Results) -> list[Results]:
    best, portable = pick(found["rates"], how="ravengc, 1 thread"), pick(found["rates"], how="ravengc, portable build")
    return [
        bar("batch on one core, best build: M/s", 18.0, best.get("median"), at_least=True),
        bar("batch on one core, portable build: M/s", 8.0, portable.get("median"), at_least=True),
    ]


def absolute(results: Results) -> list[Results]:
    """Bars that no peer sets."""
    hot = results["hot"]
    bound, out = (pick(hot, library="ravengc", operation="gravity", way=way) for way in ("bind", "out="))
    live = pick(hot, library="ravengc", operation="control_live", way="bind")
    paced_live = alone(pick(results["paced_control"], operation="control_live", way="bind"))
    moving = pick(hot, library="ravengc", operation="moving_base", way="bind")
    return [
        bar("inverse dynamics on a moving base, bind: µs", 0.45, moving.get("median_us")),
        bar("control step with a live sensor, bind: µs", 0.35, live.get("median_us")),
        bar("control step with a live sensor at 1 kHz, bind: p50 µs", 5.0, paced_live.get("p50_us")),
        bar("heap allocations per control step", 0.0, live.get("allocations")),
        bar("heap allocations per cycle, bind", 0.0, bound.get("allocations")),
        bar("heap allocations per cycle, out=", 0.0, out.get("allocations")),
        bar("gravity error in eps Σ m g r", 8.0, bound.get("rounding_units")),
        bar("import after numpy: ms", 10.0, results["imports"].get("ravengc")),
    ]
