"""Write what follows from the modules: the stubs of the namespaces, the JSON Schema and the tables of what there is.

`make face` does it; tests/house/test_face.py checks that it was done. A name is public if the `__all__` of its module
has it, but for those that modules share among themselves, which are listed here.
"""

from __future__ import annotations

import fnmatch
import importlib
import inspect
import json
import pkgutil
import re
import sys
from pathlib import Path
from typing import Any, get_args, get_type_hints

from poinsot.cli import app
from poinsot.cli.terminal import listed_formats
from poinsot.files.attitudes.attitude_format import attitude_formats
from poinsot.scenarios.schema import schema

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "poinsot"

SHARED = {
    "analysis": "continuation_problem.* multipliers.* pair_point.* period_map.* polhodes.* "
    "polynomial_search.* uneven_lines.* *.CROSSING_TOLERANCE *.HALF_TURNS *.coordinate_names *.NumberNames "
    "*.bifurcations *.grows_with_time *.motion_at",
    "control": "",
    "estimation": "",
    "events": "",
    "files": "attitudes.adm.* ccsds.* conversions.* keys.* reader_process.* spice*.* "
    "untrusted.* rows.* *.*_of *.rates_per_second *.dated_calendar "
    "*.attitude_formats *.parsed_scenario *.repetition "
    "observations.julian_rows.* *.*_in *.stated_calendar netcdf.READINGS *.ReadingsFoundError *_dataset",
    "forces": "point_masses.* same_body.* directional_torque.stream_torques directional_torque.sphere_nodes "
    "radiation.[A-Z][A-Z]* radiation.Sunlight radiation.visible_fraction facets.PLATE_DRAG_COEFFICIENT",
    "observables": "",
    "orbits": "angle_reduction.* attractors.* conic.* frame.* from_cartesian.* iau_rotations.* piecewise_chebyshev.* "
    "pole.* theories.* universal.* *.*Block *.*Frame *.CirclingPair *.ThreeBodyView fixed.components "
    "fixed.HeldPosition",
    "parts": "*.AttachedMass *.refuse_oblique",
    "plot": "animation.* curves.* figure.* labels.* page_*.* panels.* solid_parts.* solids.* view.* "
    "time_axis.* ensembles.Q* *.is_constant *.median_attitude",
    "shapes": "boxes.* brightness.* clipping.* cubature.* daily_shadows.* ellipsoid_light.* geodesic.* law_program.* "
    "polyhedron.* reflected_light.* scattering.* surface.* views.* visibility.ClearParts visibility.Slopes "
    "support.* visibility.clear_* winding.*",
}
"""Namespaces, and patterns of `module.name` that modules of the package share and that are not public."""

FOR_AUTHORS = {
    "environment": ("Environment",),
    "force": ("Load", "PairLoad"),
    "pair_instant": ("PairInstant",),
    "part": ("Jump",),
    ".kinematics.frame": ("Frame",),
    ".kinematics.state": ("project_to_tangent",),
    ".records.parameters": ("Vector",),
}
"""Public names of `mechanics` by module, relative to it. The root has its other public names."""

FROM_OTHER_PACKAGES = {"observables": ("shapes.scattering",)}
"""Namespaces with the public names of modules of lower packages."""

SHADOWING = {"map": "A004"}
"""Public names that are also Python's, and the rule of ruff that they break."""


def face() -> dict[Path, str]:
    """Return the files, by path, with what they must have."""
    spaces = [space for space in SHARED if (SOURCE / space / "__init__.pyi").exists()]
    names = {space: public_names(space) for space in spaces}
    names["mechanics"] = {name: module for module, listed in FOR_AUTHORS.items() for name in listed}
    for space, modules in FROM_OTHER_PACKAGES.items():
        for module in modules:
            listed = importlib.import_module(f"poinsot.{module}").__all__
            names[space] |= dict.fromkeys(listed, f".{module}")
    stubs = {SOURCE / space / "__init__.pyi": stub(space, found) for space, found in names.items()}
    tables = {
        ROOT / "docs" / "files.md": ("formats", formats_table()),
        ROOT / "docs" / "commands.md": ("reference", command_reference()),
    }
    texts = {path: filled(path.read_text(), *table) for path, table in tables.items()}
    return {**stubs, ROOT / "docs" / "scenario.schema.json": json.dumps(schema(), indent=1) + "\n", **texts}


def public_names(space: str) -> dict[str, str]:
    """Return the module of each public name of a namespace, relative to it."""
    package = importlib.import_module(f"poinsot.{space}")
    patterns = SHARED[space].split()
    found: dict[str, str] = {}
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        inside = module.name.removeprefix(f"{package.__name__}.")
        if not module.ispkg and not any(fnmatch.fnmatchcase(f"{inside}.?", pattern) for pattern in patterns):
            names = importlib.import_module(module.name).__all__
            found |= {name: inside for name in names if not is_shared(f"{inside}.{name}", patterns)}
    return found


def is_shared(name: str, patterns: list[str]) -> bool:
    """Return True if a name is shared inside the package and not public."""
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def stub(space: str, found: dict[str, str]) -> str:
    """Return the stub of a namespace."""
    lines = [f'"""The public names of poinsot.{space}, by the module of each, as `make face` writes them."""', ""]
    for module in sorted(set(found.values())):
        names = sorted((name for name in found if found[name] == module), key=lambda x: (not x[0].isupper(), x))
        noqa = "".join(f"  # noqa: {rule}" for name, rule in SHADOWING.items() if name in names)
        line = f"from .{module} import {', '.join(names)}{noqa}"
        lines += [line] if len(line) <= 120 else [f"from .{module} import (", *(f"    {x}," for x in names), ")"]
    listed = [f'    "{name}",' for name in sorted(found)]
    noqa = "  # noqa: RUF022" * any(name.isupper() for name in found)  # a class in capitals is no constant
    return "\n".join([*lines, "", f"__all__ = [{noqa}", *listed, "]", ""])


def formats_table() -> str:
    """Return the formats of attitude files, with the conventions of each."""
    rows = [
        (
            f"{each.title} ({', '.join(f'`{end}`' for end in each.suffixes)})",
            f"`{each.write.__name__}`, `{each.read.__name__}`",
            *each.conventions,
        )
        for each in attitude_formats()
    ]
    heading = "| format | write, read | order | direction | rates |\n|---|---|---|---|---|"
    return "\n".join([heading, *(f"| {' | '.join(row)} |" for row in rows)])


def command_reference() -> str:
    """Return one section for each command, with the texts of its `--help`."""
    return "\n\n".join(command_page(command) for command in app.registered_commands)


def command_page(command: Any) -> str:
    """Return the section of a command: usage, description, arguments and options."""
    hints = get_type_hints(command.callback, include_extras=True)
    parameters = inspect.signature(command.callback).parameters.values()
    rows = [parameter_row(parameter, *get_args(hints[parameter.name])) for parameter in parameters]
    called = " ".join(["poinsot", command.callback.__name__, *(usage for usage, _, _ in rows)])
    description = inspect.cleandoc(command.callback.__doc__).replace("{attitudes}", listed_formats())
    table = ["| argument or option | meaning |", "|---|---|", *(f"| `{name}` | {what} |" for _, name, what in rows)]
    parts = (f"### {command.callback.__name__}", f"```text\n{called}\n```", description, "\n".join(table))
    return "\n\n".join(parts)


def parameter_row(parameter: inspect.Parameter, kind: Any, about: Any) -> tuple[str, str, str]:
    """Return how an argument or an option of a command stands in its usage, its name with its value, and its help."""
    needed, decided = parameter.default is parameter.empty, parameter.default not in (None, False, parameter.empty)
    what = about.help + f" Default: {parameter.default}." * decided
    if type(about).__name__ == "ArgumentInfo":
        name = about.metavar or parameter.name.upper()
        return (name if needed else f"[{name}]"), name, what
    names = [name for name in (about.default, *(about.param_decls or ())) if str(name).startswith("--")]
    option = next(iter(names), f"--{parameter.name.replace('_', '-')}")
    value = "" if kind is bool else about.metavar or WRITTEN[next(k for k in (kind, *get_args(kind)) if k in WRITTEN)]
    name = f"{option} {value if about.file_okay else 'FOLDER'}".strip()
    return f"[{name}]", name, what


WRITTEN = {Path: "FILE", int: "N", float: "NUMBER", str: "TEXT"}
"""How a value of a kind stands in the usage of a command."""


def filled(text: str, name: str, table: str) -> str:
    """Return a page with a table between its two marks."""
    begin, end = f"<!-- {name}: `make face` -->\n", f"\n<!-- end of {name} -->"
    found = re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", lambda _: begin + table + end, text, flags=re.DOTALL)
    if begin not in text:
        raise ValueError(f"the page must have the mark {begin!r}, but it has none.")
    return found


if __name__ == "__main__":
    for path, text in face().items():
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
            sys.stdout.write(f"{path.relative_to(ROOT)}\n")
