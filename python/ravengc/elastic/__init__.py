"""Gravity compensation for arms with elastic joints: cables, harmonic drives, long shafts.

A motor at theta moves its link at q through a spring, both in joint units (M. Spong 1987)::

    M(q) q'' + C q' + g(q) = K (theta - q)          B theta'' + K (theta - q) = u

At rest the spring carries the link: it stands K^-1 g(q) away from its motor, and an encoder on the motor sees nothing
of it. With the gravity torque fed forward at the motors' positions, PD on motor encoders therefore settles with its
motors where they should be and its links beside the goal. :class:`ElasticGravity` aims the motors beyond it::

    u = K_P (theta_d - theta) - K_D theta' + g(at),    theta_d = q_d + K^-1 g(q_d)

============  ===================================  ============  ===================================================
``variant``   gravity is taken at                  left at rest  proven stable where
============  ===================================  ============  ===================================================
desired       the goal q_d                         nothing       least eigenvalue of K_E > alpha (Tomei 1991)
motor         theta, as if rigid                   an error      the same, about a pose that is not q_d
biased        theta - K^-1 g(q_d)                  nothing       the same (De Luca, Siciliano, Zollo 2005)
quasi_static  qbar = theta - K^-1 g(qbar)          nothing       least eigenvalue of K > alpha (Ott et al. 2004)
link          q, from encoders on the links        nothing       not proven; one pose at rest where the same holds
============  ===================================  ============  ===================================================

``K_E = [[K, -K], [-K, K + K_P]]``; ``alpha`` is the largest stiffness of gravity, ``|dg/dq|`` over all poses and all
gravities that occur (:func:`stiffest_gravity`). One spring k and gain p on all joints: ``p > alpha (2 k - alpha) /
(k - alpha)``. The conditions are checked when a law is made, with a proven bound for alpha.

>>> import ravengc as rg
>>> robot = rg.load("raven2_gold")
>>> law = rg.ElasticGravity(robot, [2000.0, 2000.0, 1e5])
>>> theta = [0.785, 1.571, 0.33]
>>> seen_by_no_encoder = theta - law.link_position(theta, rg.Gravity.level())

Sources: P. Tomei, "A simple PD controller for robots with elastic joints", IEEE Trans. Automatic Control 36(10), 1991.
A. De Luca, B. Siciliano, L. Zollo, "PD control with on-line gravity compensation for robots with elastic joints: theory
and experiments", Automatica 41(10), 2005. Ch. Ott, A. Albu-Schaeffer, A. Kugi, S. Stramigioli, G. Hirzinger, "A
passivity based Cartesian impedance controller for flexible joint robots, part I", ICRA 2004 (quasi-static). Why the
conditions suffice is told in ``crates/gravcomp/src/elastic.rs``.
"""

from __future__ import annotations

from ravengc.elastic.alpha import StiffestGravity, stiffest_gravity
from ravengc.elastic.conditions import Condition, condition_for, least_gain, least_spring
from ravengc.elastic.law import VARIANTS, ElasticGravity
from ravengc.elastic.steady import LAWS, Settled, settle, steady_error, steady_errors

__all__ = [
    "LAWS",
    "VARIANTS",
    "Condition",
    "ElasticGravity",
    "Settled",
    "StiffestGravity",
    "condition_for",
    "least_gain",
    "least_spring",
    "settle",
    "steady_error",
    "steady_errors",
    "stiffest_gravity",
]
