"""The table of output variables: one entry is a variable of trajectories, datasets, files and stores."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn
from poinsot.propagation import columns
from poinsot.propagation.columns import Column, Requirement, Scope

TIMES = np.linspace(0.0, 2.0, 5)
BODY = pt.Body((1.25, 1.0, 0.75))
MANY = np.array([(0.1, 0.2, 3.0), (0.3, 0.1, 2.0), (0.2, 0.2, 1.0)])


class Magnet(pt.Potential):
    """A class from outside the package, so that files do not contain the force."""

    moment_body: pt.mechanics.Vector

    def energy(self, instant):
        return -fn.dot(self.moment_body, instant.attitude.to_body((0, 0, 1.0)))


SYSTEM = pt.System(BODY, Magnet((0.1, 0.2, 0.3)), units={"time": "s", "inertia": "kg m2"})


def spin(block):
    g = block["angular_momentum_body"]
    return np.sum(g * block["omega_body"], axis=-1) / np.linalg.norm(g, axis=-1)


def power(block):
    torque = block.system.torques_body(block.state, block.environment)["Magnet"]
    return np.sum(torque * block["omega_body"], axis=-1)


SPIN = Column("spin", "rate", "angular velocity along the angular momentum", spin, scope=Scope.BODY)
NEEDS_FORCES = frozenset({Requirement.FORCES})
POWER = Column("power", "energy", "power of the magnet", power, scope=Scope.ONE_BODY, requires=NEEDS_FORCES)


@pytest.fixture(autouse=True)
def table(monkeypatch):
    monkeypatch.setattr(columns, "COLUMNS", (*columns.COLUMNS, SPIN, POWER))


def motion_of(rates: Any = (0.1, 0.2, 3.0), **options: Any):
    start = SYSTEM.state(np.broadcast_to((1.0, 0, 0, 0), (*np.shape(rates)[:-1], 4)), omega_body=rates)
    return pt.propagate(SYSTEM, start, TIMES, progress=False, **options)


def test_an_entry_is_a_variable_of_the_motion_and_of_its_dataset():
    motion = motion_of()
    expected = np.sum(motion.angular_momentum_body * motion.omega_body, axis=-1)
    expected /= np.linalg.norm(motion.angular_momentum_body, axis=-1)
    assert {"spin", "power"} <= {*motion.variable_names}
    assert np.array_equal(motion.column("spin"), expected)
    data = motion.variables(["spin"])["spin"]
    assert data.dims == ("time",)
    assert data.attrs == {"units": "rad s-1", "long_name": "angular velocity along the angular momentum"}
    assert np.array_equal(data, expected)
    assert np.array_equal(motion.dataset["spin"], expected)
    assert motion.dataset["power"].attrs["units"] == "kg m2 s-2"
    near = pt.propagate(SYSTEM, motion.initial, [1.0 - 1e-4, 1.0, 1.0 + 1e-4])
    assert near.column("power")[1] == pytest.approx(-np.gradient(near.potential_energy, 1e-4)[1], rel=1e-6)


def test_an_entry_is_in_tables_of_text():
    frame = motion_of().variables(["spin", "power"])[["spin", "power"]].to_dataframe()
    assert frame.to_csv().splitlines()[0] == "time,spin,power"


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("many", [False, True])
def test_an_entry_is_in_files(many, suffix, tmp_path):
    """The power requires the force, which the file does not contain; the spin follows from the states."""
    motion = motion_of(MANY if many else (0.1, 0.2, 3.0))
    read: Any = pt.load(pt.save(motion, tmp_path / f"it{suffix}"))
    assert type(read.system).__name__ == "RecordedSystem"
    for name in ("spin", "power"):
        assert np.array_equal(read.column(name), motion.column(name))
        assert np.array_equal(read.dataset[name], motion.dataset[name])
    again: Any = pt.load(pt.save(read, tmp_path / f"again{suffix}"))
    assert np.array_equal(again.column("power"), motion.column("power"))
    assert np.array_equal(read.isel(time=[1, 2]).column("power"), motion.column("power")[..., 1:3])


def test_an_entry_is_in_stores(tmp_path):
    motion, stored = motion_of(MANY), motion_of(MANY, out=tmp_path / "it.zarr", chunk=2)
    assert "power" in stored.dataset
    assert "spin" not in stored.dataset  # which follows from the states
    read: Any = pt.load(tmp_path / "it.zarr")
    for name in ("spin", "power"):
        assert np.array_equal(stored.column(name), motion.column(name))
        assert np.array_equal(read.column(name), motion.column(name))
        assert np.array_equal(read.member(2).column(name), motion.column(name)[2])
    chosen = motion_of(MANY, out=tmp_path / "spin.zarr", variables={"spin": {"every": 2}, "quaternion": {}})
    assert np.array_equal(chosen["spin"], motion.column("spin")[:, ::2])


def test_an_entry_of_each_body_is_read_from_primary_and_secondary():
    ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    spins = [(0, 0, 1.0), (0, 0.5, 0)]
    start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=spins)
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, TIMES)
    assert motion.dataset["secondary_spin"].attrs["long_name"].endswith(", of the secondary")
    assert np.array_equal(motion.column("secondary_spin"), motion.secondary.column("spin"))
    assert motion.secondary.column("spin") == pytest.approx(0.5)
    with pytest.raises(AttributeError, match=r"^a motion of two bodies has no spin\. Read primary\.spin"):
        motion.column("spin")


def test_columns_that_a_motion_does_not_have():
    motion = motion_of()
    with pytest.raises(AttributeError, match=r"^a motion of one body has no position: it belongs to a motion of two"):
        motion.column("position")
    with pytest.raises(ValueError, match=r"^name must be some of quaternion, .*, got 'spinn'\.$"):
        motion.column("spinn")
    with pytest.raises(TypeError, match=r"^name must be a text, got int 3\.$"):
        motion.column(3)


def test_every_entry_says_what_it_is():
    every = {**columns.static_columns(("",)), **columns.static_columns(("primary", "secondary"))}
    for name, column in every.items():
        assert column.name == name
        assert column.meaning
        assert column.axis in ("", "axis", "parameter", "variable")
        assert not name.endswith(("_body", "_space")) or column.attributes == {"frame": name.rpartition("_")[2]}


def test_velocity_of_a_pair_is_the_velocity_of_its_state():
    ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    start = pair.state((2, 0, 0), (0.1, 1, -0.2), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1), (0, 0, 0.5)])
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [0.0, 1.0])
    # One rounding in the momentum, one in the quotient.
    np.testing.assert_allclose(motion.column("velocity")[0], (0.1, 1, -0.2), rtol=4 * np.finfo(float).eps)
    assert np.array_equal(motion.velocity, motion.column("velocity"))
