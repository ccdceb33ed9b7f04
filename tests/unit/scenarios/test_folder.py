"""Scenarios that name shapes and files: what they make, what results keep of it, and that no name leads out."""

import os
from typing import Any

import numpy as np
import pytest

import forked
import poinsot as pt
from poinsot.files.scenario import parsed_scenario, repetition
from tumbling import CALENDAR
from unit.files.test_netcdf import assert_same, why_not

SCENARIO = """\
title = "from files"
units.time = "s"
{body}
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0, 0.1, 0.001]
{rest}
[times]
stop = 100
count = 6
"""

BODY = "body.moments = [400, 500, 600]"

TETRAHEDRON = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"

FIELD = (
    "begin_of_head\nradius 1.5\nmax_degree 2\nnorm unnormalized\nend_of_head\n"
    "gfc 0 0 1 0\ngfc 1 0 0 0\ngfc 1 1 0 0\ngfc 2 0 -0.02 0\ngfc 2 1 0 0\ngfc 2 2 0.01 0\n"
)

MESH = '[body]\ntype = "Body.from_shape"\n[body.shape]\ntype = "read_mesh"\npath = "{path}"\nmass = 7\n'

GRADIENT = '[[forces]]\ntype = "GravityGradient"\norbit = "it"\n[orbits.it]\n'


def oem():
    """A circle about the Earth in 20 rows."""
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.0, inclination=0.3, node=0.1)
    rows = []
    for t in np.arange(0.0, 400.0, 20.0):
        numbers = (*orbit.position_at(t), *orbit.velocity_at(t))
        rows.append(f"2026-11-21T00:{int(t // 60):02}:{int(t % 60):02} " + " ".join(f"{x:.12f}" for x in numbers))
    meta = "OBJECT_NAME = A\nOBJECT_ID = B\nCENTER_NAME = EARTH\nREF_FRAME = ICRF\nTIME_SYSTEM = TDB\n"
    return f"CCSDS_OEM_VERS = 2.0\nMETA_START\n{meta}META_STOP\n" + "\n".join(rows) + "\n"


class Push(pt.Torque):
    """Of others."""

    size: float

    def torque(self, instant):
        on = pt.functions.where(pt.functions.less(instant.time, 0.5), self.size, 0.0)
        return (on, 0.0, 0.0)


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "scenarios"
    (place / "below").mkdir(parents=True)
    (place / "below" / "t.obj").write_text(TETRAHEDRON)
    (place / "f.gfc").write_text(FIELD)
    (place / "o.oem").write_text(oem())
    (tmp_path / "secret.obj").write_text(TETRAHEDRON)
    return place


def read(folder, body=BODY, rest=""):
    path = folder / "it.toml"
    path.write_text(SCENARIO.format(body=body, rest=rest))
    return pt.files.read_scenario(path)


def assert_same_after_saving(scenario, folder, tmp_path):
    """The result comes back and runs again to the bit where the files are gone."""
    motion = scenario.propagate(progress=False)
    path = pt.save(motion, tmp_path / "result.nc")
    for file in folder.rglob("*"):
        if file.is_file():
            file.unlink()
    back = pt.load(path)
    assert_same(motion, back)
    again = repetition(back, str(path)).propagate(progress=False)
    assert_same(motion, again)
    assert_same(motion, pt.load(pt.save(again, tmp_path / "again.nc")))
    assert back.provenance["scenario"] == scenario.provenance["scenario"]
    return back


# ------------------------------------------------------------------ shapes


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ('type = "Mesh.from_box"\nsides = [1, 2, 3]\nmass = 4', pt.shapes.Mesh.from_box((1, 2, 3), mass=4)),
        (
            'type = "Cylinder"\nradius = 1\nheight = 2\ndensity = 3\n'
            "position = [0, 0, 1]\nquaternion = [0.8, 0.6, 0, 0]",
            pt.shapes.Cylinder(1, 2, density=3).moved((0, 0, 1), (0.8, 0.6, 0, 0)),
        ),
        (
            'type = "Ellipsoid"\nsemiaxes = [1, 2, 3]\nmass = 3\nmatrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]',
            pt.shapes.Ellipsoid((1, 2, 3), mass=3).moved(attitude=(0.5**0.5, 0, 0, 0.5**0.5)),
        ),
        (
            'type = "Mascons"\nmasses = [1, 2, 3]\npositions = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]',
            pt.shapes.Mascons([1, 2, 3], np.eye(3)),
        ),
        (
            'type = "Mesh"\nmass = 2\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]\n'
            "faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]",
            pt.shapes.Mesh(np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], mass=2),
        ),
        (
            'type = "Assembly"\n[[body.shape.parts]]\ntype = "Mesh.from_box"\nsides = [1, 1, 1]\nmass = 4\n'
            '[[body.shape.parts]]\ntype = "Cylinder"\nradius = 0.1\nheight = 3\nmass = 1\nposition = [2, 0, 0]',
            pt.shapes.Assembly(
                [pt.shapes.Mesh.from_box((1, 1, 1), mass=4), pt.shapes.Cylinder(0.1, 3, mass=1).moved((2, 0, 0))],
            ),
        ),
    ],
    ids=lambda it: type(it).__name__ if isinstance(it, pt.shapes.Shape) else "",
)
def test_every_shape(folder, tmp_path, text, shape):
    scenario = read(folder, f'[body]\ntype = "Body.from_shape"\n[body.shape]\n{text}')
    np.testing.assert_allclose(scenario.system.body.inertia, pt.Body.from_shape(shape).inertia, rtol=4e-15, atol=1e-14)
    assert type(scenario.system.body.shape) is type(shape)
    back = assert_same_after_saving(scenario, folder, tmp_path)
    stored = back.system.body.shape
    assert type(stored) is type(shape)
    np.testing.assert_allclose(stored.center_of_mass, shape.center_of_mass, rtol=0, atol=1e-15)
    assert stored.mass == pytest.approx(shape.mass, rel=1e-15, abs=0)


def test_shapes_of_python_are_preserved_to_the_bit(tmp_path):
    turned = {"attitude": (0.1, 0.5, 0.5, 0.7), "position": (0.3, -0.2, 5)}
    unit = turned | {"attitude": np.array(turned["attitude"]) / np.linalg.norm(turned["attitude"])}
    parts = [
        pt.shapes.Mesh.from_box((1, 2, 3), mass=5),
        pt.shapes.Ellipsoid((1, 2, 3), mass=1 / 3),
        pt.shapes.Cylinder(0.1, 4, density=0.7),
    ]
    turned_parts = [part.moved(**unit) for part in parts]
    shape = pt.shapes.Assembly(
        [*turned_parts, pt.shapes.Assembly([pt.shapes.Mascons([1, 2], [[1, 0, 0], [0, 1 / 3, 0]])])]
    )
    body = pt.Body.from_shape(shape)
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    motion = pt.propagate(pt.System(body), start, [0.0, 1.0])
    back = pt.load(pt.save(motion, tmp_path / "it.nc"))
    *solids, points = back.system.body.shape.parts
    for own, stored in zip(turned_parts, solids, strict=True):
        assert own.mass == stored.mass
        assert np.array_equal(own.center_of_mass, stored.center_of_mass)
        assert np.array_equal(own.inertia, stored.inertia)
    assert points.positions.tolist() == [[1, 0, 0], [0, 1 / 3, 0]]
    assert np.array_equal(repetition(back, "it").propagate(progress=False).quaternion, motion.quaternion)


def test_shapes_are_preserved_where_forces_are_not(tmp_path):
    grid = np.mgrid[-1:1:9j, -1:1:9j, -1:1:9j].reshape(3, -1).T
    body = pt.Body.from_shape(pt.shapes.Mascons(np.arange(1.0, len(grid) + 1), grid * (1, 2, 3)))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    motion = pt.propagate(pt.System(body, Push(1.0)), start, [0.0, 1.0])
    back = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert why_not(back) == "the classes of a scenario must be the package's own, got Push."
    assert np.array_equal(back.system.body.shape.positions, body.shape.positions)
    with pytest.raises(ValueError, match=r"it\.nc cannot be run again: .* got Push"):
        repetition(back, "it.nc")


def test_shapes_of_others_are_left_out(tmp_path):
    class Odd(pt.shapes.Ellipsoid):
        """Of others."""

    body = pt.Body.from_shape(Odd((1, 2, 3), mass=1.0))
    motion = pt.free_motion(body, body.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])
    back = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert back.system.body.shape is None
    assert np.array_equal(repetition(back, "it").propagate().quaternion, motion.quaternion)


# ------------------------------------------------------------------ files


def test_mesh(folder, tmp_path):
    scenario = read(folder, MESH.format(path="below/t.obj"))
    wanted = pt.Body.from_shape(pt.files.read_mesh(folder / "below" / "t.obj", mass=7))
    assert np.array_equal(scenario.system.body.inertia, wanted.inertia)
    back = assert_same_after_saving(scenario, folder, tmp_path)
    assert np.array_equal(back.system.body.shape.vertices, wanted.shape.vertices)
    assert np.array_equal(back.system.body.shape.faces, wanted.shape.faces)


def test_field(folder, tmp_path):
    force = '[[forces]]\ntype = "HarmonicGravity"\norbit = "it"\n[forces.field]\ntype = "read_field"\n'
    force += 'path = "f.gfc"\nmass = 10\n'
    orbit = '[orbits.it]\ntype = "FixedPosition"\nmu = 3000\nposition = [50, 3, 0]\n'
    moments = 'body = {type = "Body.from_stokes", C20 = -0.02, C22 = 0.01, polar_moment_factor = 0.4, '
    scenario = read(folder, moments + "mass = 10, radius = 1.5}", force + orbit)
    (gravity,) = scenario.system.forces
    assert gravity.field.C[2].tolist() == [-0.02, 0, 0.01]
    assert_same_after_saving(scenario, folder, tmp_path)


def test_orbit_message(folder, tmp_path):
    pytest.importorskip("astropy")
    rest = GRADIENT + 'type = "read_oem"\npath = "o.oem"\n'
    scenario = read(folder, rest=rest)
    assert scenario.system.calendar == pt.Calendar("2026-11-21T00:00:00", "TDB")
    back = assert_same_after_saving(scenario, folder, tmp_path)
    assert back.system.calendar == scenario.system.calendar
    assert pt.files.write_aem(back, tmp_path / "it.aem").exists()


def test_kernels(folder, tmp_path):
    spice = pytest.importorskip("spiceypy")
    pytest.importorskip("astropy")
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.05, inclination=0.3, node=0.1)
    times = np.linspace(-100, 300, 81)
    states = np.stack([*orbit.position_at(times), *orbit.velocity_at(times)], axis=-1)
    handle = spice.spkopn(str(folder / "below" / "o.bsp"), "it", 0)
    spice.spkw09(handle, -77, 399, "J2000", times[0], times[-1], "it", 7, len(times), states, times)
    spice.spkcls(handle)
    rest = GRADIENT + 'type = "spice_orbit"\ntarget = "-77"\ncenter = "399"\nstart = -50\nstop = 200\n'
    scenario = read(folder, rest=rest + 'kernels = ["below/o.bsp"]\n')
    np.testing.assert_allclose(
        scenario.system.forces[0].orbit.position_at(30.0), orbit.position_at(30.0), rtol=0, atol=1e-9
    )
    assert_same_after_saving(scenario, folder, tmp_path)
    (folder / "below").mkdir(exist_ok=True)
    (folder / "index.tm").write_text("KPL/MK\n\\begindata\nkernels_to_load = ('/etc/passwd')\n\\begintext\n")
    with pytest.raises(ValueError, match=r"in orbits\.it, .*index\.tm must be a kernel that loads no others"):
        read(folder, rest=rest + 'kernels = ["index.tm"]\n')


def test_ephemerides_of_python_run_again_in_another_process(tmp_path):
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.05, inclination=0.3, node=0.1)
    labels = {"reference_frame": "ICRF", "origin": "EARTH", "calendar": CALENDAR}
    fitted = pt.orbits.Ephemeris.from_function(
        orbit.mu, position=lambda t: np.stack(list(orbit.position_at(t)), -1), start=0, stop=6000, **labels
    )
    times = np.linspace(0, 6000, 61)
    r, v = (np.stack(list(part(times)), -1) for part in (orbit.position_at, orbit.velocity_at))
    other = pt.orbits.Ephemeris.from_table(orbit.mu, times=times, positions=r, velocities=v)
    body = pt.Body((4.0, 5.0, 6.0))
    system = pt.System(
        body, pt.GravityGradient(fitted), pt.GravityGradient(other), pt.forces.Oblateness(fitted, 1e-3, 1.0, (0, 0, 1))
    )
    start = body.state((1, 0, 0, 0), omega_body=(0.001, 0, 0))
    motion = pt.propagate(system, start, np.linspace(0, 5000, 11), progress=False)
    path = pt.save(motion, tmp_path / "it.nc")
    back: Any = pt.load(path)
    assert_same(motion, back)
    assert back.system.forces[0].orbit is back.system.forces[2].orbit
    assert repr(back.system) == repr(system)
    assert back.system.calendar == CALENDAR
    code = (
        "import sys, poinsot as pt\nfrom poinsot.files.scenario import repetition\n"
        "again = repetition(pt.load(sys.argv[1]), 'it').propagate(progress=False)\npt.save(again, sys.argv[2])"
    )
    done = forked.run(code, path, tmp_path / "again.nc")
    assert done.returncode == 0, done.stderr
    assert_same(motion, pt.load(tmp_path / "again.nc"))
    text = tmp_path / "text.toml"
    text.write_text(back.provenance["scenario"] + "[state]\nquaternion = [1, 0, 0, 0]\nomega_body = [0, 0, 0]\n")
    with pytest.raises(ValueError, match="must be numbers, got the name of an array in a result"):
        pt.files.read_scenario(text)


OUT = {
    "../secret.obj": "must be a path from the folder of the scenario to a file in it or below, got '../secret.obj'.",
    "below/../../secret.obj": "must be a path from the folder of the scenario to a file in it or below, got",
    "/etc/passwd": "must be a path from the folder of the scenario to a file in it or below, got '/etc/passwd'.",
    "~/secret.obj": "must be a path from the folder of the scenario to a file in it or below, got",
    "C:\\\\secret.obj": "must be a path from the folder of the scenario to a file in it or below, got",
    "": "must be a path from the folder of the scenario to a file in it or below, got ''.",
    "link.obj": "must be a file in the scenario's folder, got 'link.obj', which links out of it.",
    "out/secret.obj": "must be a file in the scenario's folder, got 'out/secret.obj', which links out of it.",
    "loop.obj": "must be a file in the folder of the scenario, got 'loop.obj': no such file.",
    "none.obj": "must be a file in the folder of the scenario, got 'none.obj': no such file.",
    "below": "must be a file, got 'below', a folder or a device.",
    "x" * 300: "must be a file in the folder of the scenario, got",
}


@pytest.mark.parametrize("name", OUT)
def test_no_name_leads_out(folder, tmp_path, name):
    (folder / "link.obj").symlink_to(tmp_path / "secret.obj")
    (folder / "out").symlink_to(tmp_path)
    (folder / "loop.obj").symlink_to(folder / "loop.obj")
    with pytest.raises(ValueError, match=r"it\.toml, line 7: body\.shape\.path must") as caught:
        read(folder, MESH.format(path=name))
    assert OUT[name] in str(caught.value)


def test_links_within_the_folder_are_right(folder):
    (folder / "link.obj").symlink_to(folder / "below" / "t.obj")
    assert read(folder, MESH.format(path="link.obj")).system.body.shape is not None


def test_a_text_without_a_folder_names_no_file():
    text = SCENARIO.format(body=MESH.format(path="below/t.obj"), rest="")
    with pytest.raises(ValueError, match=r"path must not be in a text without a folder, got the name of a file\."):
        parsed_scenario(text, "it")


def test_pipes_are_no_files(folder):
    os.mkfifo(folder / "pipe.obj")
    with pytest.raises(ValueError, match=r"must be a file, got 'pipe\.obj', a folder or a device\."):
        read(folder, MESH.format(path="pipe.obj"))


def test_wrong_files_are_reported_with_their_key(folder):
    (folder / "t.obj").write_text("v 0 0\n")
    with pytest.raises(ValueError, match=r"line 5: in body\.shape, .*t\.obj: the file must (be OBJ|have faces)"):
        read(folder, MESH.format(path="t.obj"))
    with pytest.raises(ValueError, match=r"unknown key 'mas' in \[body\.shape\]\. Did you mean 'mass'\?"):
        read(folder, MESH.format(path="t.obj").replace("mass", "mas"))
    with pytest.raises(ValueError, match=r"body\.shape\.type must name a known type, .* Did you mean 'Ellipsoid'\?"):
        read(folder, MESH.format(path="t.obj").replace("read_mesh", "Elipsoid"))
    parts = '[body]\ntype = "Body.from_shape"\n[body.shape]\ntype = "Assembly"\n[[body.shape.parts]]\n'
    parts += 'type = "Mesh.from_box"\n'
    with pytest.raises(ValueError, match=r"unknown key 'side' in body\.shape\.parts\[0\]\. Did you mean 'sides'\?"):
        read(folder, parts + "mass = 1\nside = [1, 1, 1]")


# ------------------------------------------------------------------ dates


def test_results_say_what_their_times_mean(folder, tmp_path):
    """By the calendar of a scenario without dated orbits; the times themselves stay numbers, to the bit."""
    pytest.importorskip("astropy")
    path = folder / "it.toml"
    line = 'calendar = {zero = "2026-11-21", scale = "UTC", unit = "h"}\n'
    path.write_text(SCENARIO.format(body=BODY, rest="").replace('units.time = "s"\n', line))
    motion = pt.files.read_scenario(path).propagate(progress=False)
    back = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert_same(motion, back)
    time = back.dataset["time"]
    assert time.attrs == {
        "units": "h",
        "long_name": "time since 2026-11-21T00:00:00 UTC, counted in TAI",
        "epoch": "2026-11-21T00:00:00",
        "scale": "UTC",
        "counted_in": "TAI",
    }
    table = pt.files.read_aem(pt.files.write_aem(back, tmp_path / "it.aem", reference_frame="ICRF"))
    assert table.calendar.date(table.times[-1]).isot == "2026-11-25T04:00:00.000"
    assert np.max(table.angle_to(back)) < 1e-14
    with pytest.raises(
        ValueError, match=r"calendar must be the calendar of the motion, Calendar\(zero='2026-11-21T00:00:00'"
    ):
        pt.files.write_aem(back, tmp_path / "b.aem", reference_frame="ICRF", calendar=CALENDAR)


def test_dates_and_axes_are_preserved_where_forces_are_not(tmp_path):
    pytest.importorskip("astropy")
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.05, inclination=0.3, node=0.1)
    labels = {"reference_frame": "ICRF", "origin": "EARTH", "calendar": CALENDAR}
    fitted = pt.orbits.Ephemeris.from_function(
        orbit.mu, position=lambda t: np.stack(list(orbit.position_at(t)), -1), start=0, stop=600, **labels
    )
    body = pt.Body((4.0, 5.0, 6.0))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3))
    motion = pt.propagate(pt.System(body, pt.GravityGradient(fitted), Push(0.1)), start, [0.0, 1.0, 5.0])
    back = pt.load(pt.save(motion, tmp_path / "it.nc"))
    assert_same(motion, back)
    text = [pt.files.write_aem(one, tmp_path / f"{i}.aem").read_text() for i, one in enumerate((motion, back))]
    assert text[0].split("META_START")[1] == text[1].split("META_START")[1]


@pytest.mark.parametrize("missing", ["calendar", "reference_frame"])
def test_what_a_writer_misses_is_named(tmp_path, missing):
    from tumbling import MOTION, NAMED

    with pytest.raises(ValueError, match=f"^{missing} must be given .* {missing}=."):
        pt.files.write_aem(
            MOTION, tmp_path / "it.aem", **{key: value for key, value in NAMED.items() if key != missing}
        )
