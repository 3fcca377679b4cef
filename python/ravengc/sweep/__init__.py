"""An experiment over a grid of its settings or over random draws of them: one table, on any executor, resumable.

>>> import tempfile
>>> from ravengc.sweep import Draw, sweep
>>> with tempfile.TemporaryDirectory() as folder:
...     table = sweep("ship", grid={"duration_s": [1.0]}, random={"roll_deg": Draw(0.0, 20.0)}, trials=3, out=folder)
>>> table.swept
('duration_s', 'roll_deg')
>>> table.columns["sg_j1"].shape
(3,)

Trial ``i`` has settings and a seed that follow from the seed of the sweep and ``i`` alone, so the table is the same,
bit by bit, in any order, on any number of processes or machines (of one instruction set), and after any interruption.
``newton-euler`` is the exception: it measures times.
"""

from __future__ import annotations

from ravengc.experiments.pool import processes
from ravengc.sweep.executors import dask
from ravengc.sweep.folder import read_sweep
from ravengc.sweep.plan import Draw
from ravengc.sweep.running import Progress, sweep
from ravengc.sweep.summary import Summary, summarise
from ravengc.sweep.syntax import read_draw, read_points
from ravengc.sweep.table import SweepTable

__all__ = [
    "Draw",
    "Progress",
    "Summary",
    "SweepTable",
    "dask",
    "processes",
    "read_draw",
    "read_points",
    "read_sweep",
    "summarise",
    "sweep",
]
