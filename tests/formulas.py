"""Energies, torques and rates of a system on scalars of any kind, for tests on symbols and long numbers."""

import sympy as sp

import poinsot as pt
from poinsot.functions import Vector
from poinsot.integration.formulations import FORMULATIONS
from poinsot.systems.dynamics import Turning


def copied(system, numbers):
    """Return the system on other scalars: symbols, or long numbers."""
    return pt.System._of(system.dynamics.with_numbers(numbers), system.units)


def instant(system, q, time=0, omega=None):
    """Return the instant of a quaternion of four scalars."""
    return pt.Instant(system.body, pt.Attitude.from_quaternion(Vector(q)), pt.mechanics.Environment(time), omega)


def potential(system, q, time=0):
    """Return the potential energy at a quaternion of four scalars."""
    return system.dynamics.potential_at(instant(system, q, time))


def torque(system, q, omega, time=0):
    """Return the torque along the body axes at a quaternion and a rate."""
    return system.dynamics.torque_at(instant(system, q, time, omega))


def rates(system, formulation, variables, time=0):
    """Return the time derivatives of the variables of a formulation."""
    chart = FORMULATIONS[formulation]
    attitude, g = chart.physical(variables)
    here = pt.Instant(system.body, attitude, pt.mechanics.Environment(time), angular_momentum_body=g)
    load = system.dynamics.torque_at(here)
    return chart.rates(variables, here.omega_body, Turning.of(here, load).momentum_rate, load)


def rational(expression):
    """Return a SymPy expression with the decimal fractions that its floats were written as."""
    exact = sp.sympify(expression)
    return exact.xreplace({number: sp.Rational(str(number)) for number in exact.atoms(sp.Float)})
