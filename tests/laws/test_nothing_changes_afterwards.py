"""Every public object stays as it was made: assignment is refused, and arrays are read-only or copies."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import poinsot as pt
from kinds.records import RECORDS, SYSTEMS
from kinds.results import RESULTS
from poinsot.immutable import Immutable

TURNING = pt.RotatingFrame((1, 0, 0, 0), omega_space=(0, 0, 0.5))
CALENDAR = pt.Calendar("2026-11-21T00:00:00", "TT")
BODY = pt.Body.from_inertia([[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.2]])
OTHERS = {
    "body": lambda: pt.Body((1.25, 1.0, 0.75), mass=2.0),
    "body off its axes": lambda: BODY,
    "body of a shape": lambda: pt.Body.from_shape(pt.shapes.Ellipsoid((3, 2, 1), mass=1.0)),
    "homogeneous ellipsoid": lambda: pt.Body.from_ellipsoid(1.0, np.array([3.0, 2.0, 1.0])),
    "ellipsoid": lambda: pt.shapes.Ellipsoid((3, 2, 1), mass=1.0),
    "mesh": lambda: pt.shapes.Mesh.from_box((1, 2, 3), density=2.0),
    "mascons": lambda: pt.shapes.Mascons([1.0, 2.0, 1.5], [(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)]),
    "cylinder": lambda: pt.shapes.Cylinder(1.0, 2.0, mass=1.0),
    "frame": lambda: TURNING,
    "calendar": lambda: CALENDAR,
    "rotation": lambda: pt.orbits.RotationModel.iau("earth", calendar=CALENDAR),
    "facets": lambda: pt.forces.Facets.from_box((1, 2, 3), position=(0.1, 0.2, 0.3)),
    "libration point": lambda: pt.orbits.LagrangePointPath(1.0, 0.01, separation=1.0, point="L4"),
    "state": lambda: pt.State((1, 0, 0, 0), (0, 0.1, 0.2, 0.3), time=1.0),
    "states": lambda: BODY.state((1, 0, 0, 0), omega_body=[(0.1, 0.2, 0.3), (0.3, 0.2, 0.1)], time=[0.0, 1.0]),
    "environment": lambda: pt.mechanics.Environment(time=np.linspace(0, 1, 3)),
    **{f"system with {name}": lambda parts=parts: pt.System(*parts) for name, parts in SYSTEMS.items()},
    **{
        f"{kind} {number}, {type(record).__name__}": lambda record=record: record
        for kind, records in RECORDS.items()
        for number, record in enumerate(records)
    },
}
NOT_VALUES = {"dataset", "body_on_pairs"}
"""Attributes that contain no numbers of the object: data made anew at each access, and values of a formula's trial."""


def public(thing):
    """The public attributes of a thing, without methods, by name."""
    for name in object.__dir__(thing):
        if name.startswith("_") or name in NOT_VALUES:
            continue
        try:
            value = getattr(thing, name)
        except (AttributeError, ValueError, TypeError, KeyError, NotImplementedError):
            continue  # it does not exist for this object
        of_class = value is getattr(type(thing), name, None)
        if not of_class and (not callable(value) or isinstance(value, Immutable)):
            yield name, value


def arrays_in(value):
    """The arrays in a value, in dictionaries and tuples too."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict | list | tuple):
        for one in value.values() if isinstance(value, dict) else value:
            yield from arrays_in(one)


def written(array):
    """Write other values into an array, if it allows this; return whether it does."""
    if not array.flags.writeable or not array.size or array.dtype.kind not in "fiub":
        return False
    array[...] = ~array if array.dtype.kind == "b" else array + 1
    return True


def fixed(thing, depth=2):
    """Check that no attribute of a thing, nor of the objects that it contains, can be changed."""
    for name, value in list(public(thing)):
        assert type(value) is not dict or getattr(thing, name) is not value, name
        with pytest.raises((AttributeError, TypeError)):
            setattr(thing, name, value)
        for index, array in enumerate(arrays_in(value)):
            before = np.array(array)
            if written(array):
                again = list(arrays_in(getattr(thing, name)))[index]
                assert np.array_equal(again, before, equal_nan=before.dtype.kind == "f"), name
        if depth:
            for one in value if isinstance(value, tuple | list) else [value]:
                if isinstance(one, Immutable):
                    fixed(one, depth - 1)


@pytest.mark.parametrize("name", OTHERS)
def test_a_description_stays_as_it_was_made(name):
    thing = OTHERS[name]()
    fixed(thing)
    fixed(pickle.loads(pickle.dumps(thing)), 0)
    fixed(copy.deepcopy(thing), 0)


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_stays_as_it_was_computed(tmp_path, name):
    thing = RESULTS[name](tmp_path)
    for one in thing if isinstance(thing, list) else [thing]:
        if isinstance(one, Immutable):
            fixed(one, 1)
            fixed(pickle.loads(pickle.dumps(one)), 0)


def public_classes():
    spaces = (pt, pt.analysis, pt.control, pt.events, pt.files, pt.forces, pt.orbits, pt.parts, pt.shapes)
    found = {name: getattr(space, name) for space in spaces for name in space.__all__}
    without_numbers = pt.files.AttitudeFormat
    return {name: thing for name, thing in found.items() if isinstance(thing, type) and thing is not without_numbers}


@pytest.mark.parametrize("name", sorted(public_classes()))
def test_every_public_class_is_immutable(name):
    assert issubclass(public_classes()[name], Immutable | BaseException | tuple)


def test_the_arrays_of_the_user_are_copied_and_stay_writable():
    moments, center, times = np.array([1.25, 1.0, 0.75]), np.array([1.0, 0, 0]), np.linspace(0.0, 5.0, 6)
    q, Q = np.array([1.0, 0, 0, 0]), np.array([0, 0.2, 0.4, 0.6])
    vertices, edge = np.array(pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0).vertices), np.array([0.0, 0.0, 0.5])
    mesh = pt.shapes.Mesh(vertices, pt.shapes.Mesh.from_box((1, 2, 3), mass=1.0).faces, mass=1.0)
    turning = pt.RotatingFrame(q, omega_space=edge)
    system = pt.System(pt.Body(moments), pt.UniformGravity(0.5, center))
    state = pt.State(q, Q)
    motion = pt.propagate(system, state, times)
    expected = [np.array(x) for x in (motion.times, motion.omega_body, mesh.vertices, turning.omega_space(0.0))]
    for array in (moments, center, times, q, Q, vertices, edge):
        array += 1.0
    found = [motion.times, motion.omega_body, mesh.vertices, turning.omega_space(0.0)]
    assert all(map(np.array_equal, expected, found))
    again = pt.propagate(system, state, expected[0])
    assert np.array_equal(again.omega_body, expected[1])


def test_a_refused_assignment_names_the_attribute():
    system = pt.System(pt.Body((1.25, 1.0, 0.75)))
    with pytest.raises(dataclasses.FrozenInstanceError) as caught:
        system.body = pt.Body((5.0, 1.0, 5.5))
    assert str(caught.value) == "System.body must stay as it was made, got another value. Make another System."
    with pytest.raises(dataclasses.FrozenInstanceError):
        del system.body
    with pytest.raises(dataclasses.FrozenInstanceError):
        system.forces_of_another_name = ()
    with pytest.raises(TypeError) as refused:
        system.units["time"] = "h"
    message = "a dictionary must stay as it was made, got a change. Change a copy, dict(...)."
    assert str(refused.value) == message


def test_the_first_moments_are_integrated_after_a_refused_write():
    moments, omega = np.array([1.25, 1.0, 0.75]), (0.1, 0.2, 0.3)
    system = pt.System(pt.Body(moments))
    with pytest.raises(ValueError, match="read-only"):
        system.body.moments[:] = (5.0, 1.0, 5.5)
    found = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=omega), [5.0]).omega_body[0]
    expected = solve_ivp(lambda _, w: np.cross(moments * w, w) / moments, (0, 5), omega, rtol=1e-12, atol=1e-14).y[
        :, -1
    ]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)  # ten times the tolerance of the integration


class Leaning(pt.mechanics.Frame):
    """A frame of the user's own, whose `__init__` assigns an attribute twice."""

    def __init__(self, angle):
        self.angle = 0.0
        self.angle = angle

    def quaternion(self, time):
        turned = (np.cos(self.angle / 2), np.sin(self.angle / 2), 0.0, 0.0)
        return np.broadcast_to(turned, (*np.shape(time), 4))

    def omega_space(self, time):
        return np.zeros((*np.shape(time), 3))


def test_an_init_of_the_user_may_assign():
    frame = Leaning(0.3)
    assert frame.angle == 0.3
    with pytest.raises(dataclasses.FrozenInstanceError):
        frame.angle = 0.4
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 1.0])
    expected = (np.cos(0.15), -np.sin(0.15), 0, 0)
    np.testing.assert_allclose(motion.relative_to(frame).quaternion[0], expected, rtol=0, atol=1.2e-16)  # a rounding


def test_a_dataset_does_not_change_the_motion():
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 1.0])
    data, before = motion.dataset, np.array(motion.omega_body)
    for variable in data.variables.values():
        if variable.values.flags.writeable and variable.dtype.kind == "f":
            variable.values[...] += 1.0
    assert np.array_equal(motion.omega_body, before)
    assert motion.times.tolist() == [0.0, 1.0]
