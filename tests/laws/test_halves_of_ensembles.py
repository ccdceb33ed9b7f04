"""Members do not depend on who else is in their ensemble: two halves computed alone are the whole, bit for bit."""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.control import NoisySensors, RateDamping, Sampled
from poinsot.records.members import members_of

COUNT = 14
HALVES = (np.arange(5), np.arange(5, COUNT))
RNG = np.random.default_rng(19)
BODY = pt.Body((1.0, 1.3, 1.7))
ATTITUDES = RNG.normal(size=(COUNT, 4))
ATTITUDES /= np.linalg.norm(ATTITUDES, axis=1)[:, None]
RATES = RNG.normal(0, 0.6, (COUNT, 3)) * np.geomspace(0.1, 30, COUNT)[:, None]
STARTS = RNG.uniform(-1.0, 0.0, COUNT)
TIMES = np.linspace(0.0, 3.0, 7)
FIRST_ALONE = np.where(np.arange(COUNT) < 5, 0.0, 0.3)
"""Zero in the whole first half."""
SIZES = np.geomspace(0.05, 40.0, COUNT)


def ellipse(**others):
    given = {"semimajor_axis": np.linspace(0.8, 4.0, COUNT), "eccentricity": FIRST_ALONE, "inclination": 0.3}
    return pt.KeplerOrbit(1.0, **given, **others)


def pair():
    bodies = pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=np.linspace(0.3, 0.8, COUNT))
    both = pt.TwoBodies(*bodies, G=1.0)
    places = np.linspace(4.0, 9.0, COUNT)[:, None] * (1.0, 0.2, 0.1)
    rates = [RATES * 0.05, RATES[::-1] * 0.1]
    system = pt.System(both, pt.forces.MutualGravity())
    return system, both.state(places, (-0.1, 0.4, 0.2), [ATTITUDES, ATTITUDES[::-1]], omega_body=rates)


ESCAPING = pt.orbits.EscapeOrbit(
    1.0,
    periapsis_distance=np.linspace(0.9, 3.0, COUNT),
    eccentricity=1.4,
    time_since_periapsis=np.linspace(-9, 4, COUNT),
)


class Shadowed(pt.Torque):
    """A torque on one side of an orbit, near the attractor."""

    orbit: pt.Orbit
    size: float

    def torque(self, instant):
        x, _, _ = instant.position(self.orbit)
        lit = fn.where(fn.less(x, 0.3), self.size, 0.0)
        return lit * fn.Vector((0.5, -1.0, 0.8)) / fn.norm(instant.position(self.orbit)) ** 3


FORCES = {
    "none": [],
    "one force": [pt.UniformGravity(np.linspace(0.1, 9.0, COUNT), (0.3, 0.0, 1.0))],
    "zeros in one half": [pt.UniformGravity(0.7, np.stack([FIRST_ALONE, FIRST_ALONE, SIZES], axis=-1))],
    "orbits": [pt.GravityGradient(ellipse())],
    "orbits in space axes": [pt.GravityGradient(ellipse()), pt.UniformGravity(0.7, (0.1, 0.2, 0.3))],
    "flybys": [pt.GravityGradient(ESCAPING)],
    "shadow": [Shadowed(ellipse(), np.linspace(0.1, 2.0, COUNT))],
    "damper": [pt.parts.KaneDamper(0.4, 0.1)],
    "mass on a spring": [pt.parts.SpringMass(1, 10, (0.3, 0.2, 1), (0.6, 0, 0.8), np.linspace(2, 90, COUNT), 0.3)],
    "noise": [Sampled(RateDamping(0.2, 0.4), 0.2, 0.1, NoisySensors(1e-3, 2e-3, 1e-4, seed=3.0), name="noisy")],
}
EVENTS = [pt.events.RateCrossing((0.2, 1.0, 0.1)), pt.events.AxisCrossing((1, 0, 0), (0, 0, 1), angle=1.2)]


def case(name, moments=BODY.moments):
    if name == "pair":
        return pair()
    system = pt.System(pt.Body(moments), *FORCES[name])
    starts = np.zeros(COUNT) if name == "noise" else STARTS
    return system, system.state(ATTITUDES, omega_body=RATES, time=starts)


def bits(value):
    return np.ascontiguousarray(value).view(np.uint8).reshape(len(value), -1)


def differing(compute, system, state):
    """Which variables of which members of the halves are not those of the whole."""
    whole, wrong = compute(system, state), {}
    for half in HALVES:
        part = compute(members_of(system, half), members_of(state, half))
        for name, rows in whole.items():
            alike = np.all(bits(rows[half]) == bits(part[name]), axis=1)
            wrong |= {name: half[~alike].tolist()} if not alike.all() else {}
    return wrong


def motion_of(motion):
    rows = dict(motion.phase)
    for i, found in enumerate(motion.events):
        last = [found.member(k).times[-1:] for k in range(len(motion))]
        rows[f"event {i}"] = np.array([np.append(x, np.nan)[0] for x in last])
        rows[f"count {i}"] = np.array([len(found.member(k)) for k in range(len(motion))])
    return rows


def propagated(**options):
    return lambda system, state: motion_of(pt.propagate(system, state, TIMES, **options))


@pytest.mark.parametrize("name", [*FORCES, "pair"])
def test_motions(name):
    assert differing(propagated(), *case(name)) == {}


@pytest.mark.parametrize("name", ["one force", "zeros in one half", "orbits"])
def test_events(name):
    assert differing(propagated(events=EVENTS), *case(name)) == {}


@pytest.mark.parametrize("name", FORCES)
def test_an_event_that_no_member_meets(name):
    system, state = case(name)
    (found,) = pt.propagate(system, state, TIMES, events=[pt.events.RateCrossing((0, 0, 1), rate=1e9)]).events
    assert len(found) == len(found.member(3)) == 0
    assert found.states.quaternion.shape == (0, 4)


@pytest.mark.parametrize("formulation", ["canonical", "euler_angles"])
def test_other_variables(formulation):
    assert differing(propagated(formulation=formulation), *case("one force")) == {}


@pytest.mark.parametrize(
    "moments", [BODY.moments, (1.0, 1.0, 1.7), np.stack([1 + 0 * SIZES, 1 + FIRST_ALONE, 1.7 + 0 * SIZES], axis=-1)]
)
def test_closed_form(moments):
    system = pt.System(pt.Body(moments))
    near = np.array(RATES)
    near[::3] = (1e-7, 1.0, 1e-9)  # next to the separatrix
    state = system.state(ATTITUDES, omega_body=near, time=STARTS)
    for times in (TIMES, [2.0], np.linspace(0, 1e3, 999)):
        assert differing(lambda s, x, t=times: pt.free_motion(s.body, x, t).phase, system, state) == {}


def test_closed_form_of_one_member_at_a_time():
    """Next to the separatrix the means of one member take more rounds than those of the others."""
    rng, count = np.random.default_rng(2), 1500
    moments = np.sort(rng.uniform(1, 1.9, (count, 3)), axis=1)
    rates = rng.normal(size=(count, 3))
    rates[::2, [0, 2]] *= 10.0 ** rng.uniform(-12, 0, (count // 2, 1))
    body = pt.Body(moments)
    state, times = body.state((0.5, 0.5, 0.5, 0.5), omega_body=rates), np.linspace(0, 100, 5)
    whole = pt.free_motion(body, state, times)
    for k in (*range(0, count, 50), 578):  # the last one differed
        own = np.array([k])
        one = pt.free_motion(members_of(body, own), members_of(state, own), times)
        assert all(np.array_equal(one.phase[name][0], rows[k]) for name, rows in whole.phase.items())


def test_noise_is_that_of_the_member():
    """Whoever it is computed with, also alone."""
    system, state = case("noise")
    whole = pt.propagate(system, state, TIMES)
    one = pt.propagate(members_of(system, 9), members_of(state, 9), TIMES)
    other = pt.propagate(system, members_of(state, 9), TIMES)
    np.testing.assert_allclose(one.omega_body, whole.omega_body[9], rtol=0, atol=1e-10)
    assert np.max(np.abs(other.omega_body - whole.omega_body[9])) > 1e-6


def test_noise_does_not_depend_on_chunks(tmp_path):
    system, state = case("noise")
    whole = pt.propagate(system, state, TIMES)
    stored = pt.propagate(system, state, TIMES, out=tmp_path / "run.zarr", chunk=5)
    assert np.array_equal(np.asarray(stored.quaternion), whole.quaternion)


def indicators(system, state):
    found = pt.analysis.chaos_indicators(system, state, TIMES[2:], vectors=2)
    names = ("growth", "fli", "megno", "mean_megno", "gali")
    shared = {
        name: np.broadcast_to(getattr(found, name), (len(found.growth), *np.shape(getattr(found, name))[-1:]))
        for name in ("units",)
    }
    return {name: getattr(found, name) for name in names} | shared


@pytest.mark.parametrize(
    "name",
    [
        "none",
        "one force",
        "zeros in one half",
        "orbits",
        "mass on a spring",
        pytest.param("pair", marks=pytest.mark.slow),
    ],
)
def test_indicators_of_chaos(name):
    assert differing(indicators, *case(name)) == {}


def transition(system, state):
    names = ["moments[0]"] if "primary" not in state.of_bodies else []
    found = pt.analysis.state_transition(system, state, TIMES, names)
    return found.motion.phase | {"directions": found.directions, "growth": found.growth}


@pytest.mark.parametrize("name", ["none", "one force", "orbits", "damper", "pair"])
def test_state_transitions(name):
    assert differing(transition, *case(name)) == {}


def test_sections():
    def points(system, state):
        found = pt.analysis.andoyer_section(system, state, 30.0)
        return {name: getattr(found, name)[:, :2] for name in "xy"}

    system, _ = case("none")
    calm = system.state(ATTITUDES, omega_body=0.5 + 0.1 * np.abs(ATTITUDES[:, 1:]))
    assert differing(points, system, calm) == {}
