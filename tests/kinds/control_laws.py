"""Every control law that is shipped, continuous and sampled."""

import numpy as np

import poinsot as pt
from kinds.forces import ELLIPSE
from poinsot.control import NoisySensors, OrbitPointing, QuaternionFeedback, RateDamping, Sampled

BODY = pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
TARGET = np.array((0.1, 0.3, -0.5, 0.8)) / np.sqrt(0.99)
LAWS = (
    QuaternionFeedback(0.8, 0.7, 0.5, TARGET),
    OrbitPointing(0.8, 0.7, 0.5, ELLIPSE, TARGET),
    RateDamping(0.8, 0.4),
)
SAMPLED = (
    *(Sampled(law, 0.2, 0.1) for law in LAWS),
    Sampled(LAWS[0], 0.2, 0.1, NoisySensors(1e-3, 2e-3, 1e-4, 1e-3, 3.0), name="noisy"),
)
