"""The numbers on the axes of every plot are in the units of its labels.

The same motion is drawn by a system in kg, m and s and by one in g, cm and min: both pictures show the same quantity.
"""

import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import poinsot as pt

mpl.use("Agg")

IN_SI = {
    **{"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "yr": 31557600.0},
    **{"m": 1.0, "cm": 0.01, "kg": 1.0, "g": 1e-3, "N": 1.0, "J": 1.0},
    **{"rad": 1.0, "deg": np.pi / 180, "arcsec": np.pi / 648000, "rpm": np.pi / 30},
}
SYSTEMS = {"SI": (1.0, 1.0, 1.0), "cgs": (1e-3, 0.01, 60.0)}
"""Unit of mass in kg, of length in m and of time in s."""
UNITS = {
    "SI": {"time": "s", "inertia": "kg m2", "length": "m"},
    "cgs": {"time": "min", "inertia": "g cm2", "length": "cm"},
}
WEIGHT, DRAG = 2.5, 0.04  # N m, N m s
TIMES = np.linspace(0.0, 12.0, 61)  # s
PAIR = [(5e10, (300, 250, 200)), (1e9, (90, 80, 60))]
"""Masses in kg and semiaxes in m."""
NEAR = 1e-9
"""Both motions agree to 1e-12 of their largest numbers; a wrong unit is wrong by a factor of 2 or more."""


@pytest.fixture(autouse=True)
def no_figures():
    yield
    plt.close("all")


def falling(system):
    """A damped heavy top with a wheel."""
    mass, length, time = SYSTEMS[system]
    inertia = mass * length**2
    body = pt.Body(np.array([1.25, 1.0, 0.75]) / inertia)
    forces = (
        pt.UniformGravity(WEIGHT / (inertia / time**2), (1, 0, 0)),
        pt.forces.LinearDamping(DRAG / (inertia / time)),
        pt.parts.ReactionWheel((0, 0, 1), 0.1 / inertia),
    )
    units = {key: UNITS[system][key] for key in ("time", "inertia")}
    top = pt.System(body, *forces, units=units)
    start = top.state((0.5, 0.5, 0.5, 0.5), omega_body=np.array([0.3, 0.2, 1.5]) * time)
    return pt.propagate(top, start, TIMES / time)


def pair(system):
    """Two ellipsoids about each other."""
    mass, length, time = SYSTEMS[system]
    bodies = [pt.Body.from_ellipsoid(m / mass, np.array(sides) / length) for m, sides in PAIR]
    two = pt.TwoBodies(*bodies, G=6.6743e-11 * mass * time**2 / length**3)
    rates = np.array([(0, 0, 1e-3), (0, 0.2e-3, 0.5e-3)]) * time
    velocity = np.array([0, 0.08, 0]) * time / length
    start = two.state(np.array([900.0, 0, 0]) / length, velocity, [(1, 0, 0, 0)] * 2, omega_body=rates)
    moving = pt.System(two, pt.forces.MutualGravity(), units=UNITS[system])
    return pt.propagate(moving, start, np.linspace(0, 2e4, 41) / time)


def uncertainty(motion, system):
    """Draw the growth of an uncertainty of 1e-3 rad and of 1e-2 N m s."""
    mass, length, time = SYSTEMS[system]
    transition = pt.analysis.state_transition(motion.system, motion.initial, motion.times)
    count = len(transition.coordinates)
    start = np.diag([1e-3] * 3 + [1e-2 / (mass * length**2 / time)] * (count - 3)) ** 2
    return pt.plot.uncertainty(transition, start)


PLOTS = {
    "angular_momentum": lambda motion, _: pt.plot.angular_momentum(motion),
    "angular_velocity": lambda motion, _: pt.plot.angular_velocity(motion),
    "attitude_error": lambda motion, _: pt.plot.attitude_error(motion, (1, 0, 0, 0)),
    "euler_angles": lambda motion, _: pt.plot.euler_angles(motion),
    "part_variables": lambda motion, _: pt.plot.part_variables(motion),
    "polhode": lambda motion, _: pt.plot.polhode(motion),
    "quaternions": lambda motion, _: pt.plot.quaternions(motion),
    "torques": lambda motion, _: pt.plot.torques(motion),
    "uncertainty": uncertainty,
}
OF_PAIRS = {
    "angular_velocity": lambda motion: pt.plot.angular_velocity(motion),
    "distance": lambda motion: pt.plot.distance(motion),
    "librations": lambda motion: pt.plot.librations(motion),
    "mutual_orbit": lambda motion: pt.plot.mutual_orbit(motion),
}


def in_si(label):
    """Return the size in kg, m, s and rad of the unit at the end of a label, such as "[g cm² min⁻¹]"; 1 of none."""
    found = re.search(r"\[([^\]]*)\]$", label)
    if found is None:
        return 1.0
    size = 1.0
    for word in found[1].split():
        unit, power = re.fullmatch(r"([a-z]+)([⁻⁰-⁹²³¹]*)", word, re.IGNORECASE).groups()
        size *= IN_SI[unit] ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 1)
    return size


def drawn(panels):
    """Return the coordinates of all lines in kg, m, s and rad."""
    found = []
    for panel in np.ravel(panels):
        labels = [getattr(panel, f"get_{axis}label")() for axis in "xyz" if hasattr(panel, f"get_{axis}label")]
        scales = [in_si(label) for label in labels]
        for line in panel.lines:
            values = getattr(line, "_verts3d", line.get_data())
            found.append(np.array([s * np.asarray(v, float) for s, v in zip(scales, values, strict=True)]))
    return found


def assert_equal(one, other):
    assert len(one) == len(other) > 0
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=NEAR * np.nanmax(np.abs(a)))


@pytest.mark.parametrize("name", PLOTS)
def test_one_body_has_one_picture_in_all_units(name):
    one, other = (drawn(PLOTS[name](falling(system), system)) for system in SYSTEMS)
    assert_equal(one, other)


@pytest.mark.parametrize("name", OF_PAIRS)
def test_two_bodies_have_one_picture_in_all_units(name):
    one, other = (drawn(OF_PAIRS[name](pair(system))) for system in SYSTEMS)
    assert_equal(one, other)


def test_labels_in_kilograms_metres_and_seconds_are_in_newtons():
    motion = falling("SI")
    labels = {
        "angular_momentum": "angular momentum, body axes [N m s]",
        "torques": "torque [N m]",
        "part_variables": "variables of reaction_wheel [N m s]",
    }
    for name, label in labels.items():
        assert np.ravel(PLOTS[name](motion, "SI"))[0].get_ylabel() == label
    sizes = np.linalg.norm(motion.torques_body["UniformGravity"], axis=-1)
    [gravity, _] = PLOTS["torques"](motion, "SI").lines
    np.testing.assert_allclose(gravity.get_ydata(), sizes, rtol=1e-15)
