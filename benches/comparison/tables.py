"""What was measured, as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from comparison.bars import PEER
from comparison.call import OPERATIONS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import RenderableType

Results = dict[str, Any]


def all_tables(results: Results) -> Iterator[RenderableType]:
    """Every table, in the order of measuring."""
    for operation, title in OPERATIONS.items():
        yield hot(title, [row for row in results["hot"] if row["operation"] == operation])
    yield paced("gravity torque, new gravity vector", results["paced"])
    yield paced("control step; the second bind also steps the base sensor", results["paced_control"])
    yield batch(results["batch"])
    yield imports(results["imports"])
    yield bars(results["bars"])


def table(title: str, *columns: str) -> Table:
    """A table whose first columns are text and whose numbers stand to the right."""
    found = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for column in columns:
        text = column in {"library", "how", "bar", "holds"}
        found.add_column(column, justify="left" if text else "right", no_wrap=True)
    return found


def number(x: float | None, decimals: int) -> str:
    return "-" if x is None else f"{x:,.{decimals}f}"


def hot(title: str, rows: list[Results]) -> Table:
    columns = ["library", "how", "median µs", "fast µs", "x bind", "x out=", "mallocs", "off by"]
    if any(row["rounding_units"] is not None for row in rows):
        columns.append("eps Σmgr")
    found = table(f"Hot loop: {title}", *columns)
    for row in rows:
        cells = [number(row["median_us"], 3), number(row["fast_us"], 3)]
        cells += [number(row["times_bind"], 1), number(row["times_out"], 1), number(row["allocations"], 1)]
        cells += [f"{row['off']:.0e}", number(row["rounding_units"], 1)][: len(columns) - 7]
        found.add_row(row["library"], row["way"], *cells)
    return found


def paced(what: str, rows: list[Results]) -> Table:
    title = f"Paced at 1 kHz, alone and among the others' ticks, µs: {what}"
    found = table(title, "library", "how", "alone p50", "p99", "x bind", "among p50", "p99", "x bind")
    for row in rows:
        cells = [
            number(row[where][name], 1) for where in ("alone", "among") for name in ("p50_us", "p99_us", "times_bind")
        ]
        found.add_row(row["library"], row["way"], *cells)
    return found


def batch(found: Results) -> Table:
    title = f"Batch of {found['samples']:,}: gravity torque, millions of configurations per second"
    rows = table(title, "how", "median M/s", "best M/s", "x slower than ravengc, 1 thread")
    for row in found["rates"]:
        rows.add_row(row["how"], number(row["median"], 2), number(row["best"], 2), number(row["times_slower"], 1))
    return rows


def imports(found: dict[str, float]) -> Table:
    rows = table("Import, fresh process", "library", "ms")
    for name, ms in found.items():
        rows.add_row("numpy itself" if name == "numpy" else f"{name}, after numpy", number(ms, 1))
    return rows


def bars(found: list[Results]) -> Table:
    rows = table("Bars, judged by the median", "bar", "wanted", "median", "fast", "holds", f"{PEER} median", "fast")
    for bar in found:
        sign = "≥" if bar["at_least"] else "≤"
        verdict = {True: "[green]yes[/]", False: "[red]no[/]", None: "-"}[bar["holds"]]
        ours, peer = ([number(bar[key], 2) for key in keys] for keys in (("measured", "fast"), ("peer", "peer_fast")))
        rows.add_row(bar["name"], f"{sign} {bar['wanted']:g}", *ours, verdict, *peer)
    return rows
