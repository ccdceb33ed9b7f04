"""How angular momenta become angular velocities, in rational arithmetic and over long motions."""

from fractions import Fraction

import numpy as np

import poinsot as pt
from poinsot.functions import Vector
from poinsot.mechanics.body import ObliqueBody
from poinsot.mechanics.kinetics import ObliqueKinetics

INERTIA = np.array([[1.25, 0.12, -0.07], [0.12, 1.0, 0.21], [-0.07, 0.21, 0.75]])


def exactly(array):
    """Return numbers of double precision as fractions, row by row."""
    return [exactly(row) for row in array] if np.ndim(array) else Fraction(float(array))


def test_rounded_axes_change_neither_momentum_nor_energy():
    body = pt.Body.from_inertia(INERTIA)
    assert isinstance(body, ObliqueBody)
    axes = body.axes
    assert np.any(axes.T @ axes != np.eye(3))  # rounded, or the test shows nothing
    kinetics = ObliqueKinetics.unchecked(**vars(pt.Body(body.moments).kinetics()), axes=axes)
    rounded = ObliqueKinetics.unchecked(
        reciprocals=exactly(kinetics.reciprocals), twists=exactly(kinetics.twists), axes=exactly(axes)
    )
    g = Vector(exactly((0.3, -1.1, 0.7)))
    omega, gyration = rounded.omega(g), rounded.gyration(g)
    assert sum(x * y for x, y in zip(g, gyration, strict=True)) == 0
    assert sum(x * y for x, y in zip(omega, gyration, strict=True)) == 0


def test_inverse_inertia_of_oblique_axes_is_symmetric_to_the_last_bit():
    columns = np.array([pt.Body.from_inertia(INERTIA * size).omega(np.eye(3)) for size in (1.0, 0.37, 2.9)])
    assert np.array_equal(columns, columns.swapaxes(-1, -2))


def test_long_motions_keep_energy_and_momentum_of_an_oblique_body():
    """Beside an attractor at rest; rounded results have the rounding of one state (3 units of it, times 3)."""
    body = pt.Body.from_inertia(INERTIA)
    place = pt.orbits.FixedPosition(1.0, position=(1.2, 0.5, -0.7))
    system = pt.System(body, pt.GravityGradient(place))
    start = body.state((0.5, 0.5, -0.5, 0.5), omega_body=(1.4, 1.5, 2.2))
    motion = pt.propagate(system, start, [0.0, 1000.0, 2000.0, 3000.0], precision="quadruple")
    unit = np.spacing(1.0)
    assert np.max(np.abs(motion.energy - motion.energy[0])) < 10 * unit * motion.energy[0]
    axis = place.position / np.linalg.norm(place.position)
    momenta = motion.angular_momentum_space @ axis
    assert np.max(np.abs(momenta - momenta[0])) < 10 * unit * np.linalg.norm(motion.angular_momentum_space[0])
