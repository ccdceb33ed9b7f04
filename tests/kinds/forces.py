"""Every force on one body that is shipped, in the field of an ellipse or of a body at rest."""

import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces.gravity import Oblateness

ELLIPSE = pt.KeplerOrbit(
    1.1,
    semimajor_axis=1.3,
    eccentricity=0.3,
    inclination=0.7,
    node=-0.4,
    argument_of_periapsis=1.9,
    true_anomaly=0.3,
    epoch=0.2,
)
AT_REST = pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7))
AT_REST_BESIDE = pt.orbits.FixedPosition(0.9, position=(-0.9, 0.3, 0.4))
COSINES = [(0, 0, 0, 0), (0, 0, 0, 0), (-0.3, 0.05, 0.1, 0), (0.2, 0.1, -0.05, 0.08)]
SINES = [(0, 0, 0, 0), (0, 0, 0, 0), (0, -0.1, 0.15, 0), (0, 0.3, 0.04, -0.06)]
FIELD = pt.GravityField(3, 1.1, 0.8, COSINES, SINES)
POLE = {"right_ascension_rate": 0.1, "declination_rate": -0.08, "acceleration": 0.05}
AXES = pt.orbits.RotationModel(0.7, 0.4, -0.3, rate=0.6, epoch=0.1, **POLE)
GAUSS = np.array([(0, 0, 0), (-1.6, 0.7, 0), (0.8, -0.9, 0.5)]), np.array([(0, 0, 0), (0, 1.1, 0), (0, -0.6, 0.9)])
DIPOLE = pt.forces.TiltedDipole(ELLIPSE, AXES, -3.0, 1.1, 1.9, 0.6)
MAGNETIC_FIELDS = (
    DIPOLE,
    pt.forces.MagneticHarmonics(ELLIPSE, AXES, 2, 0.7, *GAUSS),
    pt.forces.SecularHarmonics(ELLIPSE, AXES, 2, 0.7, *GAUSS, 0.3 * GAUSS[0], -0.4 * GAUSS[1], epoch=0.2),
)
TENSOR = np.array([(0.3, 0.05, -0.1), (0.05, 0.2, 0.04), (-0.1, 0.04, 0.4)])
DIRECTIONAL = pt.forces.DirectionalTorque(
    1, [(0.1, -0.2, 0.3, 0.15), (-0.1, 0.25, 0.05, -0.3), (0.2, 0.1, -0.15, 0.05)], 0.02, 0.01
)


def facets(*normals):
    """Facets that the light or the air reaches in the motions below."""
    places = [(0.2, 0.7, -0.3), (0.4, -0.5, 0.6)]
    shares = {"specular": [0.3, 0.2], "diffuse": [0.2, 0.4], "drag": [2.2, 1.9], "accommodation": [0.7, 0.5]}
    return pt.forces.Facets([1.3, 0.8], np.array(normals) / 3**0.5, places, **shares)


SUN = pt.orbits.FixedPosition(0.9, position=(-3.0, 0.4, 0.9))
AIR = pt.forces.ExponentialAtmosphere(0.8, 1.1, 0.7, omega_space=(0.1, -0.2, 0.3))
FORCES = (
    pt.UniformGravity(0.7, (0.3, -0.2, 0.5)),
    pt.GravityGradient(ELLIPSE),
    pt.GravityGradient(AT_REST),
    Oblateness(ELLIPSE, 0.3, 0.7, (0.4, -0.3, 0.8)),
    Oblateness(AT_REST, 0.3, 0.7, (0.4, -0.3, 0.8)),
    pt.forces.HarmonicGravity(ELLIPSE, FIELD),
    pt.forces.HarmonicGravity(AT_REST, FIELD),
    pt.forces.MasconGravity(AT_REST, (0.6, 0.7), [(0.5, -0.3, 0.2), (-0.3, 0.4, -0.5)]),
    pt.forces.EllipsoidGravity(AT_REST, 1.1, (0.9, 0.6, 0.4)),
    pt.forces.LinearDamping(0.05),
    pt.forces.TidalTorque(ELLIPSE, 0.6, 0.9, 0.5, 1.3),
    *(pt.forces.MagneticMoment((0.5, -0.3, 0.7), field) for field in MAGNETIC_FIELDS),
    pt.forces.EddyCurrents(4 * TENSOR, DIPOLE),
    pt.forces.BDot(0.8, DIPOLE, 0.4),
    pt.forces.MeshDrag(ELLIPSE, AIR, DIRECTIONAL, 1.9),
    pt.forces.MeshRadiation(ELLIPSE, DIRECTIONAL, (), 0.7, 1.1, 0.1),
    pt.forces.Yorp(ELLIPSE, DIRECTIONAL, (), 0.7, 1.1, 0.1),
    pt.forces.AtmosphericDrag(ELLIPSE, AIR, facets((-1, 1, -1), (1, 1, -1))),
    pt.forces.RadiationPressure(ELLIPSE, facets((1, 1, 1), (-1, -1, 1)), pressure=1.4, distance=1.2, sun_radius=0.2),
    pt.forces.RadiationPressure(
        SUN,
        facets((1, 1, 1), (-1, -1, 1)),
        [pt.forces.Occulter(AT_REST_BESIDE, 0.2)],
        pressure=1.8,
        distance=3.3,
        sun_radius=0.6,
    ),
)
POTENTIALS = tuple(force for force in FORCES if isinstance(force, pt.Potential))
BODIES = (
    pt.Body((1.3, 1.0, 0.7)),
    pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)]),
)
TIME = 0.9


def label(thing):
    return " ".join(type(part).__name__ for part in (thing, *thing.records))


def random_attitudes(count=4):
    half_turns = np.eye(4)[1:]
    return np.concatenate([Rotation.random(count, np.random.default_rng(11)).as_quat(scalar_first=True), half_turns])
