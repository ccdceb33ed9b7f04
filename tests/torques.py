"""Torques of a system in double-double arithmetic and on symbols, and the code that is compiled for them."""

import itertools

import numpy as np
import sympy

import formulas
import poinsot as pt
from poinsot.functions import Vector
from poinsot.integration import equations
from poinsot.integration.kernel_parameters import PreparedKernel
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph


def compiled_torque(system):
    """Return the torque as compiled in double-double arithmetic, a function of attitude, angular velocity and time."""
    graph = Graph()
    symbols = [graph.symbol(place) for place in range(8)]
    symbolic = formulas.copied(system, map(graph.input, itertools.count()))
    torque = formulas.torque(symbolic, symbols[:4], symbols[4:7], symbols[7])
    compiled = WideEvaluator([*torque], symbols)
    return lambda q, omega, time: np.array(compiled([*q, *omega, time, *system.dynamics.numbers])[:3])


def sympy_numbers(system, q, omega, time):
    q, omega = (Vector(sympy.Float(float(x), 17) for x in vector) for vector in (q, omega))
    return list(formulas.torque(system, q, omega, time))


def turned_orbit(orbit, turn):
    if isinstance(orbit, pt.orbits.FixedPosition):
        return pt.orbits.FixedPosition(orbit.mu, position=turn.apply(np.array(orbit.position)))
    r, v = (turn.apply(np.array(x)) for x in (orbit.position_at(orbit.epoch), orbit.velocity_at(orbit.epoch)))
    return pt.KeplerOrbit.from_vectors(orbit.mu, position=r, velocity=v, epoch=orbit.epoch)


def compiled():
    """Return all equations."""
    return [known.code for known in equations.known._stored.values() if isinstance(known, PreparedKernel)]
