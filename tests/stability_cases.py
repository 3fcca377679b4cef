"""Cases for the tests of the certificate: the reference example, random links, random systems."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from ravengc.experiments.base_feedback import BaseFeedback, link_of
from ravengc.stability import OneLink, Sensing, System

EX1 = link_of(BaseFeedback())
"""A light base of 2.5 Hz under a link whose sensor is 20 ms late behind a low-pass of 10 Hz: it swings up."""


@st.composite
def links(draw: st.DrawFn, *, delay: bool = True) -> OneLink:
    """Any link on any base; without ``delay``, behind a low-pass."""
    mass, length = draw(st.floats(0.2, 20.0)), draw(st.floats(0.05, 2.0))
    inertia = mass * length**2 * draw(st.floats(1.01, 5.0))
    joint = 2.0 * np.pi * draw(st.floats(0.5, 10.0))
    cutoffs = st.floats(3.0, 200.0)
    return OneLink(
        base_mass=mass * draw(st.floats(0.2, 50.0)),
        base_frequency_hz=draw(st.floats(0.3, 10.0)),
        base_damping_ratio=draw(st.floats(0.001, 0.3)),
        mass=mass,
        length=length,
        inertia=inertia,
        kp=inertia * joint**2,
        kd=2.0 * draw(st.floats(0.05, 1.5)) * inertia * joint,
        sensing=Sensing(
            rate_hz=draw(st.sampled_from((None, 50.0, 100.0, 1000.0))) if delay else None,
            latency_s=draw(st.floats(0.001, 0.08)) if delay else 0.0,
            cutoff_hz=draw(st.one_of(st.none(), cutoffs) if delay else cutoffs),
            order=draw(st.sampled_from((1, 2))),
            gain=draw(st.sampled_from((1.0, 0.6, 1.4))),
        ),
    )


def random_system(seed: int, *, delay: bool) -> System:
    """Two to five coordinates, one to three signals, nothing symmetric but the mass."""
    random = np.random.default_rng(seed)
    n, r = int(random.integers(2, 6)), int(random.integers(1, 4))

    def near(size: float) -> np.ndarray:
        matrix = random.standard_normal((n, n))
        return size * (np.eye(n) + 0.3 * matrix)

    root = np.eye(n) + 0.3 * random.standard_normal((n, n))
    cutoff = (None, 4.0, 15.0)[int(random.integers(3))]
    return System(
        mass=(root @ root.T + (root @ root.T).T) / 2.0,
        damping=near(random.uniform(0.2, 3.0)),
        stiffness=near(random.uniform(20.0, 200.0)),
        inputs=0.5 * random.standard_normal((n, r)),
        reads_acceleration=0.5 * random.standard_normal((r, n)),
        reads_position=random.standard_normal((r, n)),
        base=1,
        turns=(False,) * n,
        sensing=Sensing(
            rate_hz=None,
            latency_s=random.uniform(0.0, 0.1) if delay else 0.0,
            cutoff_hz=cutoff,
            order=int(random.integers(1, 3)),
            gain=random.uniform(0.2, 1.5),
        ),
    )
