"""Light and air in scenarios, in both kernels, in ensembles through eclipses, and with events."""

import numpy as np
import pytest

import poinsot as pt
from poinsot.forces import (
    AtmosphericDrag,
    DirectionalTorque,
    ExponentialAtmosphere,
    Facets,
    MeshRadiation,
    Occulter,
    RadiationPressure,
)
from poinsot.systems.named_parameters import NamedNumber

EARTH = pt.KeplerOrbit(3.986004418e14, semimajor_axis=6.9e6, eccentricity=0.01, inclination=0.5, node=0.2)
SUN = pt.orbits.FixedPosition(1.32712440018e20, position=(-1.2e11, 0.8e11, -0.3e11))
BODY = pt.Body((0.02, 0.03, 0.035))
BOX = Facets.from_box((0.1, 0.2, 0.3), (0.01, -0.02, 0.015), specular=0.2, diffuse=0.1)
AIR = ExponentialAtmosphere(3.7e-12, 6.778e6, 5.8e4, omega_space=(0, 0, 7.2921159e-5))
LIGHT = RadiationPressure(SUN, BOX, [Occulter(EARTH, 6.378137e6)])
SYSTEM = pt.System(BODY, AtmosphericDrag(EARTH, AIR, BOX), LIGHT)
TIMES = np.linspace(0, 5700, 8)


def start(shift=0.0):
    omega = np.array([0.002, -0.003, 0.001])
    return SYSTEM.state((0.5, 0.5, -0.5, 0.5), omega_body=omega + np.multiply.outer(shift, (1e-5, 0, 0)))


def test_both_precisions_agree_through_edges_and_an_eclipse():
    double, wide = (pt.propagate(SYSTEM, start(), TIMES, precision=name) for name in ("double", "quadruple"))
    assert np.max(np.abs(wide.quaternion - double.quaternion)) < 5e-14
    without = pt.System(BODY, SYSTEM.forces[0], RadiationPressure(SUN, BOX))
    lit = pt.propagate(without, start(), TIMES)
    assert np.max(np.abs(lit.quaternion - double.quaternion)) > 1e-3


def test_members_go_through_the_eclipse_as_one_does():
    shifts = np.linspace(0, 3, 5)
    every = pt.propagate(SYSTEM, start(shifts), TIMES)
    for i in (0, 2, 4):
        alone = pt.propagate(SYSTEM, start(shifts[i]), TIMES)
        assert np.max(np.abs(every.quaternion[i] - alone.quaternion)) < 1e-11


def test_derivatives_by_a_number_go_through_edges_and_contacts():
    found = pt.analysis.state_transition(SYSTEM, start(), [4000.0], ["pressure", "reference_density"])
    for i, (name, value) in enumerate({"pressure": float(LIGHT.pressure), "reference_density": 3.7e-12}.items()):
        number, step = NamedNumber(SYSTEM, name), 1e-3 * value
        after, before = (
            pt.propagate(number.system(value + x), start(), [4000.0]).angular_momentum_body[0] for x in (step, -step)
        )
        slope = (after - before) / (2 * step)
        # The square of a thousandth of the change, which turns the body by some radians: 1.3e-6 for the density.
        assert np.max(np.abs(found.sensitivity[0, 3:6, i] - slope)) < 4e-6 * np.max(np.abs(slope))


def test_derivatives_by_coefficients_of_a_smooth_field_go_through_an_eclipse():
    coefficients = 2e-3 * np.random.default_rng(4).normal(size=(3, 9))
    occulters = [Occulter(EARTH, 6.378137e6)]
    names = {"coefficients[0][0]": (0, 0), "coefficients[1][4]": (1, 4), "coefficients[2][7]": (2, 7)}

    def system(changed):
        return pt.System(BODY, MeshRadiation(SUN, DirectionalTorque(2, changed), occulters))

    found = pt.analysis.state_transition(system(coefficients), start(), [4000.0], list(names))
    for i, place in enumerate(names.values()):
        step = np.zeros((3, 9))
        step[place] = 2e-6
        ends = [pt.propagate(system(coefficients + s * step), start(), [4000.0]) for s in (1, -1)]
        slope = (ends[0].angular_momentum_body[0] - ends[1].angular_momentum_body[0]) / 4e-6
        # A thousandth of a coefficient: what is left out is its square.
        assert np.max(np.abs(found.sensitivity[0, 3:6, i] - slope)) < 1e-6 * np.max(np.abs(slope))


def test_derivatives_by_a_length_do_not_depend_on_its_unit():
    """A number that changes by a small part is not lost next to the attitude, where the light has edges."""

    def slope(unit):
        mu = 3.986004418e14 / unit**3
        earth = pt.KeplerOrbit(mu, semimajor_axis=6.9e6 / unit, eccentricity=0.01, inclination=0.5, node=0.2)
        light = RadiationPressure(SUN, BOX, [Occulter(earth, 6.378137e6 / unit)])
        system = pt.System(BODY, light)
        begin = system.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.002, -0.003, 0.001))
        return pt.analysis.state_transition(system, begin, [1300.0, 5700.0], ["semimajor_axis"]).sensitivity / unit

    small, large = slope(1e-3), slope(1e7)
    assert np.max(np.abs(small - large)) < 3e-12 * np.max(np.abs(large))


def test_an_event_sees_the_light():
    class Dusk(pt.Event):
        """Half of the Sun's disc is left."""

        level: float

        def value(self, instant):
            return LIGHT.sunlight(instant) - self.level

    motion = pt.propagate(SYSTEM, start(), TIMES, events=[Dusk(0.5)])
    times = motion.events[0].times
    assert len(times) == 2
    at = [SYSTEM.at(SYSTEM.state((1, 0, 0, 0), omega_body=(0, 0, 0), time=t)) for t in times]
    assert np.max(np.abs([float(LIGHT.sunlight(instant)) - 0.5 for instant in at])) < 1e-12


SCENARIO = """
[units]
time = "s"
inertia = "kg m2"

[body]
moments = [0.02, 0.03, 0.035]

[state]
quaternion = [0.5, 0.5, -0.5, 0.5]
omega_body = [0.002, -0.003, 0.001]

[[forces]]
type = "AtmosphericDrag"
orbit = "earth"

[forces.facets]
type = "Facets.from_box"
sides = [0.1, 0.2, 0.3]
position = [0.01, -0.02, 0.015]
specular = 0.2
diffuse = 0.1

[forces.atmosphere]
type = "ExponentialAtmosphere"
reference_density = 3.7e-12
reference_radius = 6.778e6
scale_height = 5.8e4
omega_space = [0, 0, 7.2921159e-5]

[[forces]]
type = "RadiationPressure"
sun = "sun"

[forces.facets]
type = "Facets.from_box"
sides = [0.1, 0.2, 0.3]
position = [0.01, -0.02, 0.015]
specular = 0.2
diffuse = 0.1

[[forces.occulters]]
orbit = "earth"
radius = 6.378137e6

[orbits.earth]
type = "KeplerOrbit"
mu = 3.986004418e14
semimajor_axis = 6.9e6
eccentricity = 0.01
inclination = 0.5
node = 0.2

[orbits.sun]
type = "FixedPosition"
mu = 1.32712440018e20
position = [-1.2e11, 0.8e11, -0.3e11]

[times]
stop = 5700
count = 8
"""


def test_a_scenario_is_the_same_motion(tmp_path):
    (tmp_path / "satellite.toml").write_text(SCENARIO)
    read = pt.files.read_scenario(tmp_path / "satellite.toml").propagate()
    assert np.array_equal(read.quaternion, pt.propagate(SYSTEM, start(), TIMES).quaternion)


@pytest.mark.parametrize(
    ("right", "wrong", "sentence"),
    [
        ("diffuse = 0.1", "diffuse = 0.9", "facets: specular|specular and diffuse must add up to at most 1, got 0.2"),
        ("radius = 6.378137e6", "radius = -1", r"forces\[1\].occulters\[0\].radius must be positive, got -1.0"),
        (
            'type = "ExponentialAtmosphere"',
            "",
            r"forces\[0\].atmosphere.type must be given, got none. Known types are .*Exponential",
        ),
        (
            "scale_height = 5.8e4",
            "scale_hight = 5.8e4",
            r"unknown key 'scale_hight' in \[forces\[0\]\.atmosphere\]\. Did you mean 'scale_height'\?",
        ),
    ],
)
def test_a_wrong_key_is_reported_with_its_place(tmp_path, right, wrong, sentence):
    (tmp_path / "wrong.toml").write_text(SCENARIO.replace(right, wrong))
    with pytest.raises(ValueError, match=sentence):
        pt.files.read_scenario(tmp_path / "wrong.toml")
