"""All methods of ``ravengc track`` with all seeds, and what is kept: the first run whole, numbers of the rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import progress_bar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.cli.track_setup import Setup
    from ravengc.track import TrackResult

__all__ = ["Runs", "run_all"]


@dataclass(kw_only=True)
class Runs:
    """By method, the one that counts first: the run with the first seed, and a summary for every seed that was done.

    ``interrupted`` says in a sentence what Ctrl-C left of it, "" if nothing did.
    """

    first: dict[str, TrackResult] = field(default_factory=dict)
    summaries: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    interrupted: str = ""

    @property
    def seeds(self) -> int:
        """How many seeds were done with every method."""
        return len(next(iter(self.summaries.values())))

    def add(self, name: str, result: TrackResult) -> None:
        """Keep a run."""
        self.first.setdefault(name, result)
        self.summaries.setdefault(name, []).append(result.summary())

    def stop(self, name: str, seed: int, result: TrackResult, methods: Sequence[str]) -> None:
        """Keep what Ctrl-C left of a run if there is no whole one; of several seeds, those that all methods had."""
        reached = len(result.visits) - result.visits.count("not visited")
        self.interrupted = f"stopped by Ctrl-C in {name}, seed {seed}, after {reached} of {len(result.visits)} points"
        if not self.summaries:
            self.add(name, result)
            return
        self.interrupted += ": that run does not count"
        whole = max(1, min(len(self.summaries.get(method, ())) for method in methods))
        self.summaries = {method: found[:whole] for method, found in self.summaries.items()}


def run_all(setup: Setup) -> Runs:
    """Run all methods with all seeds, one after the other: the cost of a cycle is measured. Ctrl-C ends it early."""
    from ravengc.track import track

    seeds = range(setup.first_seed, setup.first_seed + setup.seeds)
    points, runs, done = len(setup.surface), Runs(), 0
    with progress_bar() as bar:
        task = bar.add_task("", total=len(setup.methods) * len(seeds) * points)
        for seed in seeds:
            motion, camera = setup.motion_of(seed), setup.camera_of(seed)
            for name, settings in setup.methods.items():
                bar.update(task, description=name if len(seeds) == 1 else f"{name}, seed {seed}")

                def tell(visited: int, _: int, before: int = done) -> None:
                    bar.update(task, completed=before + min(visited, points))

                result = track(setup.robot, setup.surface, motion, camera, settings, tell)
                if result.interrupted:
                    runs.stop(name, seed, result, list(setup.methods))
                    return runs
                runs.add(name, result)
                done += points
    return runs
