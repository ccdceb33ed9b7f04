"""Energies, torques and rates of a system on scalars of any kind, for tests on symbols and long numbers."""

import poinsot as pt
from poinsot.functions import Vector


def instant(system, q, time=0, omega=None):
    """Return the instant of a quaternion of four scalars."""
    return pt.Instant(system.body, pt.Attitude.from_quaternion(Vector(q)), pt.Environment(time), omega)


def potential(system, q, time=0):
    """Return the potential energy at a quaternion of four scalars."""
    return system.potential_at(instant(system, q, time))


def torque(system, q, omega, time=0):
    """Return the torque along the body axes at a quaternion and a rate."""
    return system.torque_at(instant(system, q, time, omega))
