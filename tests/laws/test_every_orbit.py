"""Laws of every shipped orbit; a new one joins by one instance in `kinds/orbits.py`."""

import dataclasses

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

import poinsot as pt
from kinds import concrete_subclasses
from kinds.orbits import ORBITS, along
from poinsot.orbits.ephemeris import PolynomialArc
from poinsot.orbits.restricted_three_body import ThreeBodyView
from poinsot.propagation.scenario_of_motion import scenario_of
from poinsot.scenarios.system_text import rebuilt_system

EPS = np.finfo(float).eps


TIMES = np.array([-0.4, 0.0, 0.2, 0.9, 1.7, 2.4])
BODY = pt.Body((1.3e3, 1.0e3, 0.7e3))
"""So large that the orbit is all that counts."""
START = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0, 0, 0), time=-0.4)

each_orbit = pytest.mark.parametrize("orbit", ORBITS.values(), ids=ORBITS)


def stacked(vector, times):
    """The components of a vector last, at all times."""
    return np.stack([np.broadcast_to(np.asarray(x, dtype=float), np.shape(times)) for x in vector], axis=-1)


def test_every_orbit_of_the_package_is_here():
    assert concrete_subclasses(pt.Orbit) == {type(orbit) for orbit in ORBITS.values()}


# ---------------------------------------------------------------------- formulas


def integral(function, start, stop):
    """The integral of a vector by Gauss's rule of 20 points in 12 pieces: to rounding for each of these orbits."""
    nodes, weights = leggauss(20)
    half = (stop - start) / 24
    middles = start + half * (2 * np.arange(12) + 1)
    times = (middles[:, None] + half * nodes).ravel()
    return half * np.tile(weights, 12) @ function(times)


@each_orbit
def test_velocity_is_the_derivative_of_the_position(orbit):
    place = stacked(orbit.position_at(TIMES), TIMES)
    for i in range(len(TIMES) - 1):
        way = integral(lambda times: stacked(orbit.velocity_at(times), times), *TIMES[i : i + 2])
        assert np.max(np.abs(place[i + 1] - place[i] - way)) < 1e-13
    assert np.max(np.abs(place[1] - place[0])) > 0.1 or isinstance(orbit, pt.orbits.FixedPosition)


@each_orbit
def test_inverse_distance_is_one_over_the_length_of_the_position(orbit):
    length = np.linalg.norm(stacked(orbit.position_at(TIMES), TIMES), axis=-1)
    assert np.max(np.abs(orbit.inverse_distance_at(TIMES) * length - 1)) < 1e-14


@each_orbit
def test_one_time_gives_what_many_give(orbit):
    r, v = stacked(orbit.position_at(TIMES), TIMES), stacked(orbit.velocity_at(TIMES), TIMES)
    for i, time in enumerate(TIMES):
        assert np.max(np.abs(stacked(orbit.position_at(time), 0.0) - r[i])) <= 8 * EPS * np.max(np.abs(r))
        assert np.max(np.abs(stacked(orbit.velocity_at(time), 0.0) - v[i])) <= 32 * EPS * np.max(np.abs(v))


# ---------------------------------------------------------------------- the frame


@each_orbit
def test_frame_turns_at_its_angular_velocity_and_leads_with_the_position(orbit):
    if isinstance(orbit, pt.orbits.FixedPosition):
        with pytest.raises(ValueError, match=r"^orbit must move to have a frame, "):
            _ = orbit.frame
        return
    frame, h = orbit.frame, 1e-4
    turn = (frame.attitude(TIMES + h) * frame.attitude(TIMES - h).inv()).as_rotvec() / (2 * h)
    assert np.max(np.abs(turn - frame.omega_space(TIMES))) < 1e-6
    radial = frame.attitude(TIMES).inv().apply(stacked(orbit.position_at(TIMES), TIMES))
    if isinstance(orbit, pt.orbits.RotatingPosition | ThreeBodyView):
        return  # axes that follow the attractors, not the body
    distance = 1 / np.asarray(orbit.inverse_distance_at(TIMES))
    assert np.max(np.abs(radial - np.multiply.outer(distance, (1, 0, 0)))) < 1e-13
    ahead = frame.attitude(TIMES).inv().apply(stacked(orbit.velocity_at(TIMES), TIMES))
    assert np.all(ahead[:, 1] > 0)


# ---------------------------------------------------------------------- numbers


@each_orbit
def test_numbers_make_the_round_trip(orbit):
    numbers = [float(x) for x in orbit.numbers]
    copied = orbit.with_numbers(iter(numbers))
    assert type(copied) is type(orbit)
    left = iter([*numbers, 0.25])
    assert float((orbit.with_numbers(left)).mu) == float(orbit.mu)
    assert list(left) == [0.25], "each number is taken once"
    if orbit.closed_form and not isinstance(orbit, pt.orbits.Ephemeris):  # whose table is no number
        assert np.max(np.abs(stacked(copied.position_at(0.9), 0.0) - stacked(orbit.position_at(0.9), 0.0))) < 4e-15
        other = orbit.with_numbers(1.01 * x for x in numbers)
        assert np.max(np.abs(stacked(other.position_at(0.9), 0.0) - stacked(orbit.position_at(0.9), 0.0))) > 1e-3


def test_structure_tells_kinds_apart():
    kinds = {type(orbit): orbit.structure for orbit in ORBITS.values()}
    assert len(set(kinds.values())) == len(kinds)


def with_one_member_more(record):
    """The record with two members, the second of which has other numbers, and these two alone."""
    own = {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}
    parts = {name: with_one_member_more(value) for name, value in own.items() if dataclasses.is_dataclass(value)}
    other = {name: 1.03 * value for name, value in own.items() if isinstance(value, np.ndarray)}
    both = {name: np.stack([own[name], value]) for name, value in other.items()}
    return tuple(
        dataclasses.replace(record, **numbers, **{name: parts[name][i] for name in parts})
        for i, numbers in enumerate((both, {}, other))
    )


@each_orbit
def test_members_have_orbits_of_their_own(orbit):
    if isinstance(orbit, PolynomialArc):  # only through its table
        return
    if isinstance(orbit, pt.orbits.Ephemeris):  # its table is one for all
        both = pt.orbits.Ephemeris.from_function([2.0, 2.1], position=along, start=-1.0, stop=3.0)
        alone = [pt.orbits.Ephemeris.from_function(mu, position=along, start=-1.0, stop=3.0) for mu in (2.0, 2.1)]
    else:
        both, *alone = with_one_member_more(orbit)
    for i, one in enumerate(alone):
        assert np.asarray(both.mu)[i] == one.mu
        for time in (-0.4, 0.9):
            together = np.stack(np.broadcast_arrays(*both.position_at(time), np.zeros(2))[:3], axis=-1)[i]
            expected = stacked(one.position_at(time), 0.0)
            assert np.max(np.abs(together - expected)) < 1e-13 * (1 + np.max(np.abs(expected)))


# ---------------------------------------------------------------------- where it is known


@each_orbit
def test_a_span_ends_where_a_run_must(orbit):
    first, last = orbit.span
    assert first < last
    if np.isfinite(last):
        assert np.all(np.isfinite(stacked(orbit.position_at(np.array([first, last])), [0, 0])))
        with pytest.raises(ValueError, match=r"^times must lie within the span of orbits, fields and tables, "):
            pt.propagate(pt.System(BODY, pt.GravityGradient(orbit)), START, [-0.4, last + 0.1])


# ---------------------------------------------------------------------- in a kernel


class Along(pt.Torque):
    """A torque whose components in space are those of position, velocity and direction."""

    orbit: pt.Orbit

    def torque(self, instant):
        place, change, way = instant.position(self.orbit), instant.velocity(self.orbit), instant.direction(self.orbit)
        return instant.attitude.to_body([a + 2 * b + 3 * c for a, b, c in zip(place, change, way, strict=True)])


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@each_orbit
def test_a_kernel_has_the_position_of_the_formulas(orbit, formulation):
    check_kernel(orbit, pt.System(BODY, Along(orbit)), formulation)


@pytest.mark.parametrize("orbit", [pytest.param(o, id=name) for name, o in ORBITS.items() if o.integrated])
def test_a_kernel_has_it_together_with_the_variables_of_a_part(orbit):
    wheel = pt.parts.ReactionWheel((0.6, 0, 0.8), 2.0, 0.3, 0.1)
    motion = check_kernel(orbit, pt.System(BODY, Along(orbit), wheel))
    assert np.ptp(motion.own["reaction_wheel"]) > 1e-2


def check_kernel(orbit, system, formulation=None):
    """The angular momentum in space grows by the integral of the torque, whatever moves inside.

    Gauss's rule gives the integral without the kernel.
    """
    if isinstance(orbit, PolynomialArc):  # a kernel has it through its table
        return None
    start = system.state(START.quaternion, omega_body=(0, 0, 0), time=-0.4)
    motion = pt.propagate(system, start, [-0.4, 1.7], formulation=formulation)

    def torque(times):
        r, v = stacked(orbit.position_at(times), times), stacked(orbit.velocity_at(times), times)
        return r + 2 * v + 3 * r / np.linalg.norm(r, axis=-1, keepdims=True)

    expected = integral(torque, -0.4, 1.7)
    found = motion.angular_momentum_space[-1] - motion.angular_momentum_space[0]
    assert np.max(np.abs(found - expected)) < 1e-12
    place = np.stack(np.broadcast_arrays(*motion.environment.position(orbit), motion.times)[:3], axis=-1)
    assert np.max(np.abs(place - stacked(orbit.position_at(motion.times), motion.times))) < 1e-13
    return motion


@each_orbit
def test_a_block_has_the_position_and_the_rates_of_the_formulas(orbit):
    if (block := orbit.block) is None:
        return
    own = block.start_at(TIMES)
    here = pt.mechanics.Environment(TIMES, [(block, np.moveaxis(own, -1, 0))])
    place, change = stacked(orbit.position_at(TIMES), TIMES), stacked(orbit.velocity_at(TIMES), TIMES)
    # A rounding of an angle is one of the place times the distance, times 1/(1 - e) or q/r where the body is fast.
    assert np.max(np.abs(stacked(here.position(orbit), TIMES) - place)) < 64 * EPS * np.max(np.abs(place))
    assert np.max(np.abs(stacked(here.velocity(orbit), TIMES) - change)) < 64 * EPS * np.max(np.abs(change))
    system, h = pt.System(BODY, Along(orbit)), 1e-3
    state = pt.State(np.broadcast_to(START.quaternion, (len(TIMES), 4)), np.zeros((len(TIMES), 4)), TIMES)
    rates = stacked(system.rates(system.at(state, here))["orbits[0]"], TIMES)
    ahead, twice = (block.start_at(TIMES + k * h) - block.start_at(TIMES - k * h) for k in (1, 2))
    differences = (8 * ahead - twice) / (12 * h)  # off by h^4/30 times the fifth derivative
    assert np.max(np.abs(rates - differences)) < 1e-9 * max(1.0, float(np.max(np.abs(rates))))


# ---------------------------------------------------------------------- in a scenario


@each_orbit
def test_the_text_of_a_system_makes_the_orbit_again(orbit):
    if isinstance(orbit, PolynomialArc | pt.orbits.Ephemeris):  # stored with the text
        return
    motion = pt.propagate(pt.System(BODY, pt.GravityGradient(orbit)), START, [-0.4])
    again = rebuilt_system(scenario_of(motion.system, motion.run).text, "it")
    assert [float(x).hex() for x in again.dynamics.numbers] == [float(x).hex() for x in motion.system.dynamics.numbers]
    assert again.dynamics.structure == motion.system.dynamics.structure


@pytest.mark.parametrize("time", [np.nan, np.inf, np.float64("nan"), np.array([0.5, np.nan]), "2026-11-21"])
@pytest.mark.parametrize("formula", ["position_at", "velocity_at", "inverse_distance_at"])
@each_orbit
def test_times_must_be_finite_numbers(orbit, formula, time):
    with pytest.raises((ValueError, TypeError), match=r"^time must be (finite, got time|real numbers, got str)"):
        getattr(orbit, formula)(time)
