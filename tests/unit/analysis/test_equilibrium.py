"""Relative equilibria: what comes out, what goes in, and the linear equations against the motion itself."""

import functools
import re

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot import functions as fn
from poinsot.algebra.quaternion import conjugate, product
from poinsot.analysis.equilibrium import Equilibrium, equilibria
from poinsot.parts import Gyrostat

IDENTITY = (1, 0, 0, 0)
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
EQUATORIAL = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.0, true_anomaly=0.7)
AT_REST = pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7))
TURNING = pt.RotatingFrame((0.5, 0.5, -0.5, 0.5), (0.3, 0.0, 1.1), epoch=0.4)
VERTICAL = pt.RotatingFrame(IDENTITY, (0, 0, 1.3))
BODY = pt.Body((1.0, 1.3, 1.6))
OBLIQUE = pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
SPHERE = pt.Body((1.0, 1.0, 1.0))


class Bent(pt.Potential):
    """Every kind of function, of vectors fixed in the body and in space."""

    along: pt.mechanics.Vector

    def energy(self, instant):
        x, y, z = instant.attitude.to_body(self.along)
        smooth = fn.atan2(x, 2 + y) + fn.exp(0.3 * z) * fn.sin(x + 0.2) / (2 - z) + fn.sqrt(2 + x * y) ** 1.5
        return 0.3 * (smooth + 2**z + fn.where(fn.less(x, 5.0), z * z * x, 7.0) + fn.asin(0.5 * x) * fn.log(3 + z))


class Thruster(pt.Torque):
    """A torque that depends on the attitude and the rate."""

    lever: pt.mechanics.Vector

    def torque(self, instant):
        return fn.cross(self.lever, instant.attitude.to_body((0.0, 0.0, 1.0))) - 0.2 * instant.omega_body


class Gyroscope(pt.Torque):
    """A torque across the rate, which takes no energy."""

    spin_body: pt.mechanics.Vector

    def torque(self, instant):
        return fn.cross(self.spin_body, instant.omega_body)


class Drag(pt.Torque):
    """Quadratic in the rate, with no derivative at rest."""

    coefficient: float

    def torque(self, instant):
        return -self.coefficient * fn.norm(instant.omega_body) * instant.omega_body


class Growing(pt.Potential):
    """It depends on the time."""

    slope: float

    def energy(self, instant):
        return self.slope * instant.time * instant.attitude.to_body((0, 0, 1))[0]


def rotation_vector(p0, p):
    return Rotation.from_quat(product(conjugate(p0), p), scalar_first=True).as_rotvec()


# ---------------------------------------------------------------------- the linear equations are those of the motion

CASES = {
    "satellite": (pt.System(BODY, pt.GravityGradient(CIRCLE)), CIRCLE.frame),
    "satellite, oblique": (pt.System(OBLIQUE, pt.GravityGradient(CIRCLE)), CIRCLE.frame),
    "gyrostat": (pt.System(OBLIQUE, Gyrostat((0.4, -0.9, 0.3)), pt.GravityGradient(CIRCLE)), CIRCLE.frame),
    "gyrostat, heavy": (
        pt.System(OBLIQUE, Gyrostat((0.4, -0.9, 0.3)), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))),
        VERTICAL,
    ),
    "satellite of an oblate planet": (
        pt.System(BODY, pt.GravityGradient(EQUATORIAL), pt.forces.Oblateness(EQUATORIAL, 0.1, 0.7, (0, 0, 1))),
        EQUATORIAL.frame,
    ),
    "satellite with friction": (
        pt.System(BODY, pt.GravityGradient(CIRCLE), pt.forces.LinearDamping(0.05)),
        CIRCLE.frame,
    ),
    "body near an attractor": (pt.System(OBLIQUE, pt.GravityGradient(AT_REST)), None),
    "heavy": (pt.System(OBLIQUE, pt.UniformGravity(0.7, (0.3, -0.2, 0.5))), None),
    "heavy, turning": (pt.System(OBLIQUE, pt.UniformGravity(0.7, (0.3, -0.2, 0.5))), VERTICAL),
    "bent": (pt.System(BODY, Bent((0.0, 0.0, 1.2)), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))), VERTICAL),
    "thruster": (pt.System(BODY, Thruster((0.2, 0.4, 0.1)), Bent((0.3, -0.4, 0.9))), None),
    "gyroscope": (pt.System(BODY, Gyroscope((0.2, -0.9, 0.4)), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))), None),
    "free": (pt.System(BODY), TURNING),
    "free, at rest": (pt.System(OBLIQUE), None),
}
each_case = pytest.mark.parametrize("name", CASES)


@functools.cache
def found_in(name):
    return equilibria(*CASES[name], time=0.3)


def from_equilibrium(system, e, frame, x, times):
    """The small motion from a displacement x of rotation vector and momentum: x at the times."""
    turn = Rotation.from_rotvec(x[:3]).as_quat(scalar_first=True)
    q = product(e.state.quaternion, turn)
    g = e.state.angular_momentum_body + x[3:]
    motion = pt.propagate(system, system.body.state(q, angular_momentum_body=g, time=e.state.time), times)
    p = motion.quaternion if frame is None else motion.relative_to(frame).quaternion
    change = motion.angular_momentum_body - e.state.angular_momentum_body
    return np.concatenate([rotation_vector(e.attitude, p), change], axis=-1)


@each_case
def test_linear_equations_are_those_of_the_motion(name):
    system, frame = CASES[name]
    found = found_in(name)
    assert found
    small, times = 2e-5, np.array([0.3, 1.0, 2.1])
    for e in found[:3]:
        forth = np.array([from_equilibrium(system, e, frame, x, times) for x in small * np.eye(6)])
        back = np.array([from_equilibrium(system, e, frame, x, times) for x in -small * np.eye(6)])
        for k, time in enumerate(times):
            expected = expm(e.matrix * (time - 0.3))
            response = (forth - back)[:, k].T / (2 * small)
            np.testing.assert_allclose(response, expected, rtol=0, atol=1e-8 * np.max(np.abs(expected)))


@each_case
def test_body_stays_at_an_equilibrium(name):
    system, frame = CASES[name]
    for e in found_in(name)[:3]:
        assert isinstance(e, Equilibrium)
        assert e.state.time == 0.3
        motion = pt.propagate(system, e.state, np.linspace(0.3, 1.8, 4))
        q = motion.quaternion if frame is None else motion.relative_to(frame).quaternion
        np.testing.assert_allclose(rotation_vector(e.attitude, q), 0, rtol=0, atol=1e-12)


@each_case
def test_numbers_of_an_equilibrium_fit_together(name):
    for e in found_in(name):
        np.testing.assert_allclose(np.linalg.norm(e.attitude), 1, rtol=0, atol=1e-15)
        assert np.all(np.diff(e.frequencies) >= 0)
        assert np.all(e.growth_rates > 0)
        assert np.all(e.frequencies > 0)
        characteristic = np.poly(e.matrix)
        np.testing.assert_allclose(
            np.poly(e.eigenvalues), characteristic, rtol=0, atol=1e-12 * np.max(np.abs(characteristic))
        )
        assert e.stable == (e.stability in ("lyapunov", "asymptotic", "linear"))
        assert (e.stability == "unstable") == (e.growth_rates.size > 0)


@each_case
def test_search_finds_the_same_from_other_attitudes_and_at_another_time(name):
    system, frame = CASES[name]
    others = Rotation.random(300, np.random.default_rng(3))
    ways = [found_in(name), equilibria(system, frame, guesses=others, time=-1.9)]
    spectra = [sorted(tuple(np.round(np.r_[e.frequencies, 0, e.growth_rates], 7)) for e in way) for way in ways]
    assert spectra[0] == spectra[1]
    assert sorted(e.stability for e in ways[0]) == sorted(e.stability for e in ways[1])


# ---------------------------------------------------------------------- families


FAMILIES = {
    "sphere in orbit": (pt.System(SPHERE, pt.GravityGradient(CIRCLE)), CIRCLE.frame, [3]),
    "free sphere": (pt.System(SPHERE), VERTICAL, [3]),
    "anything at rest": (pt.System(BODY), None, [3]),
    "symmetric in orbit": (pt.System(pt.Body((1.0, 1.0, 1.6)), pt.GravityGradient(CIRCLE)), CIRCLE.frame, [1] * 6),
    "symmetric, oblique": (
        pt.System(pt.Body.from_inertia(np.eye(3) + 0.6 / 3 * np.ones((3, 3))), pt.GravityGradient(CIRCLE)),
        CIRCLE.frame,
        [1] * 6,
    ),
    "free, symmetric": (pt.System(pt.Body((1.0, 1.6, 1.0))), VERTICAL, [1, 1, 2]),
    "free": (pt.System(BODY), TURNING, [1] * 6),
    "free, oblique": (pt.System(OBLIQUE), TURNING, [1] * 6),
    "top, slow": (pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(2.0, (0, 0, 0.5))), VERTICAL, [1, 1]),
    "top, tilted": (pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(0.5, (0, 0, 0.5))), VERTICAL, [1, 1, 2]),
}


@pytest.mark.samples
@pytest.mark.parametrize("name", FAMILIES)
def test_families_come_once(name):
    system, frame, dimensions = FAMILIES[name]
    assert sorted(e.family for e in equilibria(system, frame)) == dimensions


def test_guess_in_a_family_stays_where_it_is():
    guess = Rotation.from_rotvec((0, 0, 0.7))
    system = pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(0.5, (0, 0, 0.5)))
    (e,) = equilibria(system, VERTICAL, guesses=guess)
    np.testing.assert_allclose(e.attitude, guess.as_quat(scalar_first=True), rtol=0, atol=1e-12)


def test_guesses_may_be_one_or_many_and_lead_to_the_next_equilibrium():
    system, frame = CASES["satellite"]
    guesses = Rotation.from_rotvec([(0.1, -0.1, 0.05), (np.pi - 0.1, 0.1, 0.1), (-0.1, 0.1, 0.1)])
    found = equilibria(system, frame, guesses=guesses)
    np.testing.assert_allclose([abs(e.attitude) for e in found], [(1, 0, 0, 0), (0, 1, 0, 0)], rtol=0, atol=1e-15)
    assert len(equilibria(system, frame, guesses=guesses.as_quat(scalar_first=True)[0])) == 1
    assert len(equilibria(system, frame, guesses=[(1, 0, 0, 0), (-1, 0, 0, 0)])) == 1


# ---------------------------------------------------------------------- kinds of stability


def test_friction_makes_a_hanging_body_come_to_rest():
    system = pt.System(BODY, pt.UniformGravity(0.7, (0.3, -0.2, 0.5)), pt.forces.LinearDamping(0.1))
    assert sorted(e.stability for e in equilibria(system)) == ["asymptotic", "unstable"]


def test_friction_against_space_moves_a_satellite():
    """Pitch, about the normal: 3 n^2 (I_roll - I_yaw) sin cos = -c n."""
    n, friction = CIRCLE.mean_motion, 0.05
    system = pt.System(BODY, pt.GravityGradient(CIRCLE), pt.forces.LinearDamping(friction))
    (e,) = equilibria(system, CIRCLE.frame, guesses=IDENTITY)
    pitch = np.arcsin(-2 * friction / (3 * n * 0.3)) / 2
    np.testing.assert_allclose(e.attitude, (np.cos(pitch / 2), 0, 0, np.sin(pitch / 2)), rtol=0, atol=1e-14)
    assert e.stability == "asymptotic"


def test_torque_that_takes_no_energy_leaves_the_oscillations():
    found = equilibria(*CASES["gyroscope"])
    assert "linear" in {e.stability for e in found}
    assert "lyapunov" not in {e.stability for e in found}


def test_equilibrium_at_a_pitchfork_is_undecided():
    """A hanging body on the threshold of leaving the vertical: w^2 (A - C) = M g l."""
    system = pt.System(pt.Body((1.5, 1.2, 0.5)), pt.UniformGravity(0.5, (0, 0, -0.7)))
    for factor, kind in ((0.99, "lyapunov"), (1.0, "undecided"), (1.01, "unstable")):
        frame = pt.RotatingFrame(IDENTITY, (0, 0, np.sqrt(factor * 0.5 * 0.7)))
        (e,) = equilibria(system, frame, guesses=IDENTITY)
        assert (e.stability, e.family) == (kind, 1)
        assert e.stable == (kind == "lyapunov")


def test_slow_modes_count():
    """A body that is nearly symmetric in the plane of its orbit: pitch sqrt(3e-8) n."""
    system = pt.System(pt.Body((1.0, 1.0 + 1e-8, 1.3)), pt.GravityGradient(CIRCLE))
    turned = Rotation.from_rotvec([(0, 0, 0), (0, 0, np.pi / 2)])
    stable, unstable = equilibria(system, CIRCLE.frame, guesses=turned)
    rate = CIRCLE.mean_motion * np.sqrt(3e-8 / 1.3)
    assert stable.frequencies[0] == pytest.approx(rate, rel=1e-6)
    assert unstable.growth_rates[0] == pytest.approx(rate, rel=1e-6)
    assert (stable.stability, unstable.stability) == ("lyapunov", "unstable")


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e12])
@pytest.mark.parametrize("pace", [1e-4, 1.0, 1e3])
def test_units_do_not_matter(scale, pace):
    orbit = pt.KeplerOrbit(
        2.0 * pace**2,
        semimajor_axis=1.5,
        eccentricity=0.0,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        true_anomaly=2.0,
        epoch=0.25 / pace,
    )
    found = equilibria(pt.System(pt.Body(scale * BODY.moments), pt.GravityGradient(orbit)), orbit.frame)
    same = found_in("satellite")
    assert len(found) == 24
    for e, other in zip(found, same, strict=True):
        assert e.stability == other.stability
        np.testing.assert_allclose(e.attitude, other.attitude, rtol=0, atol=1e-14)
        np.testing.assert_allclose(e.frequencies / pace, other.frequencies, rtol=1e-13)


@pytest.mark.parametrize("thin", [1e-1, 1e-3, 1e-5])
def test_slender_body_in_oblique_axes_has_the_stability_of_one_in_principal_axes(thin):
    turn = Rotation.from_rotvec((0.3, -0.5, 0.8)).as_matrix()
    bodies = pt.Body((thin, 1, 1)), pt.Body.from_inertia(turn @ np.diag((thin, 1, 1)) @ turn.T)
    ways = [equilibria(pt.System(body, pt.GravityGradient(CIRCLE)), CIRCLE.frame) for body in bodies]
    principal, oblique = (sorted((e.stability, e.family) for e in way) for way in ways)
    assert principal == oblique == [("lyapunov", 1)] * 2 + [("unstable", 1)] * 4


def test_repr_tells_stability_attitude_and_frequencies():
    (e,) = equilibria(*CASES["satellite"], guesses=IDENTITY)
    text = r"Equilibrium: lyapunov\n  attitude .*: \[1, .*\]\n  frequencies: \[.*\] rad per unit of time"
    assert re.fullmatch(text, repr(e))


# ---------------------------------------------------------------------- wrong input

ELLIPSE = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.01,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
SATELLITE = pt.System(BODY, pt.GravityGradient(CIRCLE))
WRONG = {
    "system": (
        lambda: equilibria(BODY),
        TypeError,
        r"system must be a System, got Body\.",
    ),
    "frame": (
        lambda: equilibria(SATELLITE, CIRCLE),
        TypeError,
        r"frame must be a Frame, got KeplerOrbit\. An orbit has one: orbit\.frame\.",
    ),
    "members": (
        lambda: equilibria(pt.System(pt.Body([(1, 1, 1), (1, 1, 1.5)]))),
        ValueError,
        r"system must be a single one, got 2 members\. Take the members one by one\.",
    ),
    "ellipse": (
        lambda: equilibria(pt.System(BODY, pt.GravityGradient(ELLIPSE)), ELLIPSE.frame),
        ValueError,
        r"frame must turn uniformly, but its angular velocity changes by 0\.0\d+ of its size\. "
        r"That of an orbit does if the orbit is a circle\.",
    ),
    "no frame": (
        lambda: equilibria(SATELLITE),
        ValueError,
        r"system must look the same from the frame at all times, but its torque changes by 0\.\d+ until t = \S+\. "
        r"Name the frame with which the forces turn, such as orbit\.frame\.",
    ),
    "frame of another orbit": (
        lambda: equilibria(SATELLITE, EQUATORIAL.frame),
        ValueError,
        r"system must look the same from the frame .*",
    ),
    "ellipse in a uniform frame": (
        lambda: equilibria(pt.System(BODY, pt.GravityGradient(ELLIPSE)), CIRCLE.frame),
        ValueError,
        r"system must look the same from the frame .*",
    ),
    "time": (
        lambda: equilibria(pt.System(BODY, Growing(0.1))),
        ValueError,
        r"system must look the same from the frame .*",
    ),
    "no derivative": (
        lambda: equilibria(pt.System(BODY, Drag(0.1))),
        ValueError,
        r"system must have a torque with a derivative where the body is at rest in the frame, but it is not finite\. "
        r"The norm of a zero vector has no derivative\.",
    ),
    "guesses": (
        lambda: equilibria(SATELLITE, CIRCLE.frame, guesses=(1, 0, 0, 1)),
        ValueError,
        r"guesses must have unit norm, but \|q\| = 1\.414213562\. Divide by the norm, or pass a Rotation\.",
    ),
    "instant": (
        lambda: equilibria(SATELLITE, CIRCLE.frame, time=(0, 1)),
        ValueError,
        r"time must have shape \(\), got shape \(2,\)\.",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_gives_one_sentence(name):
    call, kind, sentence = WRONG[name]
    with pytest.raises(kind) as caught:
        call()
    assert re.fullmatch(sentence, str(caught.value)), caught.value
