"""Every public property and method of an ensemble is its value member by member, whatever the number of times.

Each number of each record differs from member to member. Introspection finds the public attributes, so that a new class
or a new method is tested here, or stands in a table of exclusions with the reason.
"""

import functools
import inspect
import operator
import re
import zlib
from collections.abc import Mapping
from itertools import chain
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from kinds.control_laws import LAWS, SAMPLED
from kinds.events import EVENTS
from kinds.forces import ELLIPSE, FORCES
from kinds.mutual_gravity import FORCES as MUTUAL
from kinds.mutual_gravity import PAIR
from kinds.observables import OBSERVABLES
from kinds.orbits import ORBITS
from kinds.pair_events import EVENTS as PAIR_EVENTS
from kinds.parts import PARTS
from poinsot.errors import refuse_other_length
from poinsot.functions import Vector
from poinsot.kinematics.frame import Frame
from poinsot.kinematics.state import State, state_of
from poinsot.mechanics.environment import OrbitBlock
from poinsot.mechanics.event import EventOn
from poinsot.mechanics.force import PotentialOn, TorqueOn
from poinsot.mechanics.instant import Instant
from poinsot.propagation.relative_motion import RelativeMotion
from poinsot.quantities import Rule, annotated_with
from poinsot.records.parameters import Parametric, kinds_of, of_each

COUNT = 4
MEMBERS = np.arange(COUNT)
TIMES = {"states": (), "one time": (1,), "fewer": (3,), "as many": (COUNT,), "more": (6,)}
"""The axes behind the member axis: none of states of members, else the times."""

WITHIN = 1e-12
"""Of the largest number, thousands of roundings: members differ by percents."""


class Straight(pt.Orbit):
    """A user's orbit along a straight line."""

    mu: float
    start: pt.SpaceVector
    speed: pt.SpaceVector

    def position_at(self, time):
        return Vector(x + v * time for x, v in zip(self.start, self.speed, strict=True))

    def velocity_at(self, time):  # noqa: ARG002
        return Vector(self.speed)


class Still(pt.Potential):
    """A user's potential of a dipole in a constant field, which does not pull at the orbit."""

    moment: float
    field: pt.SpaceVector

    def energy(self, instant):
        return self.moment * instant.attitude.to_body(self.field)[2]


# ------------------------------------------------------------------ records of members


def varied(record, who):
    """Return a record whose numbers are other ones for each member, of all members or of one."""
    kinds, rules, own = kinds_of(type(record)), annotated_with(type(record), Rule), {}
    for name, value in vars(record).items():
        if isinstance(getattr(type(record), name, None), functools.cached_property):
            continue
        is_unit = name in rules and rules[name].refuse is refuse_other_length
        number = functools.partial(varied_number, name, who, is_unit=is_unit or name == "axes")
        own[name] = number(value) if isinstance(kinds.get(name), tuple) else of_each(value, lambda x: varied(x, who))
    made = type(record).unchecked(**own)
    del vars(made)["member_axis"]
    return made


def varied_number(name, who, value, is_unit):
    value, who = np.asarray(value), np.asarray(who)
    if is_unit:
        turns = Rotation.from_rotvec(np.multiply.outer(0.1 * (1 + who), (0.6, 0.0, 0.8))).as_matrix()
        turned = np.einsum("...ij,kj->...ki", turns, np.atleast_2d(value))
        return turned.reshape(*who.shape, *value.shape)
    share = (0.02 + 0.02 * (zlib.crc32(name.encode()) % 97) / 97) * (1 + who)
    if value.shape == () and value == 0 and name != "eccentricity":  # a circle stays one
        return np.asarray(share)
    scaled = np.asarray(np.multiply.outer(1 + share, value))
    if name == "C":  # the first coefficient of a field is 1
        scaled[..., 0, 0] = value[0, 0]
    return scaled


def records_within(record):
    """Yield a record and all records in it."""
    yield record
    if not isinstance(record, ON_ONE):
        for inner in record.records:
            yield from records_within(inner)


ON_ONE = PotentialOn, TorqueOn, EventOn
"""Records of a formula of one body, of which each is tested with a system of one body."""


class World:
    """A system of all members, or of one, with arguments for its methods at some times."""

    def __init__(self, body, forces, who, times):
        self.who, self.times = who, times
        self.body, every = varied(body, who), [varied(force, who) for force in forces]
        self.forces = tuple(force for force in every if not isinstance(force, pt.Observable))
        self.observables = tuple(one for one in every if isinstance(one, pt.Observable))
        bare = pt.System(body)
        self.system = pt.System._of(
            bare.dynamics.with_records((self.body, *self.forces)), bare.units
        )  # varied numbers need no check

    @property
    def records(self):
        every = list(chain.from_iterable(map(records_within, (self.body, *self.forces, *self.observables))))
        return [*every, *(body.kinetics() for body in every if isinstance(body, pt.Body))]

    @property
    def shape(self):
        return (*np.shape(self.who), *self.times)

    @property
    def time(self):
        return np.linspace(0.3, 1.1, 6)[: self.times[0]] if self.times else 0.7

    def rows(self, *shape, seed=0):
        """Return random numbers, of all members or of one, at all times."""
        every = np.random.default_rng(seed).uniform(0.2, 0.8, (COUNT, 6, *shape))
        return (
            every[self.who][..., : self.times[0], *(slice(None),) * len(shape)] if self.times else (every[self.who, 0])
        )

    def turns(self, seed):
        rows = self.rows(4, seed=seed)
        return rows / np.linalg.norm(rows, axis=-1, keepdims=True)

    @functools.cached_property
    def instant(self):
        momentum = "angular_momentum_body"
        names = [f"{body}_" if body else "" for body in self.system.of_bodies]
        phase = {f"{name}quaternion": self.turns(i) for i, name in enumerate(names)}
        phase |= {f"{name}{momentum}": self.rows(3, seed=i) for i, name in enumerate(names)}
        phase |= {block.name: self.rows(block.size, seed=4) for block in self.system.dynamics.inner_blocks}
        return self.system.at(state_of(phase, np.broadcast_to(self.time, self.shape)))

    def argument(self, record, parameter):
        """Return the value of an argument by its name, as an array or as a vector of scalars by its annotation."""
        name, kind = parameter.name, parameter.annotation
        if name in ("instant", "time"):
            return getattr(self, name)
        if name == "light":
            mu0, mu, phase = (self.rows(seed=seed) for seed in range(3))
            return pt.observables.Reflection(mu0, mu, phase)
        if name in ("orbit", "sun", "target"):
            return next(x for x in self.records if isinstance(x, pt.Orbit))
        if kind == "int":
            return 2
        sizes = {
            "own": "size",
            "generalised_force": "size",
            "speeds": "count",
            "angles": "angle_count",
            "rates": "angle_count",
        }
        sizes |= dict.fromkeys(("along", "across", "mirrored"), "count")
        size = getattr(record, sizes[name], 3) if name in sizes else {"draws": 6}.get(name, 3)
        if kind == "Scalar":
            return self.rows(seed=zlib.crc32(name.encode()))
        rows = self.rows(size, seed=zlib.crc32(name.encode()))
        is_array = kind in ("Components", "ArrayLike", "AngularVelocities", "Array")
        return rows if is_array else Vector(np.moveaxis(rows, -1, 0))

    def value(self, record, name):
        """Return a public attribute, or what a method returns."""
        attribute = getattr(record, name)
        if not inspect.ismethod(attribute):
            return attribute
        if name in STARTS:
            return None if self.times else STARTS[name](record, self)
        parameters = [x for x in inspect.signature(attribute).parameters.values() if x.default is x.empty]
        return attribute(*(self.argument(record, parameter) for parameter in parameters))


def start(body, world, **own):
    """Return states of a body, or of two, with an attitude and a rate of each member."""
    if isinstance(body, pt.Body | pt.System):
        return body.state(world.turns(1), omega_body=world.rows(3), **own)
    attitudes, rates = [world.turns(1), world.turns(2)], [world.rows(3, seed=3), world.rows(3, seed=4)]
    return body.state(5 + world.rows(3), world.rows(3, seed=5), attitudes, omega_body=rates, frame="orbit")


STARTS: dict[str, Any] = {
    "state": start,
    "state_on": lambda pair, world: pair.state_on(
        pt.KeplerOrbit(pair.mu, semimajor_axis=4 + world.rows(), eccentricity=0.1, inclination=world.rows(seed=1)),
        [world.turns(1), world.turns(2)],
        omega_body=[world.rows(3)] * 2,
    ),
    "synchronous": lambda pair, world: pair.synchronous(primary_rate=world.rows(), distance=4 + world.rows(seed=1)),
    "doubly_synchronous": lambda pair, world: pair.doubly_synchronous(distance=4 + world.rows(seed=1)),
    "kick": lambda pair, world: pair.kick(start(pair, world), world.rows(3, seed=6), frame=ELLIPSE.frame),
}
"""Methods that make states, of which none has times."""

BOOKKEEPING = {
    **dict.fromkeys(("records", "numbers", "number_names", "structure", "definition"), "what the record is made of"),
    **dict.fromkeys(("member_axis", "with_axes", "with_numbers", "unchecked"), "the mechanism that is tested here"),
    **dict.fromkeys(("between_knots", "knots", "pieces", "piece"), "the tables, which all members share"),
    **dict.fromkeys(("check", "check_start", "refuse_inertia", "refuse_moved_orbit"), "a check without a result"),
    **dict.fromkeys(("on", "joined"), "another record of the same numbers"),
    **dict.fromkeys(("unit", "check_values", "check_times"), "a name, or a check without a result"),
    **dict.fromkeys(("time_of_body", "difference", "disturbed"), "arrays of readings, tested with every observable"),
    "act": "an action on the state of one member",
    "own": "the variables of an instant, which are arrays of its own",
}
"""Public attributes that are no values, and the reasons."""


RAISING = {("FixedPosition", "frame"): "a body at rest turns no axes"}
"""Public attributes that raise an error, and the reasons."""


def public(cls):
    """Return the names of the public attributes of a class: properties, and methods of its instances."""
    names = [name for name in dir(cls) if not name.startswith("_") and name not in BOOKKEEPING]
    found = {name: inspect.getattr_static(cls, name) for name in names}
    is_value = functools.cached_property | property
    return [name for name, one in found.items() if isinstance(one, is_value) or inspect.isfunction(one)]


# ------------------------------------------------------------------ values


def assert_same(got, each, world, what):
    """Assert that a value of members is the values of each."""
    first = each[0]
    if isinstance(first, Parametric):
        assert {one.structure for one in each} == {got.structure}, what
    if isinstance(first, Mapping):
        assert all(one.keys() == got.keys() for one in each), what
        parts = {key: (got[key], [one[key] for one in each]) for key in got}
    elif isinstance(first, tuple | list | Vector) or is_matrix(first):
        assert all(len(one) == len(got) for one in each), what
        parts = {i: (x, [one[i] for one in each]) for i, x in enumerate(got)}
    elif read := next((read for kind, read in OPENED.items() if isinstance(first, kind)), None):
        parts = {"": (read(got, world), [read(one, world) for one in each])}
    else:
        parts = {}
        if first is not None and not isinstance(first, str | bool | type | slice):
            assert_numbers(got, each, world, what)
    for key, (part, others) in parts.items():
        assert_same(part, others, world, f"{what}[{key}]")


OPENED = {
    Rotation: lambda turns, _: turns.as_quat(),
    Instant: lambda instant, _: (instant.attitude.quaternion, instant.omega_body),
    State: lambda state, _: {**state.phase},
    pt.PairState: lambda state, _: {**state.phase},
    Frame: lambda frame, world: (frame.quaternion(world.time), frame.omega_space(world.time)),
    Parametric: lambda record, _: record.numbers,
}
"""The values in what is no number."""


def is_matrix(value):
    """Whether a value is an array of scalars of a formula."""
    return isinstance(value, np.ndarray) and value.dtype.kind == "O"


def assert_numbers(got, each, world, what):
    got, each = np.asarray(got, dtype=float), [np.asarray(one, dtype=float) for one in each]
    want = np.stack(each)
    if got.shape == each[0].shape:  # one value for all members
        want = np.broadcast_to(got, want.shape)
        assert all(np.array_equal(one, got, equal_nan=True) for one in each), what
        return
    if got.shape == (COUNT, *world.times) and want.ndim <= got.ndim:  # a number may not depend on the time
        want = np.stack([np.broadcast_to(one, world.times) for one in each])
    assert got.shape == want.shape, f"{what} has shape {got.shape} and not {want.shape}"
    largest = np.max(np.abs(want), initial=0.0, where=np.isfinite(want))
    np.testing.assert_allclose(got, want, rtol=0, atol=WITHIN * largest, err_msg=what)


# ------------------------------------------------------------------ the law

BODY = pt.Body((6.0, 8.0, 10.0))
OBLIQUE = pt.Body.from_inertia([(6.0, 0.3, -0.2), (0.3, 8.0, 0.1), (-0.2, 0.1, 10.0)])
STRAIGHT = Straight(1.0, (1.0, 0.2, -0.3), (0.1, 0.9, 0.2))
MOON = pt.orbits.NutatingRotation(0.7, 0.4, -0.3, rate=0.6, terms=1, periodic=[(0.1, 0.2, 0.3, 0.4, 0.5)])
ROWS = np.linspace(-1, 3, 9)
AIR = pt.forces.TabulatedAtmosphere.from_table(ROWS, 2 + np.cos(ROWS), omega_space=(0.1, -0.2, 0.3))
FACETS = next(force.facets for force in FORCES if isinstance(force, pt.forces.AtmosphericDrag))
SINGLE = {
    **{f"force {i} {type(force).__name__}": (BODY, force) for i, force in enumerate((*FORCES, *LAWS, *SAMPLED))},
    **{f"part {i} {type(part).__name__}": (OBLIQUE, part) for i, part in enumerate(PARTS)},
    **{f"orbit {name}": (BODY, pt.GravityGradient(orbit)) for name, orbit in ORBITS.items()},
    "a user's orbit": (BODY, pt.GravityGradient(STRAIGHT)),
    "nutation": (BODY, pt.forces.MagneticMoment((1, 0, 0), pt.forces.TiltedDipole(ELLIPSE, MOON, 1.0, 0.2, 0.3, 0.9))),
    "air of a table": (BODY, pt.forces.AtmosphericDrag(ELLIPSE, AIR, FACETS)),
    **{f"event {name}": (BODY, event) for name, (event, _) in EVENTS.items()},
    **{f"observable {name}": (BODY, observable) for name, observable in OBSERVABLES.items()},
}
LOADS = (pt.forces.TidalFriction("primary", 0.3, 1.4, 0.2), pt.forces.LibrationDamping("secondary", 2e-3))
LOADED = (
    pt.forces.LinearDamping(0.1).on("primary"),
    Still(0.3, (0.1, 0.2, 0.9)).on("secondary"),
)
CONTACT = (pt.events.Contact((1.0, 0.9, 0.8), (0.6, 0.5, 0.4)),)
OF_TWO = (
    *MUTUAL,
    pt.forces.ThirdBody(ELLIPSE),
    *LOADS,
    *LOADED,
    *(event for event, _ in PAIR_EVENTS.values()),
    *CONTACT,
)
PAIRS = {f"pair {i} {type(force).__name__}": (PAIR, force) for i, force in enumerate(OF_TWO)}
SYSTEMS = SINGLE | PAIRS


@pytest.mark.parametrize("times", TIMES)
@pytest.mark.parametrize("name", SYSTEMS)
def test_values_of_members_are_those_of_each(name, times):
    body, force = SYSTEMS[name]
    whole = World(body, [force], MEMBERS, TIMES[times])
    each = [World(body, [force], member, TIMES[times]) for member in range(COUNT)]
    known = set()
    for i, record in enumerate(whole.records):
        if type(record) in known:
            continue
        known.add(type(record))
        for attribute in public(type(record)):
            what = f"{type(record).__name__}.{attribute}"
            if (type(record).__name__, attribute) in RAISING:
                continue
            values = [one.value(one.records[i], attribute) for one in each]
            assert_same(whole.value(record, attribute), values, whole, what)


def instances():
    """Yield a record or a frame of each class that the law above sees."""
    for body, force in SYSTEMS.values():
        for record in World(body, [force], 0, ()).records:
            yield record
            if isinstance(record, pt.Orbit) and not isinstance(record, pt.orbits.FixedPosition):
                yield record.frame


INNER = {
    **dict.fromkeys(("Block", "Dated", "Force", "Part", "_On"), "a base without a formula"),
    **dict.fromkeys(("CompositeBody", "_Piece", "RelativeOrbit"), "made inside formulas, of scalars that broadcast"),
    **dict.fromkeys(
        ["AshikhminShirley", "CookTorrance", "Hapke", "LambertLommelSeeliger", "LunarLambert", "Minnaert", "Phong"],
        "a formula of three angles, as that of Lambert",
    ),
    "IsotropicPhase": "the constant 1",
    "AngularVelocity": "an observable of a fit, without numbers",
    "ObservableOn": "an observable of one of two bodies, tested with the observable",
    "RecordedObservable": "an observable of a file, without a formula",
    "IGRF": "SecularHarmonics between two dates, with the tables of the standard",
    "Impact": "an action on states of single members; its value is that of AtTime",
    "RecordedEvent": "an event of a file, without a formula",
    "RelativeOrbitFrame": "the frame of a motion of two bodies, tested with it",
}
"""Classes without an instance above, and the reasons."""


def test_every_class_is_here():
    """Blocks of orbits are left out: a kernel integrates their variables, and formulas see the orbits."""
    found = {type(one).__name__ for one in instances()}
    every = {kind for kind in concrete_subclasses(Parametric, Frame) if not issubclass(kind, OrbitBlock)}
    assert {kind.__name__ for kind in every} - found == INNER.keys()


# ------------------------------------------------------------------ motions

LONG = pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.8, inclination=0.4, epoch=0.2)
MOTIONS = {
    "body": (BODY, (pt.GravityGradient(LONG), pt.GravityGradient(STRAIGHT), PARTS[1], pt.forces.LinearDamping(0.1))),
    "pair": (PAIR, (pt.forces.MutualGravity(), pt.forces.LinearDamping(0.1).on("secondary"))),
}


@functools.cache
def motion_of(name, times):
    """Return the motion of all members at some times, and the motions of each."""
    body, forces = MOTIONS[name]
    whole = World(body, forces, MEMBERS, ())
    system = pt.System(whole.body, *whole.forces)
    own = {part.name: whole.rows(part.size) for part in system.parts}
    first = start(system if name == "body" else whole.body, whole, **own)
    motion = pt.propagate(system, first, np.linspace(0.1, 0.4, *TIMES[times]))
    return motion, [motion.member(i) for i in range(COUNT)]


def frame_of(motion):
    return motion.system.orbits[0].frame if motion.system.orbits else pt.RotatingFrame((1, 0, 0, 0), (0.1, 0.2, 0.3))


READ = {
    "euler": lambda motion: motion.euler("321"),
    "relative_to": lambda motion: motion.relative_to(frame_of(motion)),
    "environment": lambda motion: [
        getattr(motion.environment, name)(orbit)
        for orbit in motion.system.orbits
        for name in ("position", "velocity", "inverse_distance", "direction")
    ],
    "dataset": lambda motion: {
        name: values.to_numpy() for name, values in motion.dataset.items() if "time" in values.dims
    },
    "orbit_frame": lambda motion: [getattr(motion.orbit_frame, x)(motion.times) for x in ("quaternion", "omega_space")],
    "elements": lambda motion: {name: x for name, x in vars(motion.elements).items() if name != "mu"},
}
"""Calls of the methods of motions, and the values of attributes that are no numbers."""

UNREAD = {
    **dict.fromkeys(("member", "isel", "variables", "variable_names", "column"), "a choice of rows"),
    **dict.fromkeys(("events", "summary", "calendar", "reference_frame", "has_dense_output"), "text, or no array"),
    **dict.fromkeys(("is_ensemble", "phase", "of_bodies", "with_observables"), "the arrays of the other attributes"),
}


def assert_motions_agree(motion, each, times, what):
    names = [name for name in public(type(motion)) if name not in UNREAD]
    for name in names:
        read = READ.get(name, operator.attrgetter(name))
        try:
            values = [read(one) for one in each]
        except AttributeError as error:  # of two bodies, or of one of two
            with pytest.raises(AttributeError, match=re.escape(str(error))):
                read(motion)
            continue
        got = read(motion)
        assert not inspect.ismethod(got), f"{what}.{name} needs a call in READ"
        if isinstance(got, pt.Trajectory | RelativeMotion):
            assert_motions_agree(got, values, times, f"{what}.{name}")
        else:
            assert_same(got, values, SimpleNamespace(times=TIMES[times]), f"{what}.{name}")


@pytest.mark.parametrize("times", [times for times in TIMES if TIMES[times]])
@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_of_members_is_the_motion_of_each(name, times):
    motion, each = motion_of(name, times)
    assert_motions_agree(motion, each, times, name)


@pytest.mark.parametrize("times", ["fewer", "as many", "more"])
def test_pitch_of_members_is_drawn_from_the_frame_of_each(times):
    motion, each = motion_of("body", times)
    (line,) = [x for x in pt.plot.roll_pitch_yaw(motion, motion.system.orbits[0]).lines if x.get_label() == "pitch"]
    pitch = [alone.relative_to(frame_of(alone)).roll_pitch_yaw[:, 1] for alone in each]
    np.testing.assert_allclose(line.get_ydata(), np.degrees(np.median(pitch, axis=0)), rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["ellipse", "turning", "table", "a user's orbit"])
def test_states_of_members_at_times_of_their_own_are_the_states_of_each(name):
    orbit = STRAIGHT if name == "a user's orbit" else ORBITS[name]
    whole, times = varied(orbit, MEMBERS), np.array([0.2, 0.9, 0.4, 1.1])
    attitude, rate = Rotation.random(COUNT, np.random.default_rng(3)).as_quat(), np.eye(4, 3)
    states = BODY.state(attitude, omega_body=rate, time=times, frame=whole.frame)
    assert states.shape == (COUNT,)
    for i in MEMBERS:
        frame = varied(orbit, i).frame
        alone = BODY.state(attitude[i], omega_body=rate[i], time=times[i], frame=frame)
        np.testing.assert_allclose(np.abs(states.quaternion[i]), np.abs(alone.quaternion), rtol=0, atol=1e-14)
        found = states.angular_momentum_body[i], alone.angular_momentum_body
        np.testing.assert_allclose(*found, rtol=0, atol=WITHIN * np.max(np.abs(alone.angular_momentum_body)))


def test_the_quaternion_of_a_table_does_not_jump_for_members():
    """Two revolutions, each of which changes the sign of a continuous quaternion."""
    circle = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.5)
    table = {"position": lambda t: np.stack(list(circle.position_at(t)), -1), "start": 0.0, "stop": 13.0}
    many, one = (pt.orbits.Ephemeris.from_function(mu, **table).frame for mu in ([1.0, 2.0], 1.0))
    times = np.linspace(0.0, 13.0, 60)
    assert np.array_equal(many.quaternion(times), np.stack([one.quaternion(times)] * 2))
    assert np.all(np.sum(one.quaternion(times)[1:] * one.quaternion(times)[:-1], axis=-1) > 0.9)


def test_an_override_without_annotations_has_the_kinds_of_the_base():
    class Brake(pt.parts.ReactionWheel):
        def torque_at(self, slip):
            return -self.torque * slip

    wheel, slips = Brake((0, 0, 1), 0.1, torque=np.array([1.0, 2.0])), np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert np.array_equal(wheel.torque_at(slips), -slips * [[1.0], [2.0]])
    assert np.array_equal(wheel.torque_at(slip=slips[:, 0]), -slips[:, 0] * [1.0, 2.0])


TWO = pt.Body([(1.0, 1.2, 1.5), (1.1, 1.3, 1.4)])
CIRCLES = pt.KeplerOrbit(1.0, semimajor_axis=[1.0, 2.0], eccentricity=0.0)
WRONG = {
    "vectors of other members": (
        lambda: TWO.omega(np.ones((3, 3))),
        "angular_momentum_body must have the 2 members as its first axis, got shape (3,).",
    ),
    "a vector of two components": (
        lambda: TWO.omega(np.ones((2, 2))),
        "angular_momentum_body must have shape (..., 3), got shape (2, 2).",
    ),
    "variables of another length": (
        lambda: pt.parts.ReactionWheel((0, 0, 1), 0.1).speed(np.ones((2, 3)), (0, 0, 1)),
        "own must have shape (..., 1), got shape (2, 3).",
    ),
    "times of other members": (
        lambda: CIRCLES.position_at(np.ones((3, 4))),
        "time must have shape (), (times,) or (members, times) with 2 members, got shape (3, 4).",
    ),
    "times of other members, of a frame": (
        lambda: CIRCLES.frame.quaternion(np.ones((3, 4))),
        "time must have shape (), (times,) or (members, times) with 2 members, got shape (3, 4).",
    ),
    "numbers of two counts": (
        lambda: pt.KeplerOrbit([1.0, 1.0], semimajor_axis=[1.0, 2.0, 3.0], eccentricity=0.0).position_at(0.0),
        "the numbers of KeplerOrbit must have equally many members, got 2 and 3.",
    ),
    "a frame of two counts": (
        lambda: pt.RotatingFrame(np.tile((1, 0, 0, 0), (2, 1)), np.ones((3, 3))),
        "omega_space must have as many members as attitude, got 3 and 2.",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_shapes_that_fit_no_members_are_refused(case):
    call, message = WRONG[case]
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        call()


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("formula", ["position", "velocity", "inverse_distance", "direction"])
def test_the_environment_of_states_is_at_the_time_of_each(formula, count):
    """Members' orbits at the members' times, not at the times of all members."""
    axes, times = np.linspace(1.0, 1.5, count), np.linspace(0.0, 1.0, count)
    orbit = pt.KeplerOrbit(1.0, semimajor_axis=axes, eccentricity=0.3)
    body = pt.Body((1.25, 1.0, 0.75))
    system = pt.System(body, pt.GravityGradient(orbit))
    for time in (times, 0.5):
        state = system.state(np.tile((1.0, 0, 0, 0), (count, 1)), omega_body=(0, 0, 0.1), time=time)
        instant = system.at(state)
        got = np.asarray(getattr(instant.environment, formula)(orbit))
        assert np.array_equal(got, np.asarray(getattr(instant, formula)(orbit)))
        for k, axis in enumerate(axes):
            own = pt.KeplerOrbit(1.0, semimajor_axis=axis, eccentricity=0.3)
            one = pt.mechanics.Environment(float(np.broadcast_to(time, count)[k]))
            # Two roundings of the last bits: formulas of arrays and of scalars may differ.
            np.testing.assert_allclose(got[..., k], np.asarray(getattr(one, formula)(own)), rtol=1e-15, atol=1e-15)
