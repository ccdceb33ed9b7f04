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

__all__ = ["GROUPS", "pages", "run_examples"]

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"

GROUPS = {
    "Spacecraft": "cubesat detumbling desaturation digital_slew dual_spin explorer_1 gravity_gradient_satellite "
    "boom_satellite boom_deployment thermal_snap attitude_covariance jeod_run_10a paper_satellite",
    "Between Earth and Moon": "halo_orbit libration_point",
    "Moons and planets": "hyperion phobos europa io titan moon mercury cassini_states forced_librations "
    "librations_of_worlds tidal_despinning spin_orbit_capture",
    "Asteroids": "apophis apophis_ensemble toutatis yorp contact_binary series_of_gravity",
    "Two bodies": "dart didymos dimorphos_map moshup patroclus",
    "Tops": "heavy_top",
    "Sections and maps": "poincare_hyperion heavy_body_section megno_map",
}
"""The examples, by what they are of."""

SCENE = """
import sys
import matplotlib.pyplot as plt
import numpy as np
import poinsot as pt
motion = pt.files.read_scenario(sys.argv[1]).propagate(progress=False)
pt.view(motion.member(0) if motion.is_ensemble else motion, sys.argv[2], overwrite=True)
if len(motion.of_bodies) > 1:
    panels = pt.plot.mutual_orbit(motion)
else:
    rates = np.linalg.norm(motion.omega_body, axis=-1)
    steady = np.ptp(rates) < 0.01 * np.max(rates)
    panels = pt.plot.quaternions(motion) if steady else pt.plot.angular_velocity(motion)
np.ravel(panels)[0].figure.savefig("scenario.png", dpi=110)
"""
"""Draws a scenario, by the attitude where the angular velocity is constant; the first member of an ensemble plays."""


def run_examples(folder: Path, scenes: Path) -> None:
    """Run those that have changed, on all cores, each in a folder of its own; `make clean` has all run again."""
    scenes.mkdir(parents=True, exist_ok=True)
    names = [name for group in GROUPS.values() for name in group.split()]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda name: run(name, folder / name, scenes / f"{name}.html"), names))


def run(name: str, folder: Path, page: Path) -> None:
    """Run the program and the scenario of one example, and keep what they write and print; the latter has a page."""
    files = [path for path in sources(name) if path.exists()]
    key = hashlib.sha256(b"".join([SCENE.encode(), *(path.read_bytes() for path in files)])).hexdigest()
    stamp = folder / "key.txt"
    if stamp.exists() and stamp.read_text() == key:
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path in files:
        program = [str(path)] if path.suffix == ".py" else ["-c", SCENE, str(path), str(page)]
        done = subprocess.run(  # noqa: S603
            [sys.executable, *program],
            cwd=folder,
            env={**os.environ, "MPLBACKEND": "Agg"},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"{path.name} must run, got:\n{done.stderr}")
        (folder / f"{path.suffix[1:]}.txt").write_text(done.stdout)
    stamp.write_text(key)


def sources(name: str) -> tuple[Path, Path]:
    """Return the paths of the program and of the scenario of an example, of which one may be missing."""
    return EXAMPLES / f"{name}.py", EXAMPLES / f"{name}.toml"


def pages(folder: Path) -> dict[str, str]:
    """Return the text of each page by its path, of examples that have run in a folder."""
    names = [name for group in GROUPS.values() for name in group.split()]
    return {"gallery/index.md": index(folder), **{f"gallery/{name}.md": page(name, folder / name) for name in names}}


def told(name: str) -> tuple[str, str]:
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
    """Return the names of the pictures of an example, those of its program first."""
    drawn = sorted(path.name for path in folder.glob("*.png"))
    return sorted(drawn, key=lambda name: (name == "scenario.png", not name.startswith(folder.name), name))


def index(folder: Path) -> str:
    """Return the page of all, with a card for each."""
    parts = [
        "# Gallery",
        "Each program answers one question, checks its answer and draws it; scenarios play in their page.",
    ]
    for group, names in GROUPS.items():
        cards = "\n\n".join(card(name, folder / name) for name in names.split())
        listed = "\n".join(f"{told(name)[0]} <{name}>" for name in names.split())
        parts += [f"## {group}", f"::::{{grid}} 1 2 2 3\n:gutter: 3\n\n{cards}\n\n::::"]
        parts += [f"```{{toctree}}\n:hidden:\n\n{listed}\n```"]
    return "\n\n".join(parts) + "\n"


def card(name: str, folder: Path) -> str:
    """Return the card of one example."""
    title, _ = told(name)
    picture = f"{name}/{pictures(folder)[0]}"
    head = f":::{{grid-item-card}} {title}\n:link: {name}\n:link-type: doc\n:img-top: {picture}\n:img-alt: {title}"
    return f"{head}\n:::"


def page(name: str, folder: Path) -> str:
    """Return the page of one example."""
    title, text = told(name)
    program, scenario = sources(name)
    parts = [f"# {title}", linked(text)]
    drawn = [each for each in pictures(folder) if each != "scenario.png" or not program.exists()]
    parts += [f"![{title}]({name}/{each})" for each in drawn]
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
    frame = f'<iframe class="scene" src="{path}" title="{title}, in three dimensions" loading="lazy"></iframe>'
    return f'```{{raw}} html\n{frame}\n<p><a href="{path}">The same on a page of its own</a></p>\n```'
