"""The pages of the API: one for each public name, one for each namespace."""

from __future__ import annotations

import importlib
import inspect
import textwrap

from tools.site.names import NAMESPACES, public

from poinsot.display.formulas import letters_of
from poinsot.display.notation import LATEX, MATHML, typeset_stated
from poinsot.mechanics.force import Force, PairLoad
from poinsot.records.parameters import Parametric
from poinsot.systems.symbolic_formula import stated_formula

__all__ = ["pages"]

ROOT_GROUPS = {
    "Bodies and systems": "Body System TwoBodies State PairState Attitude Andoyer Calendar",
    "Motions": "propagate free_motion observe Trajectory EventRecord PropagationError PropagationInterrupted",
    "Files and pictures": "save load view animate",
    "Everyday forces and orbits": "UniformGravity GravityGradient GravityField KeplerOrbit RotatingFrame",
    "To write one's own": "Potential Torque Part Event Orbit Observable Instant BodyVector SpaceVector",
}
"""The names of the root, by what they are for."""

TITLES = {
    "analysis": "Analysis",
    "control": "Control",
    "events": "Events",
    "files": "Files",
    "forces": "Forces",
    "mechanics": "Base classes and annotations",
    "observables": "Observables",
    "orbits": "Orbits",
    "parts": "Parts",
    "plot": "Plots",
    "shapes": "Shapes",
    "functions": "Functions of formulas",
}

OF_RECORDS = sorted({name for name in vars(Parametric) if not name.startswith("_")} | {"formula"})
"""Members of every record that only the engine calls, and the formula, which is typeset."""


ON_TWO_BODIES = {"MutualGravity", "MutualMascons", "ThirdBody"}
"""Potentials of a pair, whose letters mean something else."""

ANNOTATIONS = {
    "BodyVector": """Annotation of a field of three components along the body axes.

>>> class Jet(pt.Torque):
...     size: pt.BodyVector
...     def torque(self, instant):
...         return pt.functions.Vector(self.size)
>>> Jet((0, 0, 0.5))
Jet(size=[0.0, 0.0, 0.5])
""",
    "SpaceVector": """Annotation of a field of three components along the space axes.

>>> class Compass(pt.Potential):
...     field: pt.SpaceVector
...     def energy(self, instant):
...         return -instant.attitude.to_body(self.field)[2]
>>> system = pt.System(pt.Body((1, 2, 2.5)), Compass((0, 2, 0)))
>>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 0)))
array([-2.,  0.,  0.])
""",
    "Vector": """Annotation of a field of three numbers that belong to no axes.

>>> class Brake(pt.Torque):
...     gains: pt.mechanics.Vector
...     def torque(self, instant):
...         return pt.functions.Vector(-k * w for k, w in zip(self.gains, instant.omega_body))
>>> system = pt.System(pt.Body((1, 2, 2.5)), Brake((0.1, 0.2, 0.3)))
>>> system.torque_body(system.state((1, 0, 0, 0), omega_body=(0, 0, 2)))
array([ 0. ,  0. , -0.6])
""",
}
"""Descriptions of names that are neither classes nor functions and have no docstring."""


def pages() -> dict[str, str]:
    """Return the text of each page by its path."""
    things = public()
    spaces = {space: [name for name in things if name.startswith(f"poinsot.{space}.")] for space in NAMESPACES}
    objects = {f"api/{name}.rst": object_page(name, thing) for name, thing in things.items()}
    groups = {f"api/{space}.rst": namespace_page(space, names) for space, names in spaces.items()}
    return {"api/index.rst": index_page(), "api/functions.rst": functions_page(), **groups, **objects}


def titled(title: str, mark: str = "=") -> str:
    """Return a title in reStructuredText."""
    return f"{title}\n{mark * len(title)}\n"


def index_page() -> str:
    """Return the page of the root, with the namespaces."""
    spaces = "\n".join(f"   {space}" for space in TITLES)
    listed = ", ".join(f":doc:`{title} <{space}>`" for space, title in TITLES.items())
    groups = "\n".join(
        f"{titled(title, '-')}\n{summaries([f'poinsot.{name}' for name in names.split()])}"
        for title, names in ROOT_GROUPS.items()
    )
    return (
        f"{titled('API')}\n"
        "Every public name, with its defining identity, the shapes, units and frames of its arguments, and an example\n"
        "that runs after ``import numpy as np`` and ``import poinsot as pt``; in those of plots ``motion`` is any.\n"
        f"The names of this page are those of ``pt`` itself. Its namespaces: {listed}.\n\n"
        f".. toctree::\n   :hidden:\n   :caption: Namespaces\n\n{spaces}\n\n{groups}"
    )


def summaries(names: list[str]) -> str:
    """Return a table of names, and the hidden table of contents that leads to their pages."""
    of_objects = [name for name in names if name.rpartition(".")[2] not in ANNOTATIONS]
    table = "\n".join(f"   {name}" for name in of_objects)
    listed = "\n".join(f"   {name}" for name in names)
    return f".. autosummary::\n   :nosignatures:\n\n{table}\n\n.. toctree::\n   :hidden:\n\n{listed}\n"


def namespace_page(space: str, names: list[str]) -> str:
    """Return the page of a namespace."""
    return f"{titled(TITLES[space])}\n``pt.{space}``\n\n{summaries(sorted(names))}"


def functions_page() -> str:
    """Return the page of the functions of formulas."""
    module = importlib.import_module("poinsot.functions")
    functions = [name for name in module.__all__ if inspect.isfunction(getattr(module, name))]
    listed = "\n".join(f".. autofunction:: {name}\n" for name in functions)
    return f"{titled(TITLES['functions'])}\n.. automodule:: poinsot.functions\n\n{listed}\n.. autoclass:: Vector\n"


def object_page(name: str, thing: object) -> str:
    """Return the page of one name."""
    last = name.rpartition(".")[2]
    if last in ANNOTATIONS:
        body = f".. py:data:: {name}\n\n{textwrap.indent(ANNOTATIONS[last], '   ')}"
    elif inspect.isclass(thing):
        excluded = f"   :exclude-members: {', '.join(OF_RECORDS)}\n" if issubclass(thing, Parametric) else ""
        body = f".. autoclass:: {name}\n   :members:\n   :inherited-members: BaseException, tuple\n{excluded}"
        body = f"{typeset(thing)}{body}" if issubclass(thing, Force) else body
    else:
        body = f".. autofunction:: {name}\n"
    return f"{titled(name.removeprefix('poinsot.'))}\n{body}"


def typeset(kind: type) -> str:
    """Return the formula that a force states, with its letters; "" if it states none."""
    stated = stated_formula(kind)
    if not stated:
        return ""
    two = issubclass(kind, PairLoad) or kind.__name__ in ON_TWO_BODIES
    equations = "".join(f".. math:: {each}\n\n" for each in typeset_stated(stated, LATEX))
    letters = letters_of(typeset_stated(stated, MATHML), two_bodies=two)
    return equations + "; ".join(f":math:`{LATEX.letter(name)}` {what}" for name, what in letters.items()) + "\n\n"
