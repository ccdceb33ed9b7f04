"""Low parts of the state at the start of a run in quadruple precision, and its unit of time."""

from __future__ import annotations

import functools
import itertools

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.double_double import DoubleDouble
from poinsot.functions import Vector
from poinsot.integration.formulations import Formulation
from poinsot.integration.state_vector import StateVector
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.state import AnyState, State
from poinsot.taylor.evaluation import WideEvaluator
from poinsot.taylor.graph import Graph, tangents

__all__ = ["low_parts", "unit_of_time"]


def unit_of_time(speeds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return powers of two near the periods of rotation; 1 for bodies at rest. Later steps choose other units."""
    turning = np.isfinite(speeds) & (speeds > 0)
    return np.asarray(np.exp2(-np.clip(np.rint(np.log2(np.where(turning, speeds, 1.0))), -500, 500)))


def low_parts(variables: StateVector, state: AnyState, starts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the low parts of the variables at the start, given the high parts; shape (members, size).

    The variables of a chart are rounded functions of attitude and momentum, and the norm of a quaternion of doubles is
    1 to rounding only. One step of Newton on the formulas of the chart, in double-double arithmetic, gives the low
    parts. The attitude has the direction of the quaternion, and the angular momentum equals the momentum of the state.
    Variables of parts are the numbers of the state.
    """
    below = np.zeros_like(starts)
    bodies = zip(variables.charts, state.of_bodies.values(), variables.scales(variables.scale), strict=True)
    for place, body, scale in bodies:
        units = np.ones((len(starts), variables.formulation.size))
        units[:, variables.formulation.momenta] = np.reshape(np.asarray(scale), (-1, 1))
        rows = (starts[:, place] / units).T
        below[:, place] = units * _chart_below(variables.formulation, rows, body).T
    if variables.orbits:
        lows = [block.start_in_two_parts(state.time)[1] for block in variables.orbits]
        below[:, variables.along_orbits] = np.concatenate(lows, axis=-1)
    return below


def _chart_below(formulation: Formulation, rows: NDArray[np.float64], body: State) -> NDArray[np.float64]:
    """Return the low parts of variables of a chart, shape (size, members); members are independent."""
    q, g = np.reshape(body.quaternion, (-1, 4)).T, np.reshape(body.angular_momentum_body, (-1, 3)).T
    square = functools.reduce(DoubleDouble.__add__, (DoubleDouble.product(x, x) for x in q))
    lengthening = (0.5 * (1.0 - square)).hi
    replay, places, count = _chart(formulation)
    found = np.array(np.broadcast_arrays(*replay([*rows, *q, *g, lengthening])), dtype=float)
    middle = len(found) // 2
    errors = found[:count] + found[middle : middle + count]
    slopes = found[count:middle].reshape(len(places), count, -1)
    inverse = np.linalg.pinv(np.moveaxis(slopes, -1, 0).swapaxes(1, 2))
    below = np.zeros((len(rows), errors.shape[-1]))
    below[places] = functools.reduce(np.subtract, (inverse[:, :, k].T * errors[k] for k in range(count)), np.zeros(1))
    for place in formulation.quaternions[:1]:
        below[place] = q * lengthening
    return below


@functools.cache
def _chart(formulation: Formulation) -> tuple[WideEvaluator, list[int], int]:
    """Return the errors of a chart's variables with their derivatives, the places of these variables, and the count.

    A quaternion of the attitude is only lengthened, so that its direction has no error. Errors are those of the angular
    momentum, and of the rotation matrix in charts without a quaternion.
    """
    graph, size = Graph(), formulation.size
    own = [graph.symbol(place) for place in range(size + 8)]
    q, g, lengthening = Vector(own[size : size + 4]), own[size + 4 : size + 7], own[size + 7]
    known = [*range(size)[formulation.quaternions[0]]] if formulation.quaternions else []
    attitude, momentum = formulation.physical(
        [x * (1.0 + lengthening) if i in known else x for i, x in enumerate(own[:size])]
    )
    pairs = [*zip(momentum, g, strict=True)]
    if not known:
        expected, square = Attitude.from_quaternion(q), functions.dot(q, q)
        entries = zip(itertools.chain(*attitude.matrix), itertools.chain(*expected.matrix), strict=True)
        pairs += [(a, b / square) for a, b in entries]
    errors, places = [a - b for a, b in pairs], [place for place in range(size) if place not in known]
    slopes = [slope for place in places for slope in tangents(errors, {own[place]: 1.0})]
    return WideEvaluator([*errors, *slopes], own), places, len(errors)
