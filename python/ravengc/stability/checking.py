"""What a run should be told before it starts, if it is known what its base stands on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc._convert import check_choice, check_type
from ravengc.control import LAWS as ALL_LAWS
from ravengc.stability.certificate import Certificate, certify
from ravengc.stability.mount import Mount
from ravengc.stability.remedy import remedies
from ravengc.stability.system import LAWS, LEVEL, System, linearise

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    import ravengc
    from ravengc.control import Drive
    from ravengc.stability.sensing import Sensing

    Vector = Sequence[float] | NDArray[np.float64]

__all__ = ["advice", "check"]


def check(
    robot: ravengc.Robot,
    mount: Mount,
    sensing: Sensing,
    *,
    q: Vector,
    drive: Drive,
    law: str = "pd+dg",
    gravity: Vector = LEVEL,
    sensor: Vector = (0.0, 0.0, 0.0),
) -> tuple[str, ...]:
    """Return warnings about a robot that ``drive`` holds at ``q`` on this mount under this law; () for none.

    The arguments are those of :func:`linearise`, and any law of a loop. The first warning says what is wrong, the
    others what to change, with numbers.
    """
    check_type(mount, Mount, "mount")
    check_choice(law, ALL_LAWS, "law")
    if law not in LAWS:
        return (f"nothing is certified under the law '{law}': no PD term holds the joints against the base's motion",)
    system = linearise(robot, q, drive, mount, sensing, law=law, gravity=gravity, sensor=sensor)
    certificate = certify(system)
    return certificate.cautions if certificate.certified else (certificate.verdict, *advice(system, certificate))


def advice(system: System, certificate: Certificate) -> tuple[str, ...]:
    """What to change, in words: each alone is enough; () for what is certified."""
    check_type(system, System, "system")
    check_type(certificate, Certificate, "certificate")
    if certificate.certified:
        return ()
    texts = tuple(remedy.text for remedy in remedies(system) if remedy.value is not None)
    return texts or ("take static gravity (pd+sg), which feeds nothing back",)
