"""Every gravity between two bodies that is shipped."""

import poinsot as pt
from poinsot.forces import MutualGravity, MutualHarmonics, MutualMascons

SHAPES = (
    pt.shapes.Mascons([1.0, 2.0, 1.5, 0.5], [(1, 0.1, 0), (-0.7, 0.3, 0.1), (0.1, -0.4, 0.3), (0.3, 0.3, -0.8)]),
    pt.shapes.Mascons([0.3, 0.2, 0.4], [(0.5, 0, 0.2), (-0.3, 0.4, 0), (0, -0.3, -0.1)]),
)
PAIR = pt.TwoBodies(*map(pt.Body.from_shape, SHAPES), G=1.3)
FORCES = (MutualGravity(), MutualHarmonics.of_shapes(PAIR, 5), MutualMascons.of_shapes(PAIR))
