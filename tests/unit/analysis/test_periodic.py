"""Periodic motions: against equilibria, symplectic geometry and Liouville's theorem; what comes out, what goes in."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import poinsot as pt
from poinsot.analysis import periodic
from poinsot.analysis.periodic import cassini_state, periodic_motion

IDENTITY = (1, 0, 0, 0)
BODY = pt.Body((1.0, 1.3, 1.6))
MOON = pt.Body((0.99, 0.993, 1.0))
CIRCLE = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.0,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
ELLIPSE = pt.KeplerOrbit(
    1.1,
    semimajor_axis=1.2,
    eccentricity=0.07,
    inclination=0.3,
    node=0.5,
    argument_of_periapsis=2.1,
    true_anomaly=1.0,
    epoch=-0.4,
)
PRECESSING = pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=-0.004, periapsis_rate=0.0, anomaly_rate=0.002)


def system(orbit, body=BODY, *more):
    return pt.System(body, pt.GravityGradient(orbit), *more)


def upright(orbit, body=BODY, time=0.0):
    return body.state(IDENTITY, omega_body=(0, 0, 0), time=time, frame=orbit.frame)


@pytest.fixture(scope="module")
def cassini():
    return cassini_state(MOON, PRECESSING)


def folded(frequencies, period):
    """The angular frequencies that a look once in a period cannot tell from these, in (0, pi/period]."""
    turns = np.asarray(frequencies) * period / (2 * np.pi)
    return np.sort(np.abs(turns - np.rint(turns))) * 2 * np.pi / period


def symplectic(motion):
    """The form that motions under potentials keep, of rotation vectors and momenta along the body axes."""
    x, y, z = motion.state.angular_momentum_body
    gyration = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[-gyration, np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])


# ---------------------------------------------------------------------- against what is known otherwise


@pytest.mark.parametrize("body", [BODY, pt.Body((1.3, 1.0, 1.6))], ids=["stable", "unstable"])
@pytest.mark.parametrize("share", [1.0, 0.31])
def test_equilibrium_repeats_itself_after_any_period(body, share):
    (e,) = pt.analysis.equilibria(system(CIRCLE, body), CIRCLE.frame, guesses=IDENTITY, time=0.6)
    period = share * CIRCLE.period
    found = periodic_motion(system(CIRCLE, body), upright(CIRCLE, body, 0.6), period, CIRCLE.frame)
    np.testing.assert_allclose(found.state.conjugate_momenta, e.state.conjugate_momenta, rtol=0, atol=1e-14)
    expected = expm(e.matrix * period)
    np.testing.assert_allclose(found.matrix, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))
    np.testing.assert_allclose(found.frequencies, folded(e.frequencies, period), rtol=0, atol=2e-14)
    np.testing.assert_allclose(found.growth_rates, e.growth_rates, rtol=2e-14)
    assert found.stable == e.stable


def test_motion_on_an_ellipse_is_the_same_in_space_and_in_the_axes_of_the_orbit():
    period = ELLIPSE.period
    in_space = periodic_motion(system(ELLIPSE, MOON), upright(ELLIPSE, MOON), period)
    in_orbit = periodic_motion(system(ELLIPSE, MOON), upright(ELLIPSE, MOON), period, ELLIPSE.frame)
    np.testing.assert_allclose(in_space.state.quaternion, in_orbit.state.quaternion, rtol=0, atol=1e-13)
    np.testing.assert_allclose(in_space.matrix, in_orbit.matrix, rtol=0, atol=1e-13)
    assert in_space.stable


def test_motion_repeats_itself(cassini):
    motion = cassini.motion
    times = motion.state.time + motion.period * np.array([0.0, 0.3, 1.0, 1.3, 2.0])
    along = pt.propagate(system(PRECESSING, MOON), motion.state, times)
    p = along.relative_to(motion.frame).attitude
    for before, after in ((0, 2), (1, 3), (2, 4)):
        assert (p[before].inv() * p[after]).magnitude() < 1e-12
        np.testing.assert_allclose(along.omega_body[after], along.omega_body[before], rtol=0, atol=1e-12)


def test_matrix_of_potentials_is_symplectic(cassini):
    unstable = periodic_motion(system(ELLIPSE, pt.Body((1.3, 1.0, 1.6))), upright(ELLIPSE), ELLIPSE.period)
    assert not unstable.stable
    for motion, bound in ((cassini.motion, 2e-14), (unstable, 5e-14)):
        J = symplectic(motion)
        np.testing.assert_allclose(motion.matrix.T @ J @ motion.matrix, J, rtol=0, atol=bound)
        pairs = motion.multipliers[:, None] * motion.multipliers
        assert np.all(np.min(np.abs(pairs - 1), axis=0) < bound)


def test_friction_shrinks_the_phase_space_as_liouville_says():
    """The trace of g' = -c I^-1 g + ... makes det = exp(-c period (1/A + 1/B + 1/C))."""
    friction = 1e-4
    forced = system(ELLIPSE, MOON, pt.forces.LinearDamping(friction))
    motion = periodic_motion(forced, upright(ELLIPSE, MOON), ELLIPSE.period)
    expected = np.exp(-friction * ELLIPSE.period * np.sum(1 / MOON.moments))
    assert np.linalg.det(motion.matrix) == pytest.approx(expected, rel=1e-13, abs=0)
    assert motion.stable
    assert np.all(np.abs(motion.multipliers) < 1)


def test_permanent_rotation_of_a_free_body():
    """One of a family: the wobble (C - A)(C - B)/(A B), and multipliers that are 1."""
    A, B, C = BODY.moments
    spin = 0.9
    period = 2 * np.pi / spin
    motion = periodic_motion(pt.System(BODY), BODY.state(IDENTITY, omega_body=(0, 0, spin)), period)
    wobble = spin * np.sqrt((C - A) * (C - B) / (A * B))
    np.testing.assert_allclose(motion.frequencies, folded([wobble], period), rtol=1e-13)
    assert np.sum(np.abs(motion.multipliers - 1) < 1e-6) == 4
    assert motion.stable


@pytest.mark.parametrize("scale", [1e-9, 1e12])
@pytest.mark.parametrize("pace", [1e-4, 1e3])
def test_units_do_not_matter(cassini, scale, pace):
    orbit = pt.orbits.PrecessingOrbit(
        pt.KeplerOrbit(
            1.1 * pace**2,
            semimajor_axis=1.2,
            eccentricity=0.07,
            inclination=0.3,
            node=0.5,
            argument_of_periapsis=2.1,
            true_anomaly=1.0,
            epoch=-0.4 / pace,
        ),
        node_rate=-0.004 * pace,
        periapsis_rate=0.0,
        anomaly_rate=0.002 * pace,
    )
    same = cassini_state(pt.Body(scale * MOON.moments), orbit)
    assert same.obliquity == pytest.approx(cassini.obliquity, rel=1e-12, abs=0)
    np.testing.assert_allclose(same.motion.frequencies / pace, cassini.motion.frequencies, rtol=1e-12)


def test_period_may_start_anywhere(cassini):
    own = cassini.motion
    along = pt.propagate(system(PRECESSING, MOON), own.state, [own.state.time + 0.4 * own.period], dense=True)
    later = along(along.times[0])
    other = periodic_motion(system(PRECESSING, MOON), later, own.period, own.frame)
    np.testing.assert_allclose(other.state.quaternion, later.quaternion, rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.frequencies, own.frequencies, rtol=1e-12)


def test_motion_over_a_period_is_read_from_its_start(cassini):
    motion = cassini.motion
    along = motion.over_period(8)
    np.testing.assert_allclose(along.times, motion.state.time + motion.period * np.arange(8) / 8, rtol=1e-15)
    np.testing.assert_allclose(along.quaternion[0], motion.state.quaternion, rtol=0, atol=1e-15)


def test_multipliers_that_are_real_and_negative_have_a_growth_rate():
    """A child's swing: a pendulum whose support is driven at twice its frequency; its map has det 1."""
    body = pt.Body((1.0, 1.0, 1.0))
    motion = periodic_motion(pt.System(body, Swing(0.4, 2.0)), body.state(IDENTITY, omega_body=(0, 0, 0)), np.pi)
    mathieu = solve_ivp(swing_rates, (0, np.pi), [1, 0, 0, 1], rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    known = np.linalg.eigvals(mathieu.reshape(2, 2).T)
    assert np.all(known.imag == 0)
    assert np.all(known.real < 0)
    np.testing.assert_allclose(motion.growth_rates, np.log(np.max(-known)) / np.pi, rtol=1e-9)


def test_numbers_of_a_motion_fit_together(cassini):
    motion = cassini.motion
    assert np.all(np.diff(motion.frequencies) > 0)
    assert np.all((motion.frequencies > 0) & (motion.frequencies <= np.pi / motion.period))
    characteristic = np.poly(np.linalg.eigvals(motion.matrix))
    np.testing.assert_allclose(np.poly(motion.multipliers), characteristic, rtol=0, atol=1e-12)
    rates = r"frequencies: \[.*\] rad per unit of time"
    text = rf"Periodic motion of .*\n  period: \d+\.\d+.*\n  stable: yes\n  {rates}\n"
    assert re.match(text, repr(motion))


@pytest.mark.parametrize(("rate", "angle", "count"), [(1.0, 0.0, 1), (1.4, 1.5, 2), (3.0, 0.3, 3)])
def test_rotations_tell_the_resonance_that_is_found(rate, angle, count):
    """A guess between two resonances may lead to either: the turn of the long axis in a period tells which it is."""
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.02)
    moon = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.1), pt.GravityGradient(orbit))
    guess = moon.body.state((np.cos(angle / 2), 0, 0, np.sin(angle / 2)), omega_body=(0, 0, rate))
    found = pt.analysis.periodic_motion(moon, guess, orbit.period)
    long_axis = pt.propagate(moon, found.state, np.linspace(0, orbit.period, 101)).attitude.apply((1, 0, 0))
    longitudes = np.unwrap(np.arctan2(long_axis[:, 1], long_axis[:, 0]))
    assert longitudes[-1] - longitudes[0] == pytest.approx(2 * np.pi * count, abs=1e-9)
    assert found.rotations == pytest.approx([count], abs=1e-9)
    assert f"rotations in a period: {count}\n" in repr(found)


def test_a_sampled_controller_has_multipliers_of_zero():
    """A rate is multiplied by 1 - gain * step / moment at each sample; attitudes stay; the held torque is set anew."""
    moments, gain, step = np.array([10.0, 12.0, 8.0]), 2.0, 0.5
    law = pt.control.Sampled(pt.control.RateDamping(gain, limit=0.05), step)
    system = pt.System(pt.Body(moments), law)
    at_rest = system.state((0.1, 0.7, -0.5, 0.5), omega_body=(0, 0, 0))
    motion = pt.analysis.periodic_motion(system, at_rest, 2 * step)
    expected = np.concatenate([np.zeros(3), (1 - gain * step / moments) ** 2, np.ones(3)])
    np.testing.assert_allclose(np.sort(motion.multipliers.real), np.sort(expected), rtol=0, atol=3e-15)  # roundings
    assert np.max(np.abs(motion.multipliers.imag)) < 3e-15
    assert motion.growth_rates.size == 0


class Following(pt.Part, pt.Torque):
    """A controller with a memory: it adds up what the rate is off a spin."""

    gain: float
    period: float
    variables = {"torque": 3, "sum": 3}  # noqa: RUF012

    @property
    def jump(self):
        return pt.mechanics.Jump(self.period, 0.0)

    def update(self, instant, draws):  # noqa: ARG002
        error = instant.omega_body - pt.functions.Vector((0.0, 0.0, 1.0))
        total = 0.9 * pt.functions.Vector(instant.own(self)[3:]) + self.period * error
        return pt.functions.Vector((*(-self.gain * (error + 0.1 * total)), *total))

    def rates(self, instant, generalised_force):  # noqa: ARG002
        return pt.functions.Vector((0.0,) * 6)

    def torque(self, instant):
        return pt.functions.Vector(instant.own(self)[:3])


def test_a_controller_with_a_memory_repeats_itself():
    """The samples at the end of a period are those at the start of the next one."""
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
    law = Following(0.05, orbit.period / 8)
    system = pt.System(pt.Body((1.0, 1.5, 2.0)), pt.GravityGradient(orbit), law)
    found = pt.analysis.periodic_motion(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 1)), orbit.period)
    own = pt.propagate(system, found.state, [orbit.period, 2 * orbit.period]).own["following"]
    # Newton's method ends within 1e-8; the largest multiplier is 1.52.
    assert np.max(np.abs(own - found.state.own["following"])) < 1e-7
    assert np.max(np.abs(own)) > 0.1


# ---------------------------------------------------------------------- Cassini states


def test_names_go_with_the_modes(cassini):
    """About the third axis; axis and momentum together; the momentum at rest while the axis goes round it."""
    motion = cassini.motion
    size = np.linalg.norm(motion.state.angular_momentum_body)
    to_space = np.array([[0, -1], [1, 0]]) * size  # what a turn across the third axis adds to the momentum in space
    assert sorted([cassini.longitude, cassini.precession, cassini.wobble]) == pytest.approx(motion.frequencies)
    multipliers, modes = np.linalg.eig(motion.matrix)
    shares = {}
    for name in ("longitude", "precession", "wobble"):
        mode = modes[:, np.argmin(np.abs(np.angle(multipliers) - getattr(cassini, name) * motion.period))]
        across = np.linalg.norm(mode[:2])
        swing = np.linalg.norm(mode[3:5] - to_space @ mode[:2]) / size
        shares[name] = across / abs(mode[2]), swing / across
    assert shares["longitude"][0] < 0.2
    assert shares["precession"][1] > 0.8
    assert shares["wobble"][1] < 0.2


def test_axis_is_in_the_plane_of_pole_and_normal(cassini):
    assert cassini.inclination == pytest.approx(cassini.obliquity + 0.3, abs=1e-4)
    opposite = cassini_state(MOON, PRECESSING, obliquity=np.radians(170.0))
    assert opposite.obliquity > 3.0
    assert opposite.inclination == pytest.approx(2 * np.pi - opposite.obliquity - 0.3, abs=1e-4)


@pytest.mark.parametrize("lean", [0.2, -0.2])
def test_guess_leans_away_from_the_pole(monkeypatch, lean):
    guesses = []
    monkeypatch.setattr(periodic, "periodic_motion", lambda _, guess, *__: guesses.append(guess))
    with pytest.raises(AttributeError):
        cassini_state(MOON, PRECESSING, obliquity=lean)
    assert np.arccos(guesses[0].attitude.as_matrix()[2, 2]) == pytest.approx(0.3 + lean, abs=1e-12)


def test_without_motion_of_the_node_the_axis_is_normal_to_the_orbit():
    state = cassini_state(MOON, pt.orbits.PrecessingOrbit(ELLIPSE))
    assert state.obliquity < 1e-11
    assert state.inclination == pytest.approx(0.3, abs=1e-11)


def test_unstable_state_has_no_names():
    state = cassini_state(pt.Body((0.993, 0.99, 1.0)), PRECESSING)
    assert not state.motion.stable
    assert np.isnan([state.longitude, state.precession, state.wobble]).all()


class Swing(pt.Potential):
    """It pulls every axis of the body to the same one of space, more and less strongly."""

    depth: float
    rate: float

    def energy(self, instant):
        pull = 1 + self.depth * pt.functions.cos(self.rate * instant.time)
        return -pull * sum(instant.attitude.to_body(np.eye(3)[k])[k] for k in range(3)) / 2


def swing_rates(t, y):
    """Small angles of it."""
    pull = 1 + 0.4 * np.cos(2 * t)
    return y[1], -pull * y[0], y[3], -pull * y[2]


# ---------------------------------------------------------------------- wrong input


class Growing(pt.Potential):
    """It depends on the time."""

    slope: float

    def energy(self, instant):
        return self.slope * instant.time * instant.attitude.to_body((0, 0, 1))[0]


class Motor(pt.Torque):
    """It spins the body up for ever, or without end in a finite time."""

    strength: float
    growth: float

    def torque(self, instant):
        x, y, z = instant.omega_body
        return 0.0 * x, 0.0 * y, self.strength + self.growth * z * z


MEMBERS = pt.System(pt.Body([(1, 1, 1), (1, 1, 1.5)]))
FREE = BODY.state(IDENTITY, omega_body=(0, 0, 1))
HYPERION = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.123233)
WILD = pt.System(pt.Body.from_ratios(beta=0.47, gamma=0.26), pt.GravityGradient(HYPERION))
WRONG = {
    "system": (
        lambda: periodic_motion(BODY, FREE, 1.0),
        TypeError,
        r"system must be a System, got Body\. The order is periodic_motion\(system, guess, period\)\.",
    ),
    "guess": (
        lambda: periodic_motion(pt.System(BODY), IDENTITY, 1.0),
        TypeError,
        r"guess must be a State or a PairState, got tuple\. The order is .*",
    ),
    "members": (
        lambda: periodic_motion(MEMBERS, FREE, 1.0),
        ValueError,
        r"system and guess must be single ones, got 2 members\. Take the members one by one\.",
    ),
    "members of the guess": (
        lambda: periodic_motion(pt.System(BODY), BODY.state([IDENTITY] * 3, omega_body=(0, 0, 1)), 1.0),
        ValueError,
        r"system and guess must be single ones, got 3 members\. .*",
    ),
    "period": (
        lambda: periodic_motion(pt.System(BODY), FREE, -1.0),
        ValueError,
        r"period must be positive, got -1\.0\.",
    ),
    "frame": (
        lambda: periodic_motion(pt.System(BODY), FREE, 1.0, CIRCLE),
        TypeError,
        r"frame must be a Frame, got KeplerOrbit\. An orbit has one: orbit\.frame\.",
    ),
    "frame that does not repeat itself": (
        lambda: periodic_motion(pt.System(BODY), FREE, 1.0, ELLIPSE.frame),
        ValueError,
        r"frame must turn in the same way in every period, but its angular velocity changes by 0\.\d+ of its size\. "
        r"A RotatingFrame turns at a constant rate\.",
    ),
    "another period": (
        lambda: periodic_motion(system(ELLIPSE), FREE, 7.0),
        ValueError,
        r"system must repeat itself in the frame after the period 7, but its torque changes by \d\.\d+ of its size\. "
        r"Name the period of the orbit, and the frame that turns with its node\.",
    ),
    "another frame": (
        lambda: periodic_motion(system(PRECESSING), FREE, PRECESSING.period),
        ValueError,
        r"system must repeat itself .*",
    ),
    "periapsis that moves": (
        lambda: cassini_state(MOON, pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=-0.004, periapsis_rate=0.001)),
        ValueError,
        r"system must repeat itself .*",
    ),
    "time": (
        lambda: periodic_motion(pt.System(BODY, Growing(0.1)), FREE, 1.0),
        ValueError,
        r"system must repeat itself .*",
    ),
    "too long": (
        lambda: periodic_motion(WILD, BODY.state(IDENTITY, omega_body=(0, 0, 1)), 100 * HYPERION.period),
        ValueError,
        r"guess must lead to a motion that depends smoothly on its start, but over the period 628\.319 small "
        r"displacements grow \de\+\d\d times\. Choose a shorter period\.",
    ),
    "nothing to find": (
        lambda: periodic_motion(pt.System(BODY, Motor(0.1, 0.0)), FREE, 1.0),
        ValueError,
        r"guess must be near a motion that repeats itself, but after 40 steps of Newton's method it still misses "
        r"itself by 0\.06\d* rad in a period\. Start nearer, or elsewhere\.",
    ),
    "motion that ends": (
        lambda: periodic_motion(pt.System(BODY, Motor(0.0, 4.0)), FREE, 1.0),
        ValueError,
        r"guess must lead to a motion without end, but propagation stopped at t = 0\.\d+ of 1: .*",
    ),
    "body": (
        lambda: cassini_state(PRECESSING, MOON),
        TypeError,
        r"body must be a Body, got PrecessingOrbit\. The order is cassini_state\(body, orbit\)\.",
    ),
    "orbit": (lambda: cassini_state(MOON, ELLIPSE), TypeError, r"orbit must be a PrecessingOrbit, got KeplerOrbit.*"),
    "spin": (
        lambda: cassini_state(MOON, PRECESSING, 1.3),
        ValueError,
        r"spin must be a positive multiple of 1/2, got 1\.3\. It is 1 of moons, 1\.5 of Mercury\.",
    ),
    "members of the body": (
        lambda: cassini_state(pt.Body([(1, 1, 1), (1, 1, 1.5)]), PRECESSING),
        ValueError,
        r"body and orbit must be single ones, got 2 members\. Take the members one by one\.",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_refused_with_a_sentence(name):
    call, kind, sentence = WRONG[name]
    with pytest.raises(kind) as raised:
        call()
    assert re.fullmatch(sentence, str(raised.value)), str(raised.value)
