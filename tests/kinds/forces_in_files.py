"""Every force and control law with numbers that decimal fractions do not represent, and its way through text."""

import numpy as np

import poinsot as pt
from kinds.forces import MAGNETIC_FIELDS
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.scenario_of_motion import scenario_of
from poinsot.scenarios.system_text import rebuilt_system

ELLIPSE = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.3, inclination=0.7, node=-0.4, epoch=0.2)
ROCKS = [
    pt.shapes.Mascons([0.6, 0.7, size], [(0.5, -0.3, 0.2), (-0.3, 0.4, -0.5), (0.1, 0.5, 0.4)]) for size in (0.5, 0.3)
]
FIRST, SECOND = map(pt.Body.from_shape, ROCKS)
PAIR = pt.TwoBodies(FIRST, SECOND, G=1 / 3)
FIELD = ROCKS[0].field(3)
FACETS = pt.forces.Facets([1 / 3, 2.0], [(0, 0, 1), (0.6, 0, -0.8)], [(1 / 7, 0, 0), (0, 0.3, 0)], 0.1, [0.3, 0.2])
OF_ONE = (
    pt.UniformGravity(0.7, (0.3, -0.2, 0.5)),
    pt.GravityGradient(ELLIPSE),
    pt.forces.Oblateness(ELLIPSE, 0.3, 0.7, (0.4, -0.3, 0.8)),
    pt.forces.HarmonicGravity(ELLIPSE, FIELD),
    pt.forces.MasconGravity(ELLIPSE, ROCKS[0].masses, ROCKS[0].positions),
    pt.forces.EllipsoidGravity(ELLIPSE, 1.1, (0.9, 0.6, 0.4)),
    pt.forces.LinearDamping(1 / 7),
    pt.forces.TidalTorque(ELLIPSE, 0.6, 0.9, 0.5),
    *(pt.forces.MagneticMoment((0.5, -0.3, 0.7), field) for field in MAGNETIC_FIELDS),
    pt.forces.EddyCurrents(0.4, MAGNETIC_FIELDS[0]),
    pt.forces.BDot(0.3, MAGNETIC_FIELDS[0], 0.2),
    pt.forces.MeshRadiation(
        ELLIPSE,
        pt.forces.DirectionalTorque(1, np.full((3, 4), 1 / 7), 0.3, 0.1),
        [pt.forces.Occulter(ELLIPSE, 1 / 3)],
        sun_radius=0.1,
    ),
    pt.forces.MeshDrag(
        ELLIPSE,
        pt.forces.ExponentialAtmosphere(1 / 3, 1.1, 0.7),
        pt.forces.DirectionalTorque(1, np.full((3, 4), 1 / 7)),
        1 / 3,
    ),
    pt.forces.Yorp(ELLIPSE, pt.forces.DirectionalTorque(6, np.full((3, 49), 1 / 3)), sun_radius=0.1),
    pt.forces.AtmosphericDrag(
        ELLIPSE, pt.forces.ExponentialAtmosphere(1 / 3, 1.1, 0.7, omega_space=(0, 0, 0.1)), FACETS
    ),
    pt.forces.RadiationPressure(ELLIPSE, FACETS, sun_radius=0.1),
    pt.forces.RadiationPressure(ELLIPSE, FACETS, [pt.forces.Occulter(ELLIPSE, 1 / 3)] * 2, sun_radius=0.1),
    pt.control.QuaternionFeedback(0.6, 4.0, 0.05, (0.6, 0.0, 0.8, 0.0)),
    pt.control.OrbitPointing(0.6, 4.0, 0.05, ELLIPSE),
    pt.control.RateDamping(0.4, 0.1),
)
OF_TWO = (
    pt.forces.MutualGravity(),
    pt.forces.MutualHarmonics(FIELD, ROCKS[1].field(3), degree=3),
    pt.forces.MutualMascons.of_shapes(PAIR),
    pt.forces.ThirdBody(ELLIPSE),
    pt.forces.TidalFriction("primary", 0.3, 1.4, 0.2),
    pt.forces.LibrationDamping("secondary", 2e-3),
)
RUN = pt.free_motion(FIRST, FIRST.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0]).run


def label(force):
    return repr(force).partition("(")[0]


def comes_back(body, force) -> bool:
    """Whether a system comes back from its own text with the same formulas and the same numbers, to the bit."""
    system = pt.System(body, force)
    motion = pt.Trajectory(system, FIRST.state((1, 0, 0, 0), omega_body=(0, 0, 1)), np.zeros(1), MotionRows({}), RUN)
    text = scenario_of(motion.system, motion.run)
    again = rebuilt_system(text.text, "it", data=text.data)
    here, there = system.dynamics, again.dynamics
    same = [own.tobytes() == other.tobytes() for own, other in zip(here.numbers, there.numbers, strict=True)]
    return all(same) and there.structure == here.structure and type(again) is type(system)
