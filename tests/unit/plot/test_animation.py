"""Films of motions: what is drawn, and how the files are written."""

import re
import stat
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image, ImageSequence
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.plot.solid_parts import triangles

LONG = pt.Body.from_shape(pt.shapes.Mesh.from_box((9.0, 2.0, 1.0), mass=2.0))


def spinning(rate=0.5, times=None):
    start = LONG.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    return pt.free_motion(LONG, start, np.linspace(0, np.pi, 64) if times is None else times)


def pictures(path):
    with Image.open(path) as film:
        for frame in ImageSequence.Iterator(film):
            yield np.asarray(frame.convert("RGB")).astype(int), frame.info["duration"]


def direction(picture):
    """The direction of the long side of a body in a picture, modulo half a turn, counterclockwise from the right."""
    red, green, blue = np.moveaxis(picture[:440], -1, 0)  # without the words below
    own = (blue > green) & (green > red) & (blue - red < 60) & (red > 80)
    y, x = np.nonzero(own)
    assert x.size > 5000
    covariance = np.cov(x, -y)
    return 0.5 * np.arctan2(2 * covariance[0, 1], covariance[0, 0] - covariance[1, 1])


@pytest.mark.parametrize("order", [1, -1])
def test_the_body_turns_in_the_film_as_it_does_in_the_motion(order, tmp_path):
    """Seen from the tip of omega it turns counterclockwise, by half a radian per unit of time, forwards in time."""
    path = pt.animate(spinning(times=np.linspace(0, np.pi, 64)[::order]), tmp_path / "a.gif", seconds=0.5, view=(90, 0))
    shown = list(pictures(path))
    assert len(shown) == 10
    assert {duration for _, duration in shown} == {50}
    angles = np.unwrap([direction(picture) for picture, _ in shown], period=np.pi)
    np.testing.assert_allclose(angles - angles[0], 0.5 * np.linspace(0, np.pi, 10), rtol=0, atol=0.03)


@pytest.mark.parametrize(
    ("shape", "rtol"),
    [
        (pt.shapes.Mesh.from_box((1.0, 2.0, 3.0), mass=1.0), 1e-12),
        (pt.shapes.Ellipsoid((1.0, 0.6, 0.4), mass=1.0), 0.05),
        (pt.shapes.Cylinder(0.5, 2.0, mass=1.0), 0.05),
    ],
    ids=["mesh", "ellipsoid", "cylinder"],
)
def test_a_body_is_drawn_as_its_shape_from_its_centre_of_mass(shape, rtol):
    """Volume and first moments of the solid within the triangles, outwards."""
    moved = shape.moved((3.0, -1.0, 2.0), Rotation.from_rotvec([0.4, 0.7, -0.3]))
    corners = triangles(pt.Body.from_shape(moved))
    volumes = np.linalg.det(corners) / 6
    exact = {"Mesh": 6.0, "Ellipsoid": 4 / 3 * np.pi * 0.24, "Cylinder": 0.5 * np.pi}[type(shape).__name__]
    assert np.sum(volumes) == pytest.approx(exact, rel=rtol, abs=0)
    np.testing.assert_allclose(
        np.sum(volumes[:, None] * np.mean(corners, axis=1), axis=0), 0, rtol=0, atol=1e-2 * exact
    )


def test_two_bodies_are_both_in_the_film(tmp_path):
    """Seen from above, the light one goes round the heavy one."""
    pair = pt.TwoBodies(pt.Body.from_ellipsoid(50.0, (1, 1, 1)), pt.Body.from_ellipsoid(1.0, (0.5, 0.5, 0.5)), G=1.0)
    start = pair.state((5, 0, 0), (0, np.sqrt(51 / 5), 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0)] * 2)
    quarter = 0.5 * np.pi * np.sqrt(5**3 / 51)
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, np.linspace(0, quarter, 40))
    first, *_, last = (
        picture for picture, _ in pictures(pt.animate(motion, tmp_path / "a.gif", seconds=0.2, view=(90, -90)))
    )
    for picture, side in ((first, np.s_[:, 360:]), (last, np.s_[:120, :])):
        assert np.mean(picture[side] < 240) > 0.02
    assert np.mean(last[:, 360:] < 240) < 0.02


# ---------------------------------------------------------------------- files


def test_the_sun_lights_one_side_and_arrows_point_to_sun_and_observer(tmp_path):
    """Seen from above with the Sun on the right, the right half is brighter, and the arrows have their colours."""
    ball = pt.Body.from_shape(pt.shapes.Ellipsoid((1.0, 1.0, 1.0), mass=1.0))
    start = ball.state((np.cos(0.3), 0, 0, np.sin(0.3)), omega_body=(0, 0, 1e-3))
    motion = pt.free_motion(ball, start, [0.0, 1.0])
    right, left = ((0, -5.0, 0), (0, 7.0, 0))  # seen from (90, 0) the second axis is on the right
    orbits = {name: pt.orbits.FixedPosition(1.0, position=at) for name, at in (("sun", right), ("observer", left))}
    path = pt.animate(motion, tmp_path / "a.gif", seconds=0.1, view=(90, 0), **orbits)
    picture, _ = next(iter(pictures(path)))
    brightness = np.sum(picture, axis=-1)
    middle, aside = picture.shape[1] // 2, 60
    rows = slice(middle - 90, middle - 30)
    assert np.mean(brightness[rows, middle + aside]) > 1.5 * np.mean(brightness[rows, middle - aside])
    bluer = picture[..., 2] - picture[..., 0]
    assert np.count_nonzero(bluer[:, middle + 120 :] < -100) > 50
    assert np.count_nonzero(bluer[:, : middle - 120] > 100) > 50


def test_a_film_as_mp4_is_read_back_by_ffmpeg(tmp_path):
    """Ten frames in half a second, in which the body turns as in the motion, in colours that players can show."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed")
    path = pt.animate(spinning(), tmp_path / "a.mp4", seconds=0.5, view=(90, 0))
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    read = subprocess.run([ffmpeg.get_ffmpeg_exe(), "-i", path, *raw], capture_output=True, check=True)
    for about in ("Duration: 00:00:00.50", "Video: h264", "yuv420p", "480x480", "20 fps"):
        assert about in read.stderr.decode()
    shown = np.frombuffer(read.stdout, np.uint8).reshape(10, 480, 480, 3).astype(int)
    angles = np.unwrap([direction(picture) for picture in shown], period=np.pi)
    np.testing.assert_allclose(angles - angles[0], 0.5 * np.linspace(0, np.pi, 10), rtol=0, atol=0.03)


@pytest.fixture
def no_ffmpeg(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    return tmp_path


def ffmpeg(folder, program):
    """Program of that name that stores its input, or fails."""
    path = folder / "ffmpeg"
    path.write_text(f"#!{sys.executable}\nimport sys\n{program}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_ffmpeg_is_given_every_frame(no_ffmpeg):
    ffmpeg(no_ffmpeg, "open(sys.argv[-1], 'wb').write(sys.stdin.buffer.read())")
    path = pt.animate(spinning(), no_ffmpeg / "a.mp4", seconds=0.2)
    assert path.stat().st_size == 4 * 480 * 480 * 3


def test_errors_contain_the_message_of_ffmpeg(no_ffmpeg):
    ffmpeg(no_ffmpeg, "sys.exit('no such codec')")
    with pytest.raises(
        OSError, match=r"^a\.mp4 must be a file that can be written, but ffmpeg reported: no such codec\.$"
    ):
        pt.animate(spinning(), no_ffmpeg / "a.mp4", seconds=0.2)
    assert {path.name for path in no_ffmpeg.iterdir()} == {"ffmpeg"}


def test_without_ffmpeg_there_is_one_sentence(no_ffmpeg):
    sentence = "ffmpeg must be installed to write .mp4, got none. Run `pip install imageio-ffmpeg`, or write a .gif."
    with pytest.raises(FileNotFoundError, match=f"^{re.escape(sentence)}$"):
        pt.animate(spinning(), no_ffmpeg / "a.mp4")
    assert not list(no_ffmpeg.iterdir())


REFUSED = {
    "suffix": ({"path": "a.avi"}, "path must end in .gif or .mp4, got 'a.avi'."),
    "seconds": ({"seconds": 0.0}, "seconds must be positive, got 0.0."),
    "endless": ({"seconds": np.inf}, "seconds must be finite, got seconds = inf."),
    "times": ({"motion": spinning(times=[1.0])}, "motion must have two times or more, got 1."),
}


@pytest.mark.parametrize("name", REFUSED)
def test_wrong_arguments_are_refused_in_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, sentence = REFUSED[name]
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        pt.animate(**{"motion": spinning(), "path": "a.gif", **given})
    assert not list(tmp_path.iterdir())
