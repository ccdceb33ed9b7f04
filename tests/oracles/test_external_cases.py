"""Motions that other people published or that other programs produced."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import poinsot as pt

DEGREE = np.pi / 180
IDENTITY = (1, 0, 0, 0)


def largest(difference):
    return np.max(np.abs(difference))


def zeros(function, times):
    """The upward zero crossings of a function between the given times."""
    values = function(times)
    rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    return np.array([brentq(function, times[i], times[i + 1], xtol=1e-13, rtol=1e-15) for i in rising])


def period(function, times):
    """The time from the first to the last upward zero crossing, over the number of turns between them."""
    crossings = zeros(function, times)
    assert len(crossings) > 1
    return (crossings[-1] - crossings[0]) / (len(crossings) - 1)


# ---------------------------------------------------------------------- torque-free


def integrated(body, start, times):
    return pt.propagate(pt.System(body), start, times, dense=True)


@pytest.fixture(params=[integrated, pt.free_motion], ids=["integrated", "closed form"])
def free(request):
    """Torque-free motion by each of the two ways."""
    return request.param


def test_tumbling_brick(free):
    # NESC check-case Atmos-02, NASA/TM-2015-218675, simulators 01 and 04; slug ft^2 and degrees.
    body = pt.Body((0.001894220, 0.006211019, 0.007194665))
    start = body.state(IDENTITY, omega_body=np.array([10, 20, 30]) * DEGREE)
    published = [
        (-2.41890222177841, -23.55256951951579, 28.12859263003343),
        (12.61839077566776, -17.3974747618308, 31.11958888682995),
    ]
    motion = free(body, start, [10.0, 30.0])
    assert largest(motion.omega_body / DEGREE - published) < 4e-10


def scales_of_detest_b5(moments):
    """The factors s of omega = s y that make Euler's equations y1' = y2 y3, y2' = -y1 y3, y3' = -0.51 y1 y2.

    With a = (I2 - I3)/I1, b = (I1 - I3)/I2, c = (I2 - I1)/I3, all positive for I2 > I1 > I3, this asks for
    a s2 s3 = s1, b s1 s3 = s2 and c s1 s2 = 0.51 s3. The products of two of them give the squares of the s.
    """
    I1, I2, I3 = moments
    a, b, c = (I2 - I3) / I1, (I1 - I3) / I2, (I2 - I1) / I3
    return np.sqrt([0.51 / (b * c), 0.51 / (a * c), 1 / (a * b)])


@pytest.mark.parametrize("moments", [(2.0, 3.0, 1.5), (1.1, 1.9, 1.0)])
def test_detest_b5(free, moments):
    # Krogh's problem B5 of the DETEST set (MATLAB's rigidode): y(0) = (0, 1, 1), y = (sn, cn, dn)(t | 0.51).
    body, scales = pt.Body(moments), scales_of_detest_b5(moments)
    start = body.state(IDENTITY, omega_body=scales * [0, 1, 1])
    published = [(-0.93965707987292035, -0.34211777540007499, 0.74141265961999536), (0, 1, 1)]
    motion = free(body, start, [20.0, 2 * 7.4505632093309542])
    assert largest(motion.omega_body / scales - published) < (1e-13 if free is integrated else 8e-15)


def test_dzhanibekov_flip(free):
    # Principia's test data: I = (3, 5, 9) and g = (0, 2, 0.01). No rigid body has these moments (9 > 3 + 5), but
    # g' = g x omega stays the same when a constant is added to all 1/I, and the period of g with it.
    body = pt.Body(1 / (1 / np.array([3.0, 5, 9]) + 1))
    start = body.state(IDENTITY, angular_momentum_body=(0, 2, 0.01))
    motion = free(body, start, [-10, 350])
    measured = period(lambda t: motion(t).angular_momentum_body[..., 0], np.linspace(-10, 350, 361))
    assert abs(measured / 118.11088704644376 - 1) < 1e-11
    rotation = pt.analysis.FreeRotation(body, start)
    # The published digits are off by 5e-13: 4 K / lambda in 30 digits is this.
    assert abs(rotation.rotation_period / 118.110887046385744 - 1) < 3e-15
    assert abs(rotation.modulus**2 - 0.99995833506937) < 1e-14


def test_constant_momentum_next_to_a_separatrix(free):
    # Principia's test data: the rate is constant in the body, and the body turns about the fixed momentum.
    body, momentum = pt.Body((2, 3, 3)), np.array([0.0, 4, 5])
    start = body.state(IDENTITY, angular_momentum_body=momentum)
    motion = free(body, start, [10.0])
    assert largest(motion.omega_body[0] - momentum / 3) < 2e-14
    turned = Rotation.from_rotvec(10 * momentum / 3)
    assert (motion.attitude[0] * turned.inv()).magnitude() < 2e-14


def toutatis(free):
    # Takahashi, Busch and Scheeres (2013), 4179 Toutatis; days and degrees; the long axis is the third.
    body = pt.Body((3.0836, 3.235, 1))
    attitude = Rotation.from_euler("ZXZ", [145.498, 65.865, 241.524], degrees=True)
    start = body.state(attitude, omega_body=np.array([14.51, 33.529, -98.709]) * DEGREE)
    return body, start, free(body, start, np.linspace(0, 60, 601))


def test_toutatis_rotates_about_its_long_axis(free):
    body, start, motion = toutatis(free)
    measured = period(lambda t: motion(t).angular_momentum_body[..., 0], motion.times)
    assert abs(measured - 5.369) < 0.0005
    assert abs(pt.analysis.FreeRotation(body, start).rotation_period / measured - 1) < 8e-15


def test_long_axis_of_toutatis_precesses(free):
    body, start, motion = toutatis(free)
    turns = zeros(lambda t: motion(t).angular_momentum_body[..., 0], motion.times)
    G = motion.angular_momentum_space[0]
    across = np.cross(G, [1.0, 0, 0])
    further = np.cross(G, across) / np.linalg.norm(G)
    long_axis = motion.attitude.as_matrix()[:, :, 2]
    azimuth = np.unwrap(np.arctan2(long_axis @ further, long_axis @ across))
    advance = np.diff(np.interp(turns[[0, -1]], motion.times, azimuth))[0]
    measured = 2 * np.pi * (turns[-1] - turns[0]) / advance
    assert abs(measured - 7.412) < 0.0005
    assert (
        abs(pt.analysis.FreeRotation(body, start).precession_period / measured - 1) < 1e-4
    )  # sampled at tenths of a day


# ---------------------------------------------------------------------- gravity gradient


def test_jeod_run_10a():
    # NASA JEOD, SIM_dyncomp RUN_10A (the NESC orbital check-case 10A); kg m^2, m, s.
    space_to_body = np.array(
        [
            (-0.6443912270931274, 0.05284210190675609, 0.7628680480341864),
            (-0.7615617870471506, -0.1345758407161209, -0.6339660776454052),
            (0.06916350883930189, -0.9894933326514259, 0.1269620166955875),
        ]
    )
    orbit = pt.KeplerOrbit.from_vectors(
        3.986004415e14, position=(-4292653.41, 955168.47, 5139356.57), velocity=(109.649663, -7527.726490, 1484.521489)
    )
    body = pt.Body((500, 12250, 12250))
    start = body.state(
        Rotation.from_matrix(space_to_body.T), omega_body=(-1.97989570839746e-05, -0.001134281491669957, 0)
    )
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), start, [28800.0])
    published = (-1.97989570839746e-05, -0.001080027400090759, -0.0007098670173048437)
    assert largest(motion.omega_body[0] - published) < 7e-16
    # An integration with 64 bits of mantissa and a Cartesian orbit is 5.0e-13 away from JEOD's matrix too.
    row = (-0.1303977224153033, -0.9235551691194414, 0.3606137595567613)
    assert largest(motion.attitude.as_matrix()[0][:, 0] - row) < 1.6e-12
    position = (-1024262.411095882, -6151093.565368023, 2599975.06217899)
    assert largest(np.array(orbit.position_at(28800.0)) - position) < 4e-6


SMALL = 1e-5
CIRCLE = pt.KeplerOrbit(1.7, semimajor_axis=1.3, eccentricity=0.0, inclination=0.4, node=-0.8, true_anomaly=0.3)


def libration_frequency(moments, tilt, component):
    """The frequency, over n, of the radial body axis about the radius of a circular orbit.

    `tilt` is the initial turn from the axes radial, transverse, normal; `component` is the one in which the
    first body axis then swings, 1 along the transverse and 2 along the normal.
    """
    body, frame = pt.Body(moments), CIRCLE.frame
    start = body.state(Rotation.from_rotvec(tilt), omega_body=(0, 0, 0), frame=frame)
    times = np.linspace(0, 6 * CIRCLE.period, 301)
    motion = pt.propagate(pt.System(body, pt.GravityGradient(CIRCLE)), start, times, dense=True)

    def swing(t):
        first_axis = motion(t).attitude.as_matrix()[..., 0]
        axes = frame.attitude(t).as_matrix()
        return np.einsum("...i,...i->...", axes[..., component], first_axis)

    return 2 * np.pi / period(swing, times) / CIRCLE.mean_motion


def test_pitch_of_phobos():
    # Linear theory: sqrt(3 (I_roll - I_yaw)/I_pitch) n; moments of Phobos from Tudat's unit test.
    radial, transverse, normal = 0.3615, 0.4265, 0.5024
    measured = libration_frequency((radial, transverse, normal), (0, 0, SMALL), 1)
    assert abs(measured - np.sqrt(3 * (transverse - radial) / normal)) < 1e-9
    assert abs(measured - 0.6230063745604) < 1e-9


@pytest.mark.parametrize(("tilt", "component", "expected"), [((0, 0, SMALL), 1, np.sqrt(3)), ((0, -SMALL, 0), 2, 2)])
def test_dumbbell_librates_at_root_three_in_the_orbit_plane_and_two_across(tilt, component, expected):
    # Linear theory of an axisymmetric dumbbell.
    slimness = 1e-9
    measured = libration_frequency((slimness, 1, 1), tilt, component)
    assert abs(measured - expected) < 5e-9


# ---------------------------------------------------------------------- heavy top


def heavy_top():
    # Bruels, Cardona and Arnold (2012), as run in Kynema; moments about the pivot.
    body = pt.Body((15.234375, 0.46875, 15.234375))
    start = body.state(IDENTITY, omega_body=(0, 150, -4.61538))
    return pt.System(body, pt.UniformGravity(15 * 9.81, (0, 1, 0))), start


def test_heavy_top_of_bruels_cardona_and_arnold():
    # Their integrator is second order and damped, which leaves 1.3e-6 in both numbers.
    motion = pt.propagate(*heavy_top(), [2.0])
    displacement = motion.attitude.as_matrix()[0] @ [0, 1, 0] - [0, 1, 0]
    assert largest(displacement - [-0.150416985652933, -1.724164450779749, -0.673023460701136]) < 1.3e-6
    q = [0.122947275600560, -0.491079359219981, 0.350430794926147, -0.787986857972906]
    assert min(largest(motion.quaternion[0] - q), largest(motion.quaternion[0] + q)) < 1.3e-6


def test_initial_angular_acceleration_of_the_heavy_top():
    step = 1e-4
    motion = pt.propagate(*heavy_top(), step * np.array([-2, -1, 1, 2]))
    acceleration = np.array([1, -8, 8, -1]) @ motion.omega_body / (12 * step)
    assert largest(acceleration - [661.3461692307692, 0, 0]) < 1e-4
