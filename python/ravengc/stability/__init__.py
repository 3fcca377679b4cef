"""The loop that nobody draws: accelerometer, gravity torque, arm, reaction on the base, accelerometer; its certificate.

A gravity torque that follows the base's accelerometer pushes the arm, the arm pushes the base, and the base's
accelerometer feels it. On a light or weakly damped base, with a late sensor, that swings up. :func:`linearise` writes
base, arm, law and sensor as one linear system with a delay, :func:`certify` proves how many of its poles are unstable
and how far from that it is, :func:`remedies` what to change, and :func:`check` says so before a run.

>>> import ravengc as rg
>>> from ravengc import control, stability
>>> robot, q = rg.load("raven2_gold"), (0.8, 1.6, 0.4)
>>> mount = stability.parse_mount("5:3:0.01:y")
>>> sensing = stability.Sensing(rate_hz=100.0, latency_s=0.03, cutoff_hz=20.0)
>>> system = stability.linearise(robot, q, control.drive_for(robot, q), mount, sensing)
>>> stability.certify(system).certified
True
"""

from __future__ import annotations

from ravengc.stability.certificate import Certificate, certify
from ravengc.stability.checking import advice, check
from ravengc.stability.counting import Count, poles_right_of
from ravengc.stability.loop_margins import Margins, Mode, base_modes, loci, margins
from ravengc.stability.mount import Mount, directions_of, parse_mount
from ravengc.stability.one_link import OneLink
from ravengc.stability.remedy import Remedy, remedies
from ravengc.stability.roots import Pole, poles, rightmost_pole
from ravengc.stability.sensing import Sensing
from ravengc.stability.simulation import Growth, simulate
from ravengc.stability.system import System, linearise
from ravengc.stability.trials import Tally, campaign

__all__ = [
    "Certificate",
    "Count",
    "Growth",
    "Margins",
    "Mode",
    "Mount",
    "OneLink",
    "Pole",
    "Remedy",
    "Sensing",
    "System",
    "Tally",
    "advice",
    "base_modes",
    "campaign",
    "certify",
    "check",
    "directions_of",
    "linearise",
    "loci",
    "margins",
    "parse_mount",
    "poles",
    "poles_right_of",
    "remedies",
    "rightmost_pole",
    "simulate",
]
