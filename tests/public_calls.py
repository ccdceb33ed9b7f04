"""One valid call of everything public that takes arguments, for the laws about arguments."""

import functools
import inspect

import numpy as np
import spiceypy as spice

import poinsot as pt

BODY = pt.Body((1.25, 1.0, 0.75))
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.3, node=0.2, argument_of_periapsis=0.1)
ELLIPSE = pt.KeplerOrbit(
    2.0,
    semimajor_axis=1.5,
    eccentricity=0.3,
    inclination=0.4,
    node=1.1,
    argument_of_periapsis=-0.7,
    true_anomaly=2.0,
    epoch=0.25,
)
ESCAPE = pt.orbits.EscapeOrbit(
    2.0, periapsis_distance=1.5, eccentricity=1.3, inclination=0.4, node=1.1, argument_of_periapsis=-0.7
)
ESTIMATE_OF = {"members": 1000, "bytes": 5_600_000, "memory": 2**34, "threads": 2, "seconds": 1.5}
PRECESSING = pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=-0.001)
TOP = pt.System(BODY, pt.UniformGravity(0.5, (1.0, 0.2, -0.3)), units={"time": "s"})
SATELLITE = pt.System(pt.Body((1.0, 1.3, 1.6)), pt.GravityGradient(CIRCLE), units={"time": "s"})
START = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))
TIMES = np.linspace(0.0, 2.0, 9)
ESTIMATE = pt.analysis.RunEstimate(TOP, times=TIMES, compilation=0.2, sampled=32, **ESTIMATE_OF)
CALENDAR = pt.Calendar("2026-11-21T00:00:00", "TAI")
J2000 = pt.Calendar("2000-01-01T12:00:00", "TDB")
NAMED = {"calendar": CALENDAR, "reference_frame": "ICRF", "body_frame": "SC_BODY_1", "overwrite": True}
VANGUARD = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)
CORNERS = ((0.0, 0, 0), (1.5, 0.2, 0), (0.1, 1.2, -0.1), (0.3, 0.4, 1.1))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
SIGNAL = np.sin(0.7 * np.arange(256))
COEFFICIENTS = {"specular": 0.2, "diffuse": 0.3, "drag": 2.1, "accommodation": 0.9}
TURNING = pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0.1))

SPACES = (pt, pt.analysis, pt.events, pt.files, pt.forces, pt.mechanics, pt.orbits, pt.shapes)
PUBLIC = {
    name: thing for space in SPACES for name in space.__all__ if not inspect.ismodule(thing := getattr(space, name))
}
"""Everything public by its name, but for the pictures."""

INTERNAL = {
    *(
        "unchecked",
        "with_axes",
        "with_numbers",
        "number_names",
        "between_knots",
        "check",
        "validity",
    ),  # the records' own business
    *("energy", "torque", "value", "condition", "act", "density", "relative_velocity", "sunlight"),  # formulas
    *("to_body", "to_space", "in_space", "from_quaternion"),
    *("from_unit_quaternion", "kinetics", "place", "slope", "distance", "row", "torque_at"),
    *("variables_at", "sniff"),
    *(
        "potential_at",
        "at",
        "given_parts",
        "attracted_moment",
        "inertia",
        "internal_energy",
        "momentum",
        "own",
        "start",
        "spinning_inertia",
        "rates",
        "with_records",
        "position",
        "velocity",
        "direction",
        "inverse_distance",
        "converted",
        "anomaly",
        "scaled",
        "sniff",
    ),
    *("seen_from", "power", "with_attitude", "with_separation", "on", "load", "truncation", "check_start"),
    *("try_event", "numbered", "variables"),
    *("from_msis",),  # its package is not among those of the tests
    *("turned", "update", "in_body", "rate_in_body", "moment", "angles_at", "axes_at", "to_planet"),
    *("first", "falls_on", "limits"),
    *("reading", "unit", "check_values", "check_times", "time_of_body", "difference", "disturbed"),  # of observables
    *("covers", "hidden_at", "support", "with_observables"),
}
"""Methods that formulas and the package call, and not a user."""

NOT_CALLED = {
    *("Event", "Frame", "Jump", "Orbit", "Part", "Potential", "Shape", "Torque", "Attitude", "Environment", "Instant"),
    *("Atmosphere", "TabulatedAtmosphere"),
    *("AttitudeFormat", "BodyVector", "SpaceVector", "Vector", "functions", "plot"),
    *("Bifurcation", "Branch", "CassiniState", "ChaosIndicators", "EventRecord", "Ephemeris", "Equilibrium"),
    "LineIdentification",
    *("LineSpectrum", "LyapunovSpectrum", "PeriodicMotion", "PropagationError", "PropagationInterrupted"),
    *("Scenario", "SecularEvolution", "Section", "StateTransition", "Trajectory", "YorpCoefficients"),
    *("RunEstimate", "Observable", "ObservedPartials"),
    *("Librations", "Load", "OsculatingElements", "PairEquilibrium", "PairInstant", "PairLoad", "Revolutions"),
}
"""Base classes, what formulas see, and results, which the package makes."""


def energy_of(motion):
    return motion.period


def where(points):
    return points.omega_body[:, 0], points.omega_body[:, 1]


def along(times):
    return np.stack(ELLIPSE.position_at(times), axis=-1)


@functools.cache
def motion():
    return pt.propagate(TOP, START, TIMES, dense=True, events=[pt.events.SpinFlip((1, 0, 0))])


class Speed(pt.Observable):
    def reading(self, instant):
        return pt.functions.norm(instant.omega_body)


@functools.cache
def light_curve():
    ball, law = pt.shapes.Ellipsoid((1.0, 0.9, 0.7), mass=50.0), pt.observables.Lambert(0.2)
    return pt.observables.LightCurve(ball, law, sun=ELLIPSE, observer=CIRCLE, kind="relative", light_time=False)


@functools.cache
def read():
    return pt.observe(motion(), Speed())


@functools.cache
def ensemble():
    return pt.propagate(TOP, BODY.state([START.quaternion] * 3, omega_body=np.eye(3)), TIMES)


@functools.cache
def free():
    return pt.free_motion(BODY, START, TIMES)


@functools.cache
def pair_motion():
    bodies = (pt.Body.from_ellipsoid(50.0, (1.0, 0.9, 0.7)), pt.Body.from_ellipsoid(2.0, (0.5, 0.4, 0.3)))
    pair = pt.TwoBodies(*bodies, G=1.0)
    system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "inertia": "kg m2", "length": "m"})
    start = pair.kick(pair.synchronous(distance=4.0, primary_rate=2.0), (0.0, -0.3, 0.1))
    return pt.propagate(system, start, TIMES, dense=True)


def pair_calls():
    """Return those of two bodies."""
    bodies = [pt.shapes.Ellipsoid((1.0, 0.9, 0.7), mass=50.0), pt.shapes.Ellipsoid((0.5, 0.4, 0.3), mass=2.0)]
    shaped = pt.TwoBodies(*map(pt.Body.from_shape, bodies), G=1.0)
    points = [pt.shapes.Mascons((1.0,) * 4, CORNERS) for _ in range(2)]
    masses = pt.TwoBodies(*map(pt.Body.from_shape, points), G=1.0)
    start = {"position": (4.0, 0.1, 0.2), "velocity": (0.1, 3.0, 0.2), "attitudes": [(1.0, 0, 0, 0), (0, 1.0, 0, 0)]}
    spins, orbit = [(0.1, 0.2, 0.3), (0.3, 0.2, 0.1)], pt.KeplerOrbit(52.0, semimajor_axis=4.0, eccentricity=0.1)
    synchronous = shaped.synchronous(distance=4.0, primary_rate=2.0)
    watched = {"direction": 1, "terminal": False}
    moved = {"motion": pt.propagate(pair_motion().system, pair_motion().initial, np.linspace(0, 60, 601))}
    fields = {"primary": bodies[0].field(4), "secondary": bodies[1].field(4)}
    place, each = {"position": (4.0, 0, 0), "momentum": (0, 1.0, 0)}, ("primary", "secondary")
    system = pair_motion().system
    return {
        "System.force_space": (system.force_space, {"state": pair_motion().initial, "body": "primary"}),
        "System.forces_space": (system.forces_space, {"state": pair_motion().initial, "body": "primary"}),
        "PairState": (pt.PairState, place | {name: getattr(synchronous, name) for name in each}),
        "TwoBodies": (
            pt.TwoBodies,
            {"primary": shaped.primary, "secondary": shaped.secondary, "G": 1.0, "masses": (50.0, 2.0)},
        ),
        "TwoBodies.state": (shaped.state, {**start, "omega_body": spins, "time": 1.0, "frame": TURNING}),
        "TwoBodies.state_on": (
            shaped.state_on,
            {"orbit": orbit, "attitudes": start["attitudes"], "omega_body": spins, "time": 1.0, "frame": TURNING},
        ),
        "TwoBodies.synchronous": (shaped.synchronous, {"primary_rate": 2.0, "distance": 4.0, "time": 1.0}),
        "TwoBodies.doubly_synchronous": (shaped.doubly_synchronous, {"distance": 4.0, "time": 1.0}),
        "TwoBodies.kick": (
            shaped.kick,
            {"state": synchronous, "delta_velocity": (0.1, 0.2, 0), "body": "primary", "frame": TURNING},
        ),
        "MutualGravity": (pt.forces.MutualGravity, {}),
        "MutualHarmonics": (pt.forces.MutualHarmonics, {**fields, "degree": 4}),
        "MutualHarmonics.of_shapes": (pt.forces.MutualHarmonics.of_shapes, {"pair": shaped, "degree": 4}),
        "MutualMascons": (
            pt.forces.MutualMascons,
            {
                "primary_masses": (1.0, 1.0),
                "primary_positions": ((1.0, 0, 0), (-1.0, 0, 0)),
                "secondary_masses": (1.0, 1.0),
                "secondary_positions": ((0, 1.0, 0), (0, -1.0, 0)),
            },
        ),
        "MutualMascons.of_shapes": (pt.forces.MutualMascons.of_shapes, {"pair": masses}),
        "ThirdBody": (pt.forces.ThirdBody, {"orbit": ELLIPSE}),
        "TidalFriction": (
            pt.forces.TidalFriction,
            {"body": "primary", "love_number": 0.1, "radius": 1.0, "time_lag": 0.1},
        ),
        "LibrationDamping": (pt.forces.LibrationDamping, {"body": "secondary", "coefficient": 0.1}),
        "Contact": (pt.events.Contact, {"primary": (1.0, 0.9, 0.7), "secondary": (0.5, 0.4, 0.3), **watched}),
        "Contact.of_shapes": (pt.events.Contact.of_shapes, {"pair": shaped}),
        "DistanceCrossing": (pt.events.DistanceCrossing, {"distance": 3.0, **watched}),
        "PairApsis": (pt.events.PairApsis, watched),
        "LibrationExtreme": (pt.events.LibrationExtreme, {"body": "secondary", **watched}),
        "Impact": (
            pt.events.Impact,
            {"time": 1.0, "delta_velocity": (0, 0.1, 0), "body": "primary", "axes": "orbit", "direction": 1},
        ),
        "apsidal_precession": (pt.analysis.apsidal_precession, moved),
        "librations": (pt.analysis.librations, {**moved, "body": "primary"}),
        "revolutions": (pt.analysis.revolutions, moved),
        "PairEquilibrium.displaced": (
            pt.analysis.pair_equilibria(pt.System(shaped, pt.forces.MutualGravity()), synchronous)[0].displaced,
            {"number": 2, "amplitude": 0.01},
        ),
        "pair_equilibria": (
            pt.analysis.pair_equilibria,
            {"system": pt.System(shaped, pt.forces.MutualGravity()), "guess": synchronous, "distances": [4.0, 3.9]},
        ),
        "osculating_elements": (
            pt.orbits.osculating_elements,
            {"mu": 2.0, "position": (1.0, 0.2, 0.1), "velocity": (0.1, 1.0, 0.2)},
        ),
    }


def turning_faster(state):
    return {"rate": 0.1 * state["rate"]}


def never(state):
    return state["rate"]


def light_calls():
    """Return those of light on meshes."""
    mesh, shadows = pt.shapes.Mesh(CORNERS, FACES, mass=2.0), {"shadows": False}
    field = {"degree": 1, "coefficients": np.full((3, 4), 0.1), "maximum_error": 0.1, "rms_error": 0.1}
    sun = {
        "sun": ELLIPSE,
        "pressure": 0.2,
        "distance": 1.5,
        "sun_radius": 0.1,
        "occulters": [pt.forces.Occulter(CIRCLE, 0.1)],
    }
    lit = {"mesh": mesh, "directions": (1.0, 0.2, 0.1), "to_observer": (0.3, 1.0, 0.1)}
    means = pt.analysis.yorp_coefficients(mesh, np.linspace(0, np.pi, 9))
    return {
        "DirectionalTorque": (pt.forces.DirectionalTorque, field),
        "DirectionalTorque.of_emission": (
            pt.forces.DirectionalTorque.of_emission,
            {"mesh": mesh, "degree": 1} | shadows,
        ),
        "DirectionalTorque.of_stream": (
            pt.forces.DirectionalTorque.of_stream,
            {"mesh": mesh, "degree": 1, "specular": 0.1, "diffuse": 0.2, **shadows},
        ),
        "MeshDrag": (
            pt.forces.MeshDrag,
            {
                **{"orbit": ELLIPSE, "atmosphere": pt.forces.ExponentialAtmosphere(0.1, 1.0, 0.5)},
                **{"field": pt.forces.DirectionalTorque(**field), "coefficient": 2.0},
            },
        ),
        "MeshRadiation": (pt.forces.MeshRadiation, {**sun, "field": pt.forces.DirectionalTorque(**field)}),
        "Yorp": (pt.forces.Yorp, {**sun, "field": pt.forces.DirectionalTorque(**field)}),
        "Yorp.from_mesh": (pt.forces.Yorp.from_mesh, {**sun, "mesh": mesh, "degree": 1, **shadows}),
        "YorpCoefficients.with_lag": (means.with_lag, {"thermal_parameter": 0.3, "albedo": 0.1}),
        "YorpCoefficients.drift": (means.drift, {"pressure": 0.2, "moment_of_inertia": 2.0}),
        "secular_evolution": (
            pt.analysis.secular_evolution,
            {"effects": [turning_faster], "start": {"rate": 1.0}, "times": TIMES, "until": never},
        ),
        "yorp_coefficients": (
            pt.analysis.yorp_coefficients,
            {"surface": mesh, "obliquities": [0.1, 0.2], "axis": (0, 0.1, 1.0), **shadows},
        ),
        "plot.yorp": (pt.plot.yorp, {"coefficients": means, "ax": None, "angle_unit": "deg", "title": "t"}),
        "illuminated_areas": (pt.shapes.illuminated_areas, lit),
        "illuminated_faces": (pt.shapes.illuminated_faces, lit | shadows),
    }


def field_calls():
    """Return those of planet-fixed axes, magnetic fields, tides and relaxation."""
    angles = {"right_ascension": 0.1, "declination": 1.2, "prime_meridian": 0.3}
    rates = {"right_ascension_rate": 1e-9, "declination_rate": 1e-9, "rate": 0.1, "acceleration": 1e-9, "epoch": 0.5}
    axes = pt.orbits.RotationModel(**angles, rate=0.1)
    dipole = {"orbit": ELLIPSE, "rotation": axes, "g10": -3e-5, "g11": 1e-6, "h11": 2e-6, "radius": 0.5}
    harmonics = {"orbit": ELLIPSE, "rotation": axes, "degree": 1, "radius": 0.5}
    harmonics |= {"g": [(0, 0), (3e-5, 1e-5)], "h": np.zeros((2, 2))}
    magnet = pt.forces.TiltedDipole(**dipole)
    rock = pt.Body.from_ellipsoid(8e11, (600.0, 500.0, 400.0))
    elastic = {"body": rock, "rigidity": 1e9, "quality_factor": 100.0, "poisson_ratio": 0.3}
    dated = pt.orbits.RotationModel.iau("earth", calendar=CALENDAR)
    return {
        "BDot": (pt.forces.BDot, {"gain": 0.3, "field": magnet, "limit": 0.1}),
        "EddyCurrents": (pt.forces.EddyCurrents, {"tensor": 0.2, "field": magnet}),
        "IGRF": (pt.forces.IGRF, {"orbit": ELLIPSE, "rotation": dated, "degree": 2, "radius": 0.5}),
        "InelasticRelaxation": (pt.analysis.InelasticRelaxation, elastic),
        "InelasticRelaxation.damping_time": (pt.analysis.InelasticRelaxation(**elastic).damping_time, {"rate": 0.1}),
        "MagneticField": (pt.forces.TiltedDipole, dipole),
        "MagneticHarmonics": (pt.forces.MagneticHarmonics, harmonics),
        "MagneticMoment": (pt.forces.MagneticMoment, {"moment": (0.1, 0.2, 0.3), "field": magnet}),
        "NutatingRotation": (
            pt.orbits.NutatingRotation,
            {**angles, **rates, "terms": 1, "periodic": [(1e-3, 1e-3, 1e-3, 0.1, 0.2)]},
        ),
        "RotationModel": (pt.orbits.RotationModel, {**angles, **rates, "reference_frame": "ICRF"}),
        "RotationModel.earth": (
            pt.orbits.RotationModel.earth,
            {"calendar": CALENDAR, "ut1_minus_utc": 0.1, "reference_frame": "ICRF"},
        ),
        "RotationModel.from_pole": (
            pt.orbits.RotationModel.from_pole,
            {
                **{"longitude": 0.1, "latitude": 1.2, "period": 3.0, "angle": 0.3, "epoch": 0.5},
                **{"axes": "ecliptic", "calendar": CALENDAR},
            },
        ),
        "RotationModel.iau": (pt.orbits.RotationModel.iau, {"body": "mars", "calendar": CALENDAR}),
        "RotationModel.omega_space": (axes.omega_space, {"time": 1.0}),
        "RotationModel.quaternion": (axes.quaternion, {"time": 1.0}),
        "SecularHarmonics": (
            pt.forces.SecularHarmonics,
            {**harmonics, "g_rate": np.zeros((2, 2)), "h_rate": np.zeros((2, 2)), "epoch": 0.5},
        ),
        "TidalTorque": (
            pt.forces.TidalTorque,
            {"orbit": ELLIPSE, "love_number": 0.3, "radius": 0.5, "time_lag": 0.1, "G": 1.0},
        ),
        "TiltedDipole": (pt.forces.TiltedDipole, dipole),
        "kilometres_to_metres": (pt.orbits.kilometres_to_metres, {"orbit": ephemeris()}),
        "pseudo_synchronous_rate": (pt.forces.pseudo_synchronous_rate, {"eccentricity": 0.2}),
    }


@functools.cache
def ground_station():
    rotation = pt.orbits.RotationModel(0.1, 1.2, 0.3, rate=0.5)
    return pt.orbits.GroundStation(ELLIPSE, rotation, latitude=0.3, longitude=0.2, equatorial_radius=0.5)


def along_orbit():
    start = SATELLITE.body.state((0.5, -0.5, -0.5, 0.5), omega_body=(0.1, 0.2, 0), frame=CIRCLE.frame)
    return pt.propagate(SATELLITE, start, TIMES)


@functools.cache
def damped():
    system = pt.System(BODY, pt.parts.KaneDamper(0.1, 0.05), units={"time": "s"})
    return pt.propagate(system, system.state(START.quaternion, omega_body=(0.4, -0.3, 0.6)), TIMES)


@functools.cache
def periodic():
    start = SATELLITE.body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=CIRCLE.frame)
    return pt.analysis.periodic_motion(SATELLITE, start, 0.2 * float(CIRCLE.period), CIRCLE.frame)


@functools.cache
def branch():
    return pt.analysis.continue_motion(periodic(), "moments[0]", 1.02)


@functools.cache
def ephemeris():
    return pt.orbits.Ephemeris.from_function(2.0, position=along, start=0.0, stop=3.0, calendar=CALENDAR)


@functools.cache
def indicators():
    return pt.analysis.chaos_indicators(TOP, START, [1.0])


@functools.cache
def transition():
    return pt.analysis.state_transition(TOP, START, [1.0], ("weight",))


@functools.cache
def table():
    return pt.files.AttitudeTable(motion().times, motion().attitude.as_quat(scalar_first=True), motion().omega_body)


@functools.cache
def plate():
    return pt.forces.Facets((1.0,), ((0, 0, 1),), ((0.1, 0, 0),))


def field():
    return pt.shapes.Ellipsoid((3, 2, 1), mass=2.0).field(2)


ELLIPSOID = pt.shapes.Ellipsoid((9.0, 6.0, 5.0), density=1.0)
FAR = pt.orbits.FixedPosition(1.0, position=(1.5e8, 0, 0))
LIGHT = pt.observables.LightCurve(ELLIPSOID, pt.observables.Lambert(0.2), FAR, FAR, kind="magnitude", light_time=False)
DAYS = pt.Calendar("2012-10-10T00:00:00", "TDB", "d")
NIGHT = pt.observables.Readings(
    LIGHT, [0.0, 0.1, 0.2], [12.0, 12.5, 12.2], 0.01, calendar=DAYS, attributes={"units": "mag"}
)


def files(folder):
    """Write a file of each kind into a folder and return its path."""
    at = {"motion": motion(), "calendar": CALENDAR, "reference_frame": "ICRF"}
    named = {**at, "overwrite": True}
    return {
        "aem": pt.files.write_aem(path=folder / "m.aem", **named),
        "apm": pt.files.write_apm(
            BODY, START, folder / "m.apm", calendar=CALENDAR, reference_frame="ICRF", overwrite=True
        ),
        "csv": pt.files.write_quaternion_csv(path=folder / "m.csv", **named),
        "stk": pt.files.write_stk_attitude(path=folder / "m.a", **named),
        "nc": pt.save(motion(), folder / "m.nc", overwrite=True),
        "ck": pt.files.write_ck(path=folder / "m.bc", **named),
        "toml": text(folder / "top.toml", SCENARIO),
        "obj": text(
            folder / "m.obj",
            "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
            + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES),
        ),
        "field": text(folder / "g.tab", FIELD),
        "gyro": text(folder / "gyro.csv", GYRO),
        "cuts": text(folder / "cuts.csv", "file,cut_start_s,cut_end_s,keep\ngyro,-1e9,1e9,\n"),
        "curves": text(folder / "lc.txt", CURVES),
        "readings": pt.files.write_readings(NIGHT, folder / "m.readings.nc", overwrite=True),
        "spin": text(folder / "spin.txt", SPIN),
        "alcdef": text(folder / "alcdef.txt", ALCDEF),
        "spk": kernel(folder / "m.bsp"),
        "oem": text(folder / "m.oem", OEM),
    }


def text(path, written):
    path.write_text(written)
    return path


def kernel(path):
    """Write a kernel of SPICE with the ellipse, of the body -999 from Ceres."""
    path.unlink(missing_ok=True)
    times = np.linspace(0.0, 3.0, 40)
    rows = np.stack([*ELLIPSE.position_at(times), *ELLIPSE.velocity_at(times)], axis=-1)
    handle = spice.spkopn(str(path), "a", 0)
    spice.spkw13(handle, -999, 2000001, "J2000", 0.0, 3.0, "a", 11, 40, np.ascontiguousarray(rows), times)
    spice.spkcls(handle)
    return path


SCENARIO = """
[body]
moments = [1.25, 1.0, 0.75]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0.1, 0.2, 0.3]
[times]
stop = 2.0
count = 5
[[observe]]
type = "Gyro"
noise = 0.1
"""
FIELD = (
    " 1.0E+00, 4.9E+03, 1.0E-04,     2,     2,     1, 0.0, 0.0\r\n"
    "    2,    0, -1.0E-03, 0.0, 0.0, 0.0\r\n    2,    1, 0.0, 0.0, 0.0, 0.0\r\n    2,    2, 1.0E-04, 0.0, 0.0, 0.0\r\n"
)
GYRO = "t_s,wx,wy,wz\n0.0,0.1,0.2,0.3\n0.01,0.1,0.2,0.31\n0.02,0.1,0.21,0.31\n"
CURVES = (
    "2\n3 0\n"
    "2433915.386 1.02 -1.492 -0.203 -0.256 -0.490 -0.156 -0.256\n"
    "2433915.401 1.01 -1.491 -0.204 -0.256 -0.490 -0.155 -0.256\n"
    "2433915.407 1.03 -1.490 -0.205 -0.256 -0.489 -0.155 -0.256\n"
    "1 1\n2434000.5 0.9 -1.5 -0.2 -0.3 -0.5 -0.1 -0.2\n"
)
SPIN = "251 -63 5.27\n2433827.771536 10\n0.5 0.1 -0.5\n0.1\n"
ALCDEF = """STARTMETADATA
OBJECTNUMBER=1
OBJECTNAME=Ceres
SESSIONDATE=2011-09-13
SESSIONTIME=07:46:00
LTCAPP=NONE
DELIMITER=PIPE
ENDMETADATA
DATA=2455817.735937|7.328|0.004
DATA=2455817.736235|7.317|0.004
ENDDATA
"""
OEM = """CCSDS_OEM_VERS = 2.0
CREATION_DATE = 2026-11-21T00:00:00
ORIGINATOR = X
META_START
OBJECT_NAME = A
OBJECT_ID = A
CENTER_NAME = EARTH
REF_FRAME = ICRF
TIME_SYSTEM = TAI
START_TIME = 2026-11-21T00:00:00
STOP_TIME = 2026-11-21T00:02:00
META_STOP
2026-11-21T00:00:00 9000.0 0.0 0.0 0.0 6.65 0.0
2026-11-21T00:01:00 8991.1404 398.8691 0.0 -0.2952 6.6434 0.0
2026-11-21T00:02:00 8964.5786 796.9528 0.0 -0.5899 6.6238 0.0
"""


def public_calls(folder):
    """Return, by name, a function and the arguments that it takes; files are written into the folder."""
    at, out = files(folder), {"motion": motion(), "path": folder / "out", **NAMED}
    elements = {"inclination": 0.4, "node": 1.1, "argument_of_periapsis": -0.7}
    passage = {"mu": 2.0, "position": (1.0, 0.2, 0.1), "velocity": (0.1, 1.0, 0.2), "epoch": 0.5, "radius": 0.1}
    mass_of = {"mass": 2.0}
    cone = {"axis": (1, 0, 0.5), "direction": 1, "terminal": False}
    run = {"formulation": "lie_poisson", "tolerance": 1e-12, "threads": 1, "progress": False}
    here = {"system": TOP, "state": START, "times": [1.0]}
    dates = {"start": "2000-06-27T19:00:00 UTC", "stop": "2000-06-27T20:00:00 UTC", "max_age": 20.0}
    kernels = list(at["ck"])
    drawn, seen = {"ax": None, "title": "t"}, {"sun": ELLIPSE, "observer": CIRCLE}
    shown = {**drawn, "time_unit": "s"}
    both = {"axes": None, "title": "t", "time_unit": "s"}
    turning = {"ax": None, "rate_unit": "deg/s", "time_unit": "s"}
    return {
        **pair_calls(),
        **light_calls(),
        **field_calls(),
        "Andoyer": (pt.Andoyer, {"l": 0.1, "g": 0.2, "h": 0.3, "L": 0.5, "G": 1.0, "H": 0.4}),
        "Andoyer.from_state": (pt.Andoyer.from_state, {"state": START}),
        "Andoyer.state": (pt.Andoyer(0.1, 0.2, 0.3, 0.5, 1.0, 0.4).state, {"time": 1.0}),
        "AndoyerCrossing": (
            pt.events.AndoyerCrossing,
            {"angle": 0.3, "pole": (0, 0, 1), "direction": 1, "terminal": False},
        ),
        "Apsis": (pt.events.Apsis, {"orbit": ELLIPSE, "direction": 1, "terminal": False}),
        "Assembly": (pt.shapes.Assembly, {"parts": [pt.shapes.Ellipsoid((3, 2, 1), mass=1.0)]}),
        "AttitudeTable": (
            pt.files.AttitudeTable,
            {
                "times": TIMES[:2],
                "quaternion": ((1, 0, 0, 0), (0, 1, 0, 0)),
                "omega_body": ((1, 0, 0), (0, 1, 0)),
                "calendar": CALENDAR,
                "reference_frame": "ICRF",
                "body_frame": "B",
                "norm_error": 0.0,
            },
        ),
        "AttitudeTable.angle_to": (table().angle_to, {"motion": motion()}),
        "AttitudeTable.state": (table().state, {"body": BODY, "row": 1}),
        "AttitudeTable.trajectory": (table().trajectory, {"system": TOP}),
        "AttractorCrossing": (pt.events.AttractorCrossing, {**cone, "orbit": ELLIPSE, "angle": 0.3}),
        "AxisCrossing": (pt.events.AxisCrossing, {**cone, "target": (0, 0, 1), "angle": 0.3}),
        "Body": (pt.Body, {"moments": (1.25, 1.0, 0.75)}),
        "Body.angular_momentum": (BODY.angular_momentum, {"omega_body": (0.1, 0.2, 0.3)}),
        "Body.from_box": (pt.Body.from_box, {"mass": 1.0, "sides": (1.0, 2.0, 3.0)}),
        "Body.from_cylinder": (pt.Body.from_cylinder, {"mass": 1.0, "radius": 1.0, "height": 2.0}),
        "Body.from_ellipsoid": (pt.Body.from_ellipsoid, {"mass": 1.0, "semiaxes": (1.0, 2.0, 3.0)}),
        "Body.from_inertia": (pt.Body.from_inertia, {"tensor": ((2.0, 0.1, 0), (0.1, 2.5, 0.2), (0, 0.2, 3.0))}),
        "Body.from_ratios": (pt.Body.from_ratios, {"alpha": 0.2, "beta": 0.3, "polar_moment": 2.0}),
        "Body.from_shape": (pt.Body.from_shape, {"shape": pt.shapes.Ellipsoid((3, 2, 1), mass=1.0)}),
        "Body.from_stokes": (
            pt.Body.from_stokes,
            {
                **{"C20": -0.05, "C22": 0.01, "polar_moment_factor": 0.4, "C21": 0.0, "S21": 0.0, "S22": 0.0},
                **{"mass": 1.0, "radius": 1.0},
            },
        ),
        "Body.kinetic_energy": (BODY.kinetic_energy, {"angular_momentum_body": (0.1, 0.2, 0.3)}),
        "Body.moment_about": (BODY.moment_about, {"direction_body": (1.0, 0, 0)}),
        "Body.omega": (BODY.omega, {"angular_momentum_body": (0.1, 0.2, 0.3)}),
        "Body.from_point_masses": (
            pt.Body.from_point_masses,
            {"masses": (1.0, 1.0, 1.0), "positions": ((1.0, 0, 0), (0, 1, 0), (0, 0, 1))},
        ),
        "System.state": (
            SATELLITE.state,
            {"attitude": (1.0, 0, 0, 0), "omega_body": (0.1, 0.2, 0.3), "time": 1.0, "frame": ELLIPSE.frame},
        ),
        "Body.state": (
            BODY.state,
            {"attitude": (1.0, 0, 0, 0), "omega_body": (0.1, 0.2, 0.3), "time": 1.0, "frame": ELLIPSE.frame},
        ),
        "Body.state space": (BODY.state, {"attitude": (1.0, 0, 0, 0), "omega_space": (0.1, 0.2, 0.3)}),
        "Body.state momentum": (BODY.state, {"attitude": (1.0, 0, 0, 0), "angular_momentum_body": (0.1, 0.2, 0.3)}),
        "Body.state momentum in space": (
            BODY.state,
            {"attitude": (1.0, 0, 0, 0), "angular_momentum_space": (0.1, 0.2, 0.3)},
        ),
        "Calendar": (pt.Calendar, {"zero": "2000-01-01T12:00:00", "scale": "TDB", "unit": "d"}),
        "Calendar.date": (CALENDAR.date, {"time": 10.0}),
        "Calendar.time": (CALENDAR.time, {"epoch": 10.0}),
        "EventRecord.member": (motion().events[0].member, {"member": 0}),
        "Cylinder": (pt.shapes.Cylinder, {"radius": 1.0, "height": 2.0, **mass_of}),
        "Ellipsoid": (pt.shapes.Ellipsoid, {"semiaxes": (3.0, 2, 1), **mass_of}),
        "Ellipsoid of density": (pt.shapes.Ellipsoid, {"semiaxes": (3.0, 2, 1), "density": 2.0}),
        "EllipsoidGravity": (pt.forces.EllipsoidGravity, {"orbit": ELLIPSE, "mass": 1.0, "semiaxes": (0.3, 0.2, 0.1)}),
        "Ephemeris.from_function": (
            pt.orbits.Ephemeris.from_function,
            {
                **{"mu": 2.0, "position": along, "start": 0.0, "stop": 3.0, "tolerance": 1e-10, "origin": "a"},
                **{"reference_frame": "ICRF", "calendar": CALENDAR, "radius": 0.1},
            },
        ),
        "Ephemeris.from_pieces": (
            pt.orbits.Ephemeris.from_pieces,
            {
                **{"mu": 2.0, "knots": (0.0, 1.0), "coefficients": (((2.0, 0.1), (0.0, 1.0), (0.0, 0.0)),)},
                **{"reference_frame": "ICRF", "origin": "Sun", "error": 1e-9, "radius": 0.1, "dated": True},
                "calendar": CALENDAR,
            },
        ),
        "Ephemeris.from_table": (
            pt.orbits.Ephemeris.from_table,
            {
                **{"mu": 2.0, "times": TIMES, "positions": along(TIMES), "reference_frame": "ICRF", "origin": "a"},
                **{"velocities": np.stack(ELLIPSE.velocity_at(TIMES), -1), "calendar": CALENDAR, "radius": 0.1},
            },
        ),
        "EscapeOrbit": (
            pt.orbits.EscapeOrbit,
            {
                **{"mu": 2.0, "periapsis_distance": 1.5, "eccentricity": 1.3, **elements},
                **{"time_since_periapsis": 0.2, "epoch": 0.1, "radius": 0.1},
            },
        ),
        "EscapeOrbit.from_elements": (
            pt.orbits.EscapeOrbit.from_elements,
            {
                **{"mu": 2.0, "eccentricity": 1.3, **elements, "semimajor_axis": -1.5, "true_anomaly": 0.5},
                **{"epoch": 0.1, "radius": 0.1},
            },
        ),
        "EscapeOrbit.from_vectors": (pt.orbits.EscapeOrbit.from_vectors, {**passage, "velocity": (0.1, 3.0, 0.2)}),
        "FixedPosition": (pt.orbits.FixedPosition, {"position": (1.0, 0, 0), "mu": 1.0}),
        "RotatingFrame.quaternion": (TURNING.quaternion, {"time": 1.0}),
        "RotatingFrame.omega_space": (TURNING.omega_space, {"time": 1.0}),
        "Frame.attitude": (ELLIPSE.frame.attitude, {"time": 1.0}),
        "Orbit.inverse_distance_at": (PRECESSING.inverse_distance_at, {"time": 1.0}),
        "OrbitFrame.omega_space": (ELLIPSE.frame.omega_space, {"time": 1.0}),
        "OrbitFrame.quaternion": (ELLIPSE.frame.quaternion, {"time": 1.0}),
        "FreeRotation": (pt.analysis.FreeRotation, {"body": BODY, "state": START}),
        "FreeRotation.from_periods": (
            pt.analysis.FreeRotation.from_periods,
            {
                **{"body": pt.Body((0.61, 0.965, 1.0)), "mode": "short-axis", "rotation_period": 9.6},
                **{"precession_period": 1.0, "longitude": 0.1, "latitude": 0.2, "precession_angle": 0.3},
                **{"rotation_angle": 0.4, "axes": "space", "time": 0.5},
            },
        ),
        "GravityField": (
            pt.GravityField,
            {
                **{"degree": 2, "mass": 1.0, "radius": 1.0, "extent": 0.0},
                **{"C": field().C, "S": field().S},
            },
        ),
        "GravityField.from_normalized": (
            pt.GravityField.from_normalized,
            {"mass": 1.0, "radius": 1.0, "C": field().normalized[0], "S": field().normalized[1], "extent": 0.0},
        ),
        "GravityField.truncated": (field().truncated, {"degree": 2}),
        "GravityGradient": (pt.GravityGradient, {"orbit": ELLIPSE}),
        "HarmonicGravity": (pt.forces.HarmonicGravity, {"orbit": ELLIPSE, "field": field()}),
        "AtTime": (pt.events.AtTime, {"time": 1.0, "direction": 1, "terminal": False}),
        "KeplerOrbit": (
            pt.KeplerOrbit,
            {
                **{"mu": 2.0, "semimajor_axis": 1.5, "eccentricity": 0.3, **elements},
                **{"true_anomaly": 0.5, "epoch": 0.1, "radius": 0.1},
            },
        ),
        "KeplerOrbit.from_elements": (
            pt.KeplerOrbit.from_elements,
            {
                **{"mu": 2.0, "semimajor_axis": 1.5, "eccentricity": 0.3, **elements, "mean_anomaly": 0.5},
                **{"epoch": 0.1, "radius": 0.1},
            },
        ),
        "KeplerOrbit.from_elements eccentric": (
            pt.KeplerOrbit.from_elements,
            {"mu": 2.0, "periapsis_distance": 1.5, "eccentricity": 0.3, **elements, "eccentric_anomaly": 0.5},
        ),
        "KeplerOrbit.from_vectors": (pt.KeplerOrbit.from_vectors, passage),
        "LagrangePointPath": (
            pt.orbits.LagrangePointPath,
            {"mu_primary": 1.0, "mu_secondary": 0.01, "separation": 1.0, "point": "L4", "epoch": 0.0},
        ),
        "LagrangePointPath.path": (
            pt.orbits.LagrangePointPath(1.0, 0.01, separation=1.0, point="L4").path,
            {"offset": (0.01, 0, 0), "velocity": (0, 0.01, 0)},
        ),
        "AtmosphericDrag": (
            pt.forces.AtmosphericDrag,
            {"orbit": ELLIPSE, "atmosphere": pt.forces.ExponentialAtmosphere(0.3, 1.1, 0.4), "facets": plate()},
        ),
        "ExponentialAtmosphere": (
            pt.forces.ExponentialAtmosphere,
            {
                **{"reference_density": 0.3, "reference_radius": 1.1, "scale_height": 0.4},
                "omega_space": (0, 0, 0.1),
            },
        ),
        "Facets": (
            pt.forces.Facets,
            {
                **{"areas": (1.0,), "normals": ((0, 0, 1),), "positions": ((0.1, 0, 0),), "closed": False},
                **COEFFICIENTS,
            },
        ),
        "Facets.from_box": (
            pt.forces.Facets.from_box,
            {
                **{"sides": (1.0, 2.0, 3.0), "position": (0.1, 0, 0), "wing_areas": (1.0,)},
                **{"wing_normals": ((0, 0, 1),), "wing_positions": ((0, 2, 0),), **COEFFICIENTS},
            },
        ),
        "Facets.joined": (plate().joined, {}),
        "Facets.from_mesh": (
            pt.forces.Facets.from_mesh,
            {"mesh": pt.shapes.Mesh(CORNERS, FACES, mass=1.0), **COEFFICIENTS},
        ),
        "TabulatedAtmosphere.from_table": (
            pt.forces.TabulatedAtmosphere.from_table,
            {"times": (0.0, 1.0, 2.0), "densities": (0.3, 0.2, 0.4), "omega_space": (0, 0, 0.1)},
        ),
        "Occulter": (pt.forces.Occulter, {"orbit": ELLIPSE, "radius": 0.3}),
        "RadiationPressure": (
            pt.forces.RadiationPressure,
            {
                **{"sun": ELLIPSE, "facets": plate(), "occulters": [pt.forces.Occulter(CIRCLE, 0.3)]},
                **{"pressure": 0.1, "distance": 1.0, "sun_radius": 0.1},
            },
        ),
        "LinearDamping": (pt.forces.LinearDamping, {"coefficient": 0.1}),
        "MasconGravity": (
            pt.forces.MasconGravity,
            {"orbit": ELLIPSE, "masses": (1.0, 1.0), "positions": ((0.1, 0, 0), (-0.1, 0, 0))},
        ),
        "Mascons": (pt.shapes.Mascons, {"masses": (1.0, 1.0), "positions": ((0.1, 0, 0), (-0.1, 0, 0))}),
        "Mesh": (pt.shapes.Mesh, {"vertices": CORNERS, "faces": FACES, "mass": 1.0, "repair": False}),
        "Mesh.from_box": (pt.shapes.Mesh.from_box, {"sides": (1.0, 2.0, 3.0), "density": 1.0}),
        "Oblateness": (
            pt.forces.Oblateness,
            {"orbit": ELLIPSE, "j2": 1e-3, "equatorial_radius": 0.1, "pole": (0, 0, 1)},
        ),
        "PeriodicMotion.over_period": (periodic().over_period, {"count": 9}),
        "PrecessingOrbit": (
            pt.orbits.PrecessingOrbit,
            {"orbit": ELLIPSE, "node_rate": 0.01, "periapsis_rate": 0.01, "anomaly_rate": 0.01},
        ),
        "PrecessingOrbit.angles_at": (PRECESSING.angles_at, {"time": 1.0}),
        "PrecessingOrbit.from_mean_motion": (
            pt.orbits.PrecessingOrbit.from_mean_motion,
            {"orbit": ELLIPSE, "mean_motion": 0.7, "node_rate": 0.01, "periapsis_rate": 0.01},
        ),
        "RateCrossing": (pt.events.RateCrossing, {**cone, "rate": 0.1}),
        "RotatingFrame": (pt.RotatingFrame, {"attitude": (1.0, 0, 0, 0), "omega_space": (0, 0, 1.0), "epoch": 0.5}),
        "RotatingPosition": (
            pt.orbits.RotatingPosition,
            {"position": (1.0, 0, 0), "mu": 1.0, "rate": 0.1, "epoch": 0.0},
        ),
        "Scenario.observe": (pt.files.read_scenario(at["toml"]).observe, {"motion": motion(), "noise": 3}),
        "Scenario.propagate": (pt.files.read_scenario(at["toml"]).propagate, {"threads": 1, "progress": False}),
        "Ellipsoid.mesh": (pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).mesh, {"faces": 20}),
        "GroundStation": (
            pt.orbits.GroundStation,
            {
                **{"orbit": ELLIPSE, "rotation": pt.orbits.RotationModel(0.1, 1.2, 0.3, rate=0.5)},
                **{"latitude": 0.3, "longitude": 0.2, "height": 0.01, "minimum_elevation": 0.1},
                **{"equatorial_radius": 0.5, "flattening": 0.01},
            },
        ),
        **{
            f"GroundStation.{name}": (getattr(ground_station(), name), {"time": 0.3})
            for name in ("position_at", "velocity_at", "elevation_at")
        },
        "Shape.attraction": (pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).attraction, {"points": (5.0, 0, 0)}),
        "Shape.field": (pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).field, {"degree": 2, "radius": 4.0}),
        "Shape.moved": (
            pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).moved,
            {"position": (1.0, 0, 0), "attitude": (1.0, 0, 0, 0)},
        ),
        "Shape.potential": (pt.shapes.Ellipsoid((3, 2, 1), mass=1.0).potential, {"points": (5.0, 0, 0)}),
        "SpinFlip": (pt.events.SpinFlip, cone),
        "State": (pt.State, {"quaternion": (1.0, 0, 0, 0), "conjugate_momenta": (0, 0.1, 0.2, 0.3), "time": 1.0}),
        "State.euler": (START.euler, {"sequence": "313"}),
        "State.from_euler": (
            pt.State.from_euler,
            {"angles": (0.1, 0.7, 0.3), "momenta": (0.1, 0.2, 0.3), "sequence": "313", "time": 1.0},
        ),
        "StateTransition.covariance": (
            transition().covariance,
            {"initial": 1e-6 * np.eye(6), "of_parameters": 1e-6 * np.eye(1)},
        ),
        "System": (pt.System, {"body": BODY, "units": {"time": "s"}}),
        "System.energy": (TOP.energy, {"state": START}),
        "System.kinetic_energy": (TOP.kinetic_energy, {"state": START}),
        "System.omega_body": (TOP.omega_body, {"state": START}),
        "System.potential_energy": (TOP.potential_energy, {"state": START}),
        "System.torque_body": (TOP.torque_body, {"state": START}),
        "System.torques_body": (TOP.torques_body, {"state": START}),
        "System.relative_errors": (TOP.relative_errors, {"state": START}),
        "ThreeBodyPath": (
            pt.orbits.ThreeBodyPath,
            {
                **{"mu_primary": 1.0, "mu_secondary": 0.01, "separation": 1.0, "epoch": 0.0},
                **{"position": (0.5, 0.8, 0), "velocity": (0, 0.1, 0)},
            },
        ),
        "Trajectory.__call__": (motion().__call__, {"time": 1.0}),
        "Trajectory.column": (motion().column, {"name": "omega_body"}),
        "Trajectory.euler": (motion().euler, {"sequence": "313"}),
        "Trajectory.isel": (ensemble().isel, {"time": [0, 2], "member": slice(0, 1)}),
        "RunEstimate.seconds_on": (ESTIMATE.seconds_on, {"workers": 2, "threads": 4}),
        "Trajectory.member": (ensemble().member, {"member": 1}),
        "Trajectory.relative_to": (motion().relative_to, {"frame": CIRCLE.frame}),
        "UniformGravity": (pt.UniformGravity, {"weight": 0.5, "center_of_mass": (1.0, 0, 0)}),
        "andoyer_section": (pt.analysis.andoyer_section, {"system": TOP, "state": START, "time": 3.0, "angle": 0.1}),
        "cassini_state": (
            pt.analysis.cassini_state,
            {"body": SATELLITE.body, "orbit": PRECESSING, "spin": 1.0, "obliquity": 0.1},
        ),
        "chaos_indicators": (pt.analysis.chaos_indicators, {**here, **run, "vectors": 1, "momentum_unit": 1.0}),
        "continue_motion": (
            pt.analysis.continue_motion,
            {
                **{"motion": periodic(), "parameter": "moments[0]", "to": 1.001, "progress": False},
                **{"period": lambda _: periodic().period, "frame": lambda _: CIRCLE.frame},
            },
        ),
        "diffusion": (pt.analysis.diffusion, {"signal": SIGNAL, "times": 0.1, "count": 1}),
        "equilibria": (
            pt.analysis.equilibria,
            {"system": SATELLITE, "frame": CIRCLE.frame, "guesses": (1.0, 0, 0, 0), "time": 0.0},
        ),
        "free_motion": (pt.free_motion, {"body": BODY, "state": START, "times": TIMES, "units": {"time": "s"}}),
        "frequencies": (
            pt.analysis.frequencies,
            {"signal": SIGNAL, "times": 0.1, "count": 1, "sigma": 0.1, "highest": 20.0},
        ),
        "identify_lines": (
            pt.analysis.identify_lines,
            {
                **{"spectrum": pt.analysis.frequencies(SIGNAL, 0.1, 2), "base": (1.0, 0.3), "order": 3, "count": 2},
                "body": pt.Body((0.61, 0.965, 1.0)),
            },
        ),
        "LineIdentification.alternatives": (
            pt.analysis.identify_lines(pt.analysis.frequencies(SIGNAL, 0.1, 2), base=(1.0, 0.3))[0].alternatives,
            {"line": 0},
        ),
        "load": (pt.load, {"source": at["nc"]}),
        "lyapunov_spectrum": (pt.analysis.lyapunov_spectrum, {**here, **run}),
        "omm_orbit": (pt.files.omm_orbit, {"message": OMM, **dates, "reference_frame": "TEME"}),
        "composite_orbit": (
            functools.partial(pt.orbits.composite_orbit, ephemeris(), ephemeris()),
            {"start": 0.5, "stop": 2.0},
        ),
        "periodic_motion": (
            pt.analysis.periodic_motion,
            {"system": SATELLITE, "guess": periodic().state, "period": periodic().period, "frame": CIRCLE.frame},
        ),
        "planet_orbit": (
            pt.orbits.planet_orbit,
            {"body": "EARTH", "attractor": "SUN", "start": 0.0, "stop": 1e5, "calendar": CALENDAR},
        ),
        "plot.angular_momentum": (pt.plot.angular_momentum, {"motion": motion(), **both}),
        "plot.branch": (
            pt.plot.branch,
            {"branch": branch(), "quantity": energy_of, "labels": ("x", "y"), **drawn},
        ),
        "plot.attitude_error": (pt.plot.attitude_error, {"motion": motion(), "other": (1, 0, 0, 0), **both}),
        "plot.chaos": (pt.plot.chaos, {"found": indicators(), "labels": ("a",), **both, "time_unit": None}),
        "plot.difference": (
            pt.plot.difference,
            {"motion": motion(), "other": motion(), "angle_unit": "deg", **shown},
        ),
        "plot.distance": (pt.plot.distance, {"motion": pair_motion(), **shown}),
        "plot.drift": (pt.plot.drift, {"motion": motion(), **shown}),
        "plot.torques": (pt.plot.torques, {"motion": along_orbit(), **shown}),
        "plot.euler_angles": (
            pt.plot.euler_angles,
            {"motion": motion(), "sequence": "313", "angle_unit": "deg", **shown},
        ),
        "plot.histogram": (
            pt.plot.histogram,
            {"ensemble": ensemble(), "quantity": "rate", "angle_unit": "deg", "rate_unit": "rad", **drawn},
        ),
        "plot.herpolhode": (pt.plot.herpolhode, {"motion": free(), **turning, "rate_unit": "deg", "time_unit": None}),
        "plot.map": (
            pt.plot.map,
            {
                **{"x": (0.0, 1.0), "y": (0.0, 1.0), "values": ((1.0, 2.0), (3.0, 4.0)), "x_label": "x", **drawn},
                **{"y_label": "y", "label": "v", "center": 2.0, "limits": (0.0, 5.0)},
            },
        ),
        "plot.momentum_sphere": (
            pt.plot.momentum_sphere,
            {"motion": BODY, "state": START, "view": (10.0, 20.0), "ax": None, "time_unit": None},
        ),
        "plot.poinsot_construction": (
            pt.plot.poinsot_construction,
            {"motion": free(), "time_index": 1, "view": (10.0, 20.0), "ax": None, "rate_unit": "deg"},
        ),
        "plot.polhode": (pt.plot.polhode, {"motion": motion(), "view": (10.0, 20.0), **turning}),
        "plot.librations": (
            pt.plot.librations,
            {"motion": pair_motion(), "body": "primary", "angle_unit": "deg", **shown},
        ),
        "plot.mutual_orbit": (pt.plot.mutual_orbit, {"motion": pair_motion(), **shown}),
        "plot.part_variables": (pt.plot.part_variables, {"motion": damped(), "part": "kane_damper", **shown}),
        "plot.quaternions": (pt.plot.quaternions, {"motion": motion(), **both}),
        "plot.angular_velocity": (pt.plot.angular_velocity, {"motion": motion(), "rate_unit": "rpm", **both}),
        "plot.roll_pitch_yaw": (
            pt.plot.roll_pitch_yaw,
            {"motion": along_orbit(), "orbit": CIRCLE, "angle_unit": "deg", **shown},
        ),
        "plot.phase_plane": (
            pt.plot.phase_plane,
            {"readings": read(), "periods": (0.7, 1.1), "model": read(), "epoch": 0.1, "time_unit": "s", **drawn},
        ),
        "plot.phased": (
            pt.plot.phased,
            {
                "readings": read(),
                "period": 0.7,
                "model": read(),
                "epoch": 0.1,
                "points": True,
                "time_unit": "s",
                **drawn,
            },
        ),
        "plot.readings": (pt.plot.readings, {"readings": read(), "points": True, **shown}),
        "plot.section": (pt.plot.section, {"section": pt.analysis.section(motion(), where), **drawn}),
        "plot.sky": (
            pt.plot.sky,
            {"motion": motion(), "curve": light_curve(), "times": TIMES[:2], "north": (0, 0, 1.0), **shown},
        ),
        "plot.spectrum": (
            pt.plot.spectrum,
            {
                "spectrum": pt.analysis.frequencies(SIGNAL, 0.1, 2),
                "time": "s",
                "unit": "m",
                "rate_unit": "rev/d",
                **drawn,
            },
        ),
        "plot.uncertainty": (
            pt.plot.uncertainty,
            {
                "transition": transition(),
                "initial": 1e-6 * np.eye(6),
                "of_parameters": 1e-6 * np.eye(1),
                **both,
                "angle_unit": "arcsec",
            },
        ),
        "project_to_tangent": (
            pt.mechanics.project_to_tangent,
            {"quaternion": (1.0, 0, 0, 0), "conjugate_momenta": (0.1, 0.1, 0.2, 0.3)},
        ),
        "estimate_run": (pt.analysis.estimate_run, {**here, **run, "tolerance": 1e-12}),
        "propagate": (
            pt.propagate,
            {**here, **run, "events": [pt.events.SpinFlip((1, 0, 0))], "dense": True, "precision": "double"},
        ),
        "read_alcdef": (pt.files.read_alcdef, {"path": at["alcdef"], "observable": LIGHT, "calendar": DAYS}),
        "read_damit": (
            pt.files.read_damit,
            {
                **{"path": at["curves"], "shape": ELLIPSOID, "law": LIGHT.law, "calendar": DAYS, "scale": "TDB"},
                **{"sigma": 0.1, "au": 1.5e8},
            },
        ),
        "DamitSpin": (
            pt.files.DamitSpin,
            {"longitude": 0.3, "latitude": 0.2, "period": 5.0, "epoch": 1.0, "angle": 0.1, "calendar": DAYS},
        ),
        "read_damit_spin": (pt.files.read_damit_spin, {"path": at["spin"], "calendar": DAYS}),
        "read_readings": (pt.files.read_readings, {"path": at["readings"]}),
        "read_gyro_csv": (
            pt.files.read_gyro_csv,
            {"path": at["gyro"], "gyro": pt.observables.Gyro(), "cuts": at["cuts"], "sigma": 0.1},
        ),
        "read_readings_csv": (
            pt.files.read_readings_csv,
            {
                **{"path": at["gyro"], "observable": pt.observables.Gyro(), "columns": ["t_s", "wx", "wy", "wz"]},
                **{"sigma": 0.1, "calendar": DAYS},
            },
        ),
        "read_aem": (pt.files.read_aem, {"path": at["aem"], "segment": 0, "calendar": CALENDAR}),
        "read_ck": (pt.files.read_ck, {"path": at["ck"][0], "calendar": CALENDAR}),
        "read_apm": (pt.files.read_apm, {"path": at["apm"], "calendar": CALENDAR}),
        "read_field": (
            pt.files.read_field,
            {"path": at["field"], "degree": 2, "mass": 1.0, "unit": 1.0, "extent": 0.0},
        ),
        "read_mesh": (pt.files.read_mesh, {"path": at["obj"], "mass": 1.0, "unit": 1.0, "repair": False}),
        "read_oem": (pt.files.read_oem, {"path": at["oem"], "mu": 398600.0, "segment": 0, "calendar": CALENDAR}),
        "read_quaternion_csv": (pt.files.read_quaternion_csv, {"path": at["csv"], "calendar": CALENDAR}),
        "read_scenario": (pt.files.read_scenario, {"path": at["toml"]}),
        "read_stk_attitude": (pt.files.read_stk_attitude, {"path": at["stk"], "calendar": CALENDAR}),
        "save": (pt.save, {"motion": motion(), "path": folder / "out.nc", "overwrite": True}),
        "save to Zarr": (pt.save, {"motion": motion(), "path": folder / "out.zarr", "overwrite": True}),
        "section": (
            pt.analysis.section,
            {"motion": motion(), "coordinates": where, "event": 0, "labels": ("x", "y")},
        ),
        "spice_attitude": (
            pt.files.spice_attitude,
            {
                **{"frame": "SC_BODY_1", "times": TIMES, "kernels": kernels, "reference_frame": "J2000"},
                **{"calendar": CALENDAR},
            },
        ),
        "spice_orbit": (
            pt.files.spice_orbit,
            {
                **{"target": -999, "center": 2000001, "start": 0.5, "stop": 2.0, "kernels": [at["spk"]]},
                **{"frame": "J2000", "mu": 2.0, "calendar": J2000},
            },
        ),
        "spin_orbit_section": (
            pt.analysis.spin_orbit_section,
            {"system": SATELLITE, "angle": 0.1, "rate": 1.0, "revolutions": 1},
        ),
        "observe": (functools.partial(pt.observe, motion(), pt.observables.Gyro()), {"times": TIMES}),
        "observed_partials": (
            pt.analysis.observed_partials,
            {**here, **run, "observables": pt.observables.Gyro(), "parameters": ("weight",)},
        ),
        "state_transition": (pt.analysis.state_transition, {**here, **run, "parameters": ("weight",), "order": 1}),
        "tle_orbit": (pt.files.tle_orbit, {"lines": VANGUARD, **dates, "reference_frame": "TEME"}),
        "two_body_orbit": (pt.orbits.two_body_orbit, passage),
        "animate": (
            pt.animate,
            {
                **{"motion": motion(), "path": folder / "out.gif", "seconds": 0.1, "view": (20.0, -60.0)},
                **seen,
                "overwrite": True,
            },
        ),
        "view": (
            pt.view,
            {"motion": motion(), "path": folder / "out.html", "others": motion(), **seen, "overwrite": True},
        ),
        "write_alcdef": (
            pt.files.write_alcdef,
            {
                **{"readings": [NIGHT], "path": folder / "out.txt", "metadata": {"OBJECTNAME": "Eros"}},
                "overwrite": True,
            },
        ),
        "write_damit": (
            pt.files.write_damit,
            {
                "readings": pt.files.read_damit(at["curves"], ELLIPSOID, LIGHT.law),
                "path": folder / "out.txt",
                "overwrite": True,
            },
        ),
        "write_damit_shape": (
            pt.files.write_damit_shape,
            {
                "mesh": pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0),
                "path": folder / "out.txt",
                "unit": 1.0,
                "overwrite": True,
            },
        ),
        "write_damit_spin": (
            pt.files.write_damit_spin,
            {"spin": pt.files.read_damit_spin(at["spin"]), "path": folder / "out.txt", "overwrite": True},
        ),
        "write_readings": (
            pt.files.write_readings,
            {"readings": [NIGHT], "path": folder / "out.readings.nc", "overwrite": True},
        ),
        "write_readings_csv": (
            pt.files.write_readings_csv,
            {"readings": NIGHT, "path": folder / "out.csv", "overwrite": True},
        ),
        "write_aem": (
            pt.files.write_aem,
            {
                **{**out, "path": folder / "out.aem", "object_name": "A", "object_id": "A", "center_name": "EARTH"},
                **{"originator": "A", "rates": True, "version": "2.0"},
            },
        ),
        "write_apm": (
            pt.files.write_apm,
            {
                **{"body": BODY, "state": START, "path": folder / "out.apm", **NAMED, "object_name": "A"},
                **{"object_id": "A", "center_name": "EARTH", "originator": "A", "version": "2.0"},
            },
        ),
        "write_ck": (pt.files.write_ck, {**out, "path": folder / "out.bc", "spacecraft": -1000, "rates": True}),
        "write_quaternion_csv": (pt.files.write_quaternion_csv, {**out, "path": folder / "out.csv", "rates": True}),
        "write_stk_attitude": (
            pt.files.write_stk_attitude,
            {
                **{"motion": motion(), "path": folder / "out.a", "calendar": CALENDAR, "reference_frame": "ICRF"},
                **{"central_body": "Earth", "rates": True, "overwrite": True},
            },
        ),
        **{
            f"{type(orbit).__name__}.{name}": (getattr(orbit, name), {next(iter(signature(orbit, name))): 0.5})
            for orbit in orbits()
            for name in dir(orbit)
            if name.endswith("_at") and not name.startswith("_") and name not in ("angles_at", "variables_at")
        },
    }


def orbits():
    point = pt.orbits.LagrangePointPath(1.0, 0.01, separation=1.0, point="L4")
    rotating = pt.orbits.RotatingPosition(1.0, position=(1.0, 0, 0), rate=0.1)
    return (
        ELLIPSE,
        ESCAPE,
        PRECESSING,
        ephemeris(),
        rotating,
        pt.orbits.FixedPosition(1.0, position=(1.0, 0, 0)),
        point.path(),
    )


def signature(thing, name):
    return inspect.signature(getattr(thing, name)).parameters


OMM = {
    "OBJECT_NAME": "VANGUARD 1",
    "OBJECT_ID": "1958-002B",
    "CENTER_NAME": "EARTH",
    "REF_FRAME": "TEME",
    "TIME_SYSTEM": "UTC",
    "MEAN_ELEMENT_THEORY": "SGP4",
    "EPOCH": "2000-06-27T18:50:19.733568",
    "MEAN_MOTION": "10.82419157",
    "ECCENTRICITY": "0.1859667",
    "INCLINATION": "34.2682",
    "RA_OF_ASC_NODE": "348.7242",
    "ARG_OF_PERICENTER": "331.7664",
    "MEAN_ANOMALY": "19.3264",
    "NORAD_CAT_ID": "5",
    "BSTAR": "0.28098E-4",
}


def public_names():
    """Yield every public name and every public method that takes arguments, less those that are not a user's."""
    yield from (f"plot.{name}" for name in pt.plot.__all__)
    for name, thing in PUBLIC.items():
        if name not in NOT_CALLED:
            yield name
        if (
            inspect.isclass(thing)
            and not issubclass(thing, BaseException)
            and name not in ("Vector", "Environment", "Instant")
        ):
            for method, found in vars(thing).items():
                plain = found.__func__ if isinstance(found, classmethod | staticmethod) else found
                shown = method == "__call__" or not method.startswith("_")
                taken = inspect.isfunction(plain) and len(inspect.signature(plain).parameters) > (
                    not isinstance(found, staticmethod)
                )
                if shown and taken and method not in INTERNAL and not getattr(found, "__isabstractmethod__", False):
                    yield f"{name}.{method}"
