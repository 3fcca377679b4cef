"""The special terms of the dVRK's page for the MTM, as named elements: what each says, and where it jumps.

The page adds to the torques of its masses, with joints from 1,

    tau1 = -0.1 qd1 (damping)                      + (q1 + 0.15) 0.1 + 0.04   where q1 > -0.15 (MTMR of JHU alone)
    tau2 - 0.30 (offset)                           + (q2 - 0.05) 1.0 + 0.05   where q2 < 0.05
    tau3 - m g cos(q2 + q3) (parallel mechanism)   + (q3 - 0.05) 0.1 - 0.07   where q3 < 0.05

and of the wrist's pitch it says "massive spring here, don't know how to deal with this". The cables step at their
thresholds, by 0.04, 0.05 and 0.07 N·m. The m of the parallel mechanism has no lever: read as kg·m, 0.051 reconciles the
page's 0.905 N·m at joint 3 with the 0.405 that the five published files give on average in the same pose.

The spring is that of the dynamic model of Wang et al.: a coil from the platform, 103.5 mm from the pitch's axis, to
7.5 mm from it on the pitch link; rest length 61.3 mm, 270.94 N/m.

Source: jhu-dvrk/sawIntuitiveResearchKit wiki, page 'Control Gravity Compensation'; WPI-AIM/
dvrk_dynamics_identification@7697d3a6 main_mtm.ipynb.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin
from typing import TYPE_CHECKING

from ravengc._convert import check_choice
from ravengc.disturbances import Constant, Friction, Harmonic, PiecewiseCable, SpringBetween
from ravengc.robot import load

if TYPE_CHECKING:
    from ravengc.disturbances import Disturbance, Jump
    from ravengc.spec import RobotSpec

__all__ = ["SpecialTerm", "mtm_with_special_terms", "special_terms"]

MTMS = ("dvrk_mtml", "dvrk_mtmr")
PAGE = "jhu-dvrk/sawIntuitiveResearchKit wiki, page 'Control Gravity Compensation'"
WPI = "WPI-AIM/dvrk_dynamics_identification@7697d3a6 main_mtm.ipynb"
GRAVITY = 9.81
PARALLEL_KG_M = 0.051
COIL_RADIUS, COIL_DISTANCE, COIL_REST, COIL_ANGLE, COIL_STIFFNESS = 0.0075, 0.1035, 0.0613, radians(23.0), 270.94


@dataclass(frozen=True, slots=True)
class SpecialTerm:
    """One of the page's terms: the element, what the page says, what to know, and where the torque jumps."""

    element: Disturbance
    says: str
    remark: str

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Where (rad) the torque steps, and by how much (N·m) from left to right."""
        return self.element.jumps() if isinstance(self.element, PiecewiseCable) else ()


def special_terms(name: str = "dvrk_mtmr") -> tuple[SpecialTerm, ...]:
    """The page's terms for "dvrk_mtml" or "dvrk_mtmr"; the cable of joint 1 is of the right arm alone."""
    check_choice(name, MTMS, "name")
    yaw = _yaw_cable() if name == "dvrk_mtmr" else ()
    return (_damping(), *yaw, *_shoulder(), *_elbow(), _spring())


def mtm_with_special_terms(name: str = "dvrk_mtmr") -> RobotSpec:
    """The bundled MTM, masses mirrored as the page has them, with the page's terms as its elements."""
    terms = special_terms(name)
    spec = load(name).spec
    masses, _, _ = spec.description.partition(" Gravity only:")
    description = f"{masses}\nWith the page's special terms as elements; they belong to a level base."
    elements = tuple(term.element for term in terms)
    return replace(spec, name=f"{name}_page", description=description, disturbances=elements)


def _damping() -> SpecialTerm:
    element = Friction(name="damping", joint="outer_yaw", viscous=-0.1, source=PAGE)
    return SpecialTerm(element, "tau1 = -0.1 qd1", "brakes the arm; not friction that is made up for")


def _yaw_cable() -> tuple[SpecialTerm, ...]:
    element = PiecewiseCable(
        name="yaw cable", joint="outer_yaw", knots=(-0.15,), pieces=((0.0,), (0.04, 0.1)), source=f"{PAGE}: MTMR at JHU"
    )
    return (SpecialTerm(element, "+ (q1 + 0.15) 0.1 + 0.04 where q1 > -0.15", "of one arm: MTMR at JHU"),)


def _shoulder() -> tuple[SpecialTerm, ...]:
    offset = Constant(name="shoulder offset", joint="shoulder_pitch", torque=-0.30, source=PAGE)
    cable = PiecewiseCable(
        name="shoulder cable", joint="shoulder_pitch", knots=(0.05,), pieces=((0.05, 1.0), (0.0,)), source=PAGE
    )
    return (
        SpecialTerm(offset, "tau2 - 0.30", "stands for the counterweight as much as for a cable: does not turn here"),
        SpecialTerm(cable, "+ (q2 - 0.05) 1.0 + 0.05 where q2 < 0.05", ""),
    )


def _elbow() -> tuple[SpecialTerm, ...]:
    parallel = Harmonic(
        name="parallel mechanism",
        joint="elbow_pitch",
        of=(0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        cosine=-PARALLEL_KG_M * GRAVITY,
        source=f"{PAGE}; {PARALLEL_KG_M} kg m inferred from dvrk_config_jhu@033a1946",
    )
    cable = PiecewiseCable(
        name="elbow cable", joint="elbow_pitch", knots=(0.05,), pieces=((-0.07, 0.1), (0.0,)), source=PAGE
    )
    remark = f"the page's m has no lever: read as {PARALLEL_KG_M} kg m; it is gravity, and does not turn here"
    return (
        SpecialTerm(parallel, "tau3 - m g cos(q2 + q3)", remark),
        SpecialTerm(cable, "+ (q3 - 0.05) 0.1 - 0.07 where q3 < 0.05", ""),
    )


def _spring() -> SpecialTerm:
    """The coil: l² = r² + h² - 2 r h cos(pi + q0 - q5) between a point of the platform and one of the pitch link."""
    angle = pi + COIL_ANGLE
    element = SpringBetween(
        name="wrist spring",
        body_a="wrist_platform",
        point_a=(COIL_DISTANCE * cos(angle), COIL_DISTANCE * sin(angle), 0.0),
        body_b="wrist_pitch",
        point_b=(COIL_RADIUS, 0.0, 0.0),
        stiffness=COIL_STIFFNESS,
        rest_length=COIL_REST,
        source=WPI,
    )
    return SpecialTerm(element, "massive spring here, don't know how to deal with this", "a coil between two links")
