"""Integrals of the motion of two bodies."""

import numpy as np
import pytest

import poinsot as pt

fn = pt.functions
BODY = pt.Body((2.0, 2.5, 3.0), mass=1.0)
PAIR = pt.TwoBodies(BODY, BODY, G=1.0)
NOTHING = fn.Vector((0.0, 0.0, 0.0))


class Drag(pt.mechanics.PairLoad):
    """Along the line of centres, where it is shorter than a reach or after a time."""

    reach: float
    time: float

    def load(self, instant):
        off = -fn.dot(instant.separation, instant.relative_velocity)
        near = fn.where(fn.less(instant.distance, self.reach), off, 0.0)
        late = fn.where(fn.less(self.time, instant.time), off, 0.0)
        return pt.mechanics.Load((near + late) * instant.separation, (NOTHING, NOTHING))


class Wall(pt.Potential):
    """Along the first axis, beyond a distance."""

    reach: float

    def energy(self, instant):
        beyond = instant.distance - self.reach
        return fn.where(fn.less(0.0, beyond), beyond * beyond * instant.separation[0], 0.0)


class Switch(pt.Potential):
    """Gravity that is another one after a time: no formula has a derivative by time."""

    def energy(self, instant):
        return fn.where(fn.less(3.0, instant.time), 0.1, 0.0) / instant.distance


class Swing(pt.Potential):
    amplitude: float

    def energy(self, instant):
        return self.amplitude * fn.sin(instant.time) * instant.separation[2]


class Gyroscope(pt.mechanics.PairLoad):
    """A force that has no power."""

    field: pt.SpaceVector

    def load(self, instant):
        return pt.mechanics.Load(fn.cross(self.field, instant.relative_velocity), (NOTHING, NOTHING))


@pytest.mark.parametrize(
    ("force", "symbols"),
    [
        (Drag(reach=0.1, time=1e9), ["G1", "G2", "G3"]),
        (Wall(reach=1e5), ["H", "G1"]),
        (Switch(), ["G1", "G2", "G3"]),
        (Swing(amplitude=1e-11), ["G3"]),
        (Swing(amplitude=np.array([0.0, 1e-11])), ["G3"]),
        (Gyroscope((0, 0, 0.1)), ["H"]),
        (pt.forces.LibrationDamping("secondary", coefficient=1e-13), ["G1", "G2", "G3"]),
        (pt.forces.MutualGravity(), ["H", "G1", "G2", "G3"]),
    ],
)
def test_what_is_conserved(force, symbols):
    system = pt.System(PAIR, *{pt.forces.MutualGravity(), force})
    assert [integral.symbol for integral in system.integrals] == symbols
