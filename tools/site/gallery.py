"""The gallery: a page for each example, with its description, output and pictures, and its motion in 3D."""

from __future__ import annotations

import ast
import concurrent.futures
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from PIL import Image

from poinsot.plot.view import FRAME

__all__ = ["GROUPS", "pages", "run_examples"]

ROOT = Path(__file__).parents[2]
THUMBNAIL = 480
"""Side of a thumbnail, dots."""
EXAMPLES = ROOT / "examples"

GROUPS = {
    "Spacecraft": "cubesat detumbling desaturation digital_slew dual_spin explorer_1 gravity_gradient_satellite "
    "boom_satellite boom_deployment thermal_snap attitude_covariance jeod_run_10a paper_satellite",
    "Between Earth and Moon": "halo_orbit libration_point",
    "Moons and planets": "hyperion phobos europa io titan moon mercury cassini_states forced_librations "
    "librations_of_worlds tidal_despinning spin_orbit_capture",
    "Asteroids": "apophis apophis_ensemble toutatis yorp contact_binary series_of_gravity",
    "Observations": "ten_nights_of_apophis glinting_rocket eros_light_curves",
    "Two bodies": "dart didymos dimorphos_map moshup patroclus",
    "Tops": "heavy_top",
    "Sections and maps": "poincare_hyperion heavy_body_section megno_map",
}
"""Names of the examples by subject."""

QUESTIONS = {
    "cubesat": "Which torque disturbs the pointing of a CubeSat most?",
    "detumbling": "How fast do magnetorquers stop a thousand CubeSats?",
    "desaturation": "How do magnetorquers unload the reaction wheels?",
    "digital_slew": "How well does a digital controller point?",
    "dual_spin": "Which damper makes a dual-spin satellite stable?",
    "explorer_1": "Why did Explorer 1 end in a flat spin?",
    "gravity_gradient_satellite": "How does a satellite librate on a boom?",
    "boom_satellite": "How far does a boom satellite leave the vertical?",
    "boom_deployment": "What does a deploying boom do to the rotation?",
    "thermal_snap": "What happens to the attitude at sunrise?",
    "attitude_covariance": "How does the uncertainty of an attitude grow?",
    "jeod_run_10a": "Does poinsot agree with NASA's JEOD?",
    "paper_satellite": "How does the satellite of the paper rotate?",
    "halo_orbit": "How does a spacecraft rotate on a halo orbit?",
    "libration_point": "How does a body librate at a Lagrange point?",
    "hyperion": "Why does Hyperion tumble?",
    "phobos": "How large is the libration of Phobos?",
    "europa": "What are the free librations of Europa?",
    "io": "How large is the libration of Io in longitude?",
    "titan": "Where does Saturn stand in the sky of Titan?",
    "moon": "Where does the Earth stand in the sky of the Moon?",
    "mercury": "How does the Sun move in the sky of Mercury?",
    "cassini_states": "Which Cassini state does the Moon occupy?",
    "forced_librations": "How does eccentricity force librations?",
    "librations_of_worlds": "Do librations agree with published values?",
    "tidal_despinning": "How fast do tides slow a rotation?",
    "spin_orbit_capture": "Does the tide capture a planet in a resonance?",
    "apophis": "How will the Earth change Apophis in 2029?",
    "apophis_ensemble": "How do the rates of Apophis spread at the Earth?",
    "ten_nights_of_apophis": "Which periods of Apophis does a light curve contain?",
    "toutatis": "How do Sun and Earth change Toutatis?",
    "yorp": "How does sunlight change the obliquity of an asteroid?",
    "contact_binary": "Does a contact binary keep its long axis on the planet?",
    "series_of_gravity": "Which degree does a gravity field require?",
    "glinting_rocket": "When does a tumbling rocket body glint?",
    "eros_light_curves": "Does the pole of Eros fit seventy years of light curves?",
    "dart": "What does the impact of DART tell about Dimorphos?",
    "didymos": "How does Dimorphos move after the impact?",
    "dimorphos_map": "For which shapes does Dimorphos tumble?",
    "moshup": "How does the moon of Moshup librate?",
    "patroclus": "How do Patroclus and Menoetius librate?",
    "heavy_top": "How does a heavy top precess and nutate?",
    "poincare_hyperion": "Where is the rotation of Hyperion regular?",
    "heavy_body_section": "What does weak gravity do to a free body?",
    "megno_map": "Where is the rotation of a moon chaotic?",
}
"""The question that each example answers."""

SUPPLIED = {"eros_light_curves": ROOT / "docs" / "images" / "eros-light-curves.png"}
"""Examples that read a file of the user and are not run, with their pictures."""

DRAWING = Path(__file__).with_name("drawing.py")
"""Program that runs an example and draws its thumbnail."""


def run_examples(folder: Path, scenes: Path) -> None:
    """Run those that have changed, on all cores, each in a folder of its own; `make clean` has all run again."""
    scenes.mkdir(parents=True, exist_ok=True)
    names = [name for group in GROUPS.values() for name in group.split()]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda name: run(name, folder / name, scenes / f"{name}.html"), names))


def run(name: str, folder: Path, page: Path) -> None:
    """Run the program and the scenario of one example, and keep what they write and print; the latter has a page."""
    program, scenario = sources(name)
    files = [path for path in (program, scenario) if path.exists() and not (path == program and name in SUPPLIED)]
    key = hashlib.sha256(b"".join(path.read_bytes() for path in (DRAWING, *files))).hexdigest()
    stamp = folder / "key.txt"
    if stamp.exists() and stamp.read_text() == key:
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path in files:
        done = subprocess.run(  # noqa: S603
            [sys.executable, str(DRAWING), str(path), str(page)],
            cwd=folder,
            env={**os.environ, "MPLBACKEND": "Agg"},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"{path.name} must run, got:\n{done.stderr}")
        (folder / f"{path.suffix[1:]}.txt").write_text(done.stdout)
    if name in SUPPLIED:
        show_picture(name, folder)
    stamp.write_text(key)


def show_picture(name: str, folder: Path) -> None:
    """Copy the picture of a program that is not run, and write its left square as thumbnail."""
    with Image.open(SUPPLIED[name]) as picture:
        picture.save(folder / f"{name}.png")
        square = picture.convert("RGB").crop((0, 0, picture.height, picture.height))
        square.resize((THUMBNAIL, THUMBNAIL)).save(folder / "thumbnail.jpg")
    (folder / "py.txt").write_text("")


def sources(name: str) -> tuple[Path, Path]:
    """Return the paths of the program and of the scenario of an example, of which one may be missing."""
    return EXAMPLES / f"{name}.py", EXAMPLES / f"{name}.toml"


def pages(folder: Path) -> dict[str, str]:
    """Return the text of each page by its path, of examples that have run in a folder."""
    names = [name for group in GROUPS.values() for name in group.split()]
    return {"gallery/index.md": index(), **{f"gallery/{name}.md": page(name, folder / name) for name in names}}


def described(name: str) -> tuple[str, str]:
    """Return the title and the description of an example."""
    program, scenario = sources(name)
    if program.exists():
        title, _, text = (ast.get_docstring(ast.parse(program.read_text())) or "").partition("\n\n")
        return title.removesuffix("."), text
    lines = scenario.read_text().split("\n")
    comment = lines[: next(i for i, line in enumerate(lines) if not line.startswith("#"))]
    return tomllib.loads(scenario.read_text())["title"], "\n".join(line[1:].strip() for line in comment)


def linked(text: str) -> str:
    """Return a text with links to the pages and the examples that it names."""
    text = re.sub(r"\bdocs/(\w+)\.md", r"[\1](../../\1.md)", text)
    names = "|".join(name for group in GROUPS.values() for name in group.split())
    return re.sub(rf"\b({names})\.(?:py|toml)\b", r"[\1](\1.md)", text)


def pictures(folder: Path) -> list[str]:
    """Return the names of the pictures of an example, first the picture with the name of the example."""
    drawn = sorted(path.name for path in folder.glob("*.png"))
    return sorted(drawn, key=lambda name: (not name.startswith(folder.name), name))


def index() -> str:
    """Return the page of all, with a card for each."""
    parts = [
        "# Gallery",
        "Each example answers one question. Programs check and draw their answer; scenarios play as a 3D scene.",
    ]
    for group, names in GROUPS.items():
        cards = "\n\n".join(card(name) for name in names.split())
        listed = "\n".join(f"{described(name)[0]} <{name}>" for name in names.split())
        parts += [f"## {group}", f"::::{{grid}} 2 2 3 3\n:gutter: 3\n\n{cards}\n\n::::"]
        parts += [f"```{{toctree}}\n:hidden:\n\n{listed}\n```"]
    return "\n\n".join(parts) + "\n"


def card(name: str) -> str:
    """Return the card of one example."""
    title, _ = described(name)
    head = f":::{{grid-item-card}} {title}\n:link: {name}\n:link-type: doc\n:img-top: {name}/thumbnail.jpg"
    return f"{head}\n:img-alt: {title}\n\n{QUESTIONS[name]}\n:::"


def page(name: str, folder: Path) -> str:
    """Return the page of one example."""
    title, text = described(name)
    program, scenario = sources(name)
    parts = [f"# {title}", linked(text)]
    parts += [f"![{title}]({name}/{each})" for each in pictures(folder)]
    if scenario.exists():
        parts += [scene(name, title)]
    if program.exists():
        code = ast.parse(program.read_text()).body[1].lineno
        parts += ["## Program", f"```{{literalinclude}} ../../../examples/{name}.py\n:lines: {code}-\n```"]
        printed = (folder / "py.txt").read_text().rstrip()
        parts += ["It prints:", f"```text\n{printed}\n```"] if printed else []
    if scenario.exists():
        parts += ["## Scenario", f"`poinsot run {name}.toml`, then `poinsot view {name}.nc`:"]
        parts += [f"```{{literalinclude}} ../../../examples/{name}.toml\n:language: toml\n```"]
    return "\n\n".join(parts) + "\n"


def scene(name: str, title: str) -> str:
    """Return the frame in which the motion of a scenario plays."""
    path = f"../../scenes/{name}.html"
    frame = f'<iframe src="{path}" title="{title}, in three dimensions" loading="lazy"></iframe>'
    framed = f'<style>{FRAME}</style><div class="poinsot-view">{frame}</div>'
    return f'```{{raw}} html\n{framed}\n<p><a href="{path}">Open the scene on its own page</a></p>\n```'
