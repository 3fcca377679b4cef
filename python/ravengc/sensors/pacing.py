"""Due times on a grid of CLOCK_MONOTONIC, waited for without passing a deadline."""

from __future__ import annotations

import time

__all__ = ["wait_until"]


def wait_until(due_ns: int, timeout_s: float) -> bool:
    """Sleep until ``due_ns`` (CLOCK_MONOTONIC), or for ``timeout_s`` if that is sooner; tell whether it is due."""
    left_s = (due_ns - time.monotonic_ns()) * 1e-9
    if left_s > 0.0:
        time.sleep(min(left_s, max(timeout_s, 0.0)))
    return time.monotonic_ns() >= due_ns
