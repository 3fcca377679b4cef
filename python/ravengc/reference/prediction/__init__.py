"""Prediction of a moving target in plain NumPy: the yardstick of ``ravengc.Predictor``, with the same sources and constants.

Each method has ``update(t, y)`` for a sample of the target's position ``y`` (axes,) in m at time ``t`` in s, in order, and
``at(t)`` for the position and velocity (axes,), (axes,) that it expects at time ``t``, or None while it cannot say.
:class:`Predictor` has all of them with the switch between them; it takes clean samples only: what is wrong with a stream is
the core's business.
"""

from ravengc.reference.prediction.autoregressive import Autoregressive
from ravengc.reference.prediction.fourier import Fourier
from ravengc.reference.prediction.kinematic import Kinematic
from ravengc.reference.prediction.periodic import Cycles, Periodic
from ravengc.reference.prediction.predictor import Predictor
from ravengc.reference.prediction.spectrum import Spectrum

__all__ = ["Autoregressive", "Cycles", "Fourier", "Kinematic", "Periodic", "Predictor", "Spectrum"]
