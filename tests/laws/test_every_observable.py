"""Laws of every instrument of the package; a new one joins by one instance in `kinds/observables.py`."""

import pickle

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from kinds.observables import BODY, OBSERVABLES, START, SYSTEM, TIMES
from poinsot.analysis.reading_partials import observed_partials
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment
from poinsot.scenarios.system_text import rebuilt_observables, text_of_observables
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
each_observable = pytest.mark.parametrize("observable", OBSERVABLES.values(), ids=OBSERVABLES)


@pytest.fixture(scope="module")
def motion():
    return pt.propagate(SYSTEM, START, np.concatenate([-TIMES[:0:-1], TIMES]), dense=True)


def test_every_observable_of_the_package_is_here():
    instruments = {each for each in concrete_subclasses(pt.Observable) if ".observables." in each.__module__}
    assert instruments == {type(each) for each in OBSERVABLES.values()}


@each_observable
def test_readings_are_finite_and_vary(observable, motion):
    found = pt.observe(motion, observable)
    assert found.values.shape == (7, *([len(observable.components)] if observable.components else []))
    assert np.all(np.isfinite(found.values))
    assert np.all(np.ptp(found.values, axis=0) > 0) or isinstance(observable, pt.observables.CoarseSunSensors)
    assert "units" in found.attributes or isinstance(observable, pt.observables.CoarseSunSensors)


@each_observable
def test_readings_of_one_time_are_those_of_many(observable, motion):
    together = pt.observe(motion, observable).values
    scale = np.max(np.abs(together))
    for i in range(3):
        alone = pt.observe(motion.isel(time=[i]), observable, times=motion.times[i : i + 1]).values[0]
        assert np.allclose(alone, together[i], rtol=0, atol=8 * EPS * scale)


@each_observable
def test_the_secondary_of_two_bodies_reads_as_a_single_body(observable, motion):
    """The second body has the mass of the pair but for a trifle, and is at its centre of mass."""
    light = pt.Body((1e-12, 1e-12, 1e-12), mass=1e-20)
    heavy = pt.Body((1.25, 1.0, 0.75), mass=1.0)
    pair = pt.TwoBodies(light, heavy, G=1e-20)
    start = pair.state(
        (1.0, 0, 0), (0, 0, 0), [(1, 0, 0, 0), START.quaternion], omega_body=[(0, 0, 0), (0.2, 1.1, -0.4)]
    )
    system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "length": "km", "inertia": "kg km2"})
    both = pt.propagate(system, start, [0.0, 0.1])
    found = pt.observe(both, observable.on("secondary"), times=[0.0]).values
    alone = pt.observe(motion, observable, times=[0.0]).values
    assert np.allclose(found, alone, rtol=1e-13, atol=1e-13 * np.max(np.abs(alone)))


@each_observable
def test_members_have_numbers_of_their_own(observable, motion):
    fields = {name: getattr(observable, name) for name in observable.definition[1]}
    both = type(observable)(**fields | {"noise": np.stack([x := np.asarray(observable.noise), 2 * x])})
    found = pt.observe(motion, both)
    assert found.values.shape[0] == 2
    assert np.array_equal(found.values[0], found.values[1])
    assert np.allclose(found.values[0], pt.observe(motion, observable).values, rtol=4 * EPS, atol=1e-15)
    if np.any(observable.noise):
        errors = observable.difference(found.simulated(1).values, found.values)
        assert errors.shape == (2, 7, *([len(observable.errors)] if observable.errors else []))


@each_observable
def test_members_of_a_motion_are_read_together(observable):
    omegas = [(0.2, 1.1, -0.4), (-0.3, 0.5, 0.9)]
    motion = pt.propagate(SYSTEM, BODY.state(START.quaternion, omega_body=omegas), TIMES)
    both = pt.observe(motion, observable).values
    for i in range(2):
        alone = pt.observe(motion.isel(member=i), observable).values
        assert np.allclose(both[i], alone, rtol=0, atol=8 * EPS * np.max(np.abs(alone)))


@each_observable
def test_observables_travel(observable, motion):
    back = pickle.loads(pickle.dumps(observable))
    assert np.array_equal(pt.observe(motion, back).values, pt.observe(motion, observable).values)


@each_observable
def test_a_text_describes_an_observable(observable, motion):
    text = text_of_observables({"it": observable}, None)
    (again,) = rebuilt_observables(text.text, "it.toml", data=text.data)
    assert np.array_equal(pt.observe(motion, again).values, pt.observe(motion, observable).values)


def changed_start(coordinate, step):
    """Return the initial state with a change of one coordinate: a turn about a body axis, or a momentum along it."""
    change = np.zeros(6)
    change[coordinate] = step
    attitude = START.attitude * Rotation.from_rotvec(change[:3])
    return BODY.state(attitude, angular_momentum_body=START.angular_momentum_body + change[3:])


@each_observable
def test_partials_are_the_slopes_of_readings(observable):
    """By the initial attitude and momentum: central differences of readings of other states."""
    found = observed_partials(SYSTEM, START, observable, TIMES)
    h = 1e-4
    for k in range(6):
        ahead, behind, far_ahead, far_behind = (
            pt.observe(pt.propagate(SYSTEM, changed_start(k, step), TIMES, dense=True), observable).values
            for step in (h, -h, 2 * h, -2 * h)
        )
        slope = (8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * h)
        # The error h^4/30 of the fifth derivative, and roundings of the readings over h.
        bound = 3e-10 * np.max(np.abs(found.by_start)) + 8 * EPS * np.max(np.abs(found.values)) / h
        assert np.allclose(found.by_start[..., k], slope, rtol=0, atol=bound)


def read(observable, numbers):
    """Return the components of a reading for all numbers: of the observable, quaternion, time, angular velocity."""
    own = len(numbers) - 8
    q, time, omega = numbers[own : own + 4], numbers[own + 4], numbers[own + 5 :]
    instant = pt.Instant(BODY, pt.Attitude.from_quaternion(Vector(q)), Environment(time), Vector(omega))
    reading = observable.with_numbers(numbers[:own]).reading(instant)
    return list(reading) if observable.components else [reading]


@pytest.mark.parametrize("name", [name for name in OBSERVABLES if name != "light curve of a mesh"])  # a closed rule
def test_derivatives_by_every_number_agree_with_digits(name):
    """Central differences of the formula with 40 digits; each number of a reading on the nodes of a graph."""
    observable, graph = OBSERVABLES[name], Graph()
    numbers = [*map(float, observable.numbers), *START.quaternion, 0.7, 0.2, 1.1, -0.4]
    nodes = [graph.variable(x) for x in numbers]
    outputs = read(observable, nodes)
    values = np.array(graph.evaluated(outputs), dtype=float)
    for i, x in enumerate(numbers):
        found = np.array(graph.evaluated(tangents(outputs, {nodes[i]: 1.0})), dtype=float)
        with mpmath.workdps(40):
            exact = [mpmath.mpf(number) for number in numbers]
            size = abs(x) or 1.0
            h = size * mpmath.mpf(10) ** -15
            low, high = (read(observable, [*exact[:i], exact[i] + s * h, *exact[i + 1 :]]) for s in (-1, 1))
            slope = np.array([float((b - a) / (2 * h)) for a, b in zip(low, high, strict=True)])
        # Three times the largest error, of an ellipsoid's light; numbers that cancel leave roundings of the reading.
        bound = 6e-13 * np.max(np.abs(slope)) + 32 * EPS * np.max(np.abs(values)) / size
        assert np.allclose(found, slope, rtol=0, atol=bound), (name, i)
