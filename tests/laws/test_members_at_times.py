"""Every public property and method of an ensemble is its value member by member, whatever the number of times.

Each number of each record differs from member to member. Introspection finds the public attributes, so that a new class
or a new method is tested here, or stands in a table of exclusions with the reason.
"""

import functools
import inspect
import zlib
from collections.abc import Mapping
from itertools import chain

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from laws.test_every_control_law import LAWS, SAMPLED
from laws.test_every_force import ELLIPSE, FORCES
from laws.test_every_mutual_gravity import FORCES as MUTUAL
from laws.test_every_mutual_gravity import PAIR
from laws.test_every_orbit import ORBITS
from laws.test_every_part import PARTS
from poinsot.errors import refuse_other_length
from poinsot.functions import Vector
from poinsot.mechanics.environment import OrbitBlock
from poinsot.mechanics.frame import Frame
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.parameters import Parametric, kinds_of, of_each
from poinsot.mechanics.state import State, state_of
from poinsot.quantities import Rule, said_of

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


# ------------------------------------------------------------------ records of members


def varied(record, who):
    """Return a record whose numbers are other ones for each member, of all members or of one."""
    kinds, rules, own = kinds_of(type(record)), said_of(type(record), Rule), {}
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
    return np.asarray(np.multiply.outer(1 + share, value))


def records_within(record):
    """Yield a record and all records in it."""
    yield record
    for inner in record.records:
        yield from records_within(inner)


class World:
    """A system of all members, or of one, with arguments for its methods at some times."""

    def __init__(self, body, forces, who, times):
        self.who, self.times = who, times
        self.body, self.forces = varied(body, who), tuple(varied(force, who) for force in forces)
        bare = pt.System(body)
        self.system = bare.with_records((self.body, *self.forces))  # varied numbers need no check

    @property
    def records(self):
        return list(chain.from_iterable(map(records_within, (self.body, *self.forces))))

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
        names = [f"{body}_" if body else "" for body in self.system.body_names]
        phase = {f"{name}quaternion": self.turns(i) for i, name in enumerate(names)}
        phase |= {f"{name}{momentum}": self.rows(3, seed=i) for i, name in enumerate(names)}
        phase |= {block.name: self.rows(block.size, seed=4) for block in self.system.inner_blocks}
        return self.system.at(state_of(phase, np.broadcast_to(self.time, self.shape)))

    def argument(self, record, parameter):
        """Return the value of an argument by its name, as an array or as a vector of scalars by its annotation."""
        name, kind = parameter.name, parameter.annotation
        if name in ("instant", "time"):
            return getattr(self, name)
        if name == "orbit":
            return next(x for x in self.records if isinstance(x, pt.Orbit))
        if kind == "int":
            return 2
        sizes = {"own": "size", "pull": "size", "speeds": "count", "angles": "angle_count", "rates": "angle_count"}
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
        if name in CALLS:
            return CALLS[name](record, self)
        parameters = inspect.signature(attribute).parameters.values()
        return attribute(*(self.argument(record, parameter) for parameter in parameters))


CALLS = {
    "state": lambda body, world: None,
    "kinetics": lambda body, world: body.kinetics(),
}
"""Calls of methods whose arguments are not the ones of formulas."""

BOOKKEEPING = {
    **dict.fromkeys(("records", "numbers", "number_names", "structure", "definition"), "what the record is made of"),
    **dict.fromkeys(("member_axis", "with_axes", "with_numbers", "unchecked"), "the mechanism that is tested here"),
    **dict.fromkeys(("between_knots", "knots", "pieces", "piece"), "the tables, which all members share"),
    **dict.fromkeys(("check", "check_start", "refuse_inertia", "refuse_moved_orbit"), "a check without a result"),
    **dict.fromkeys(("synchronous", "doubly_synchronous", "state_on", "kick"), "a start, see the laws of pairs"),
    **dict.fromkeys(("on", "joined"), "another record of the same numbers"),
    "own": "the variables of an instant, which are arrays of its own",
}
"""Public attributes that are no values, and the reasons."""


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
    if isinstance(got, Rotation):
        got, each = got.as_quat(), [one.as_quat() for one in each]
    if isinstance(got, Frame):
        for name in ("quaternion", "omega_space"):
            values = [getattr(one, name)(world.time) for one in each]
            assert_same(getattr(got, name)(world.time), values, world, f"{what}.{name}")
    if isinstance(got, Instant):
        pairs = {"quaternion": lambda x: x.attitude.quaternion, "omega": lambda x: x.omega_body}
        return [assert_same(f(got), [f(one) for one in each], world, f"{what} {n}") for n, f in pairs.items()]
    if isinstance(got, Parametric):
        assert {one.structure for one in each} == {got.structure}, what
        return assert_same(got.numbers, [one.numbers for one in each], world, what)
    if isinstance(got, Frame) or first is None or isinstance(first, str | bool | type | slice) or callable(first):
        return None
    if isinstance(first, Mapping):
        assert all(one.keys() == got.keys() for one in each), what
        return [assert_same(got[key], [one[key] for one in each], world, f"{what}[{key!r}]") for key in got]
    if isinstance(first, tuple | list | Vector) or (isinstance(first, np.ndarray) and first.dtype == object):
        assert all(len(one) == len(got) for one in each), what
        return [assert_same(x, [one[i] for one in each], world, f"{what}[{i}]") for i, x in enumerate(got)]
    if isinstance(first, State):
        return assert_same({**got.phase}, [{**one.phase} for one in each], world, what)
    return assert_numbers(got, each, world, what)


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
PARTICULAR = (Straight(1.0, (1.0, 0.2, -0.3), (0.1, 0.9, 0.2)),)
SINGLE = {
    **{f"force {i} {type(force).__name__}": (BODY, force) for i, force in enumerate((*FORCES, *LAWS, *SAMPLED))},
    **{f"part {i} {type(part).__name__}": (OBLIQUE, part) for i, part in enumerate(PARTS)},
    **{f"orbit {name}": (BODY, pt.GravityGradient(orbit)) for name, orbit in ORBITS.items()},
    **{f"orbit {type(orbit).__name__}": (BODY, pt.GravityGradient(orbit)) for orbit in PARTICULAR},
}
PAIRS = {f"pair {type(force).__name__}": (PAIR, force) for force in MUTUAL}
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
            try:
                values = [one.value(one.records[i], attribute) for one in each]
            except (ValueError, AttributeError) as error:
                with pytest.raises(type(error)):
                    whole.value(record, attribute)
                continue
            assert_same(whole.value(record, attribute), values, whole, what)
