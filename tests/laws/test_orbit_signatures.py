"""Ways to orbits: what attracts comes first, by its place; everything else is given by its name."""

import inspect
import pkgutil
from importlib import import_module

import pytest

import poinsot as pt
from poinsot import orbits

for module in pkgutil.iter_modules(orbits.__path__, "poinsot.orbits."):
    import_module(module.name)

FIRST = {"PrecessingOrbit": ["orbit"], "GroundStation": ["orbit", "rotation"], "ThreeBodyView": ["path"]}
"""Those that are made from another orbit."""

PAIRS = ("LagrangePointPath", "ThreeBodyPath")


def subclasses(cls):
    for each in cls.__subclasses__():
        if each.__module__.startswith("poinsot."):
            yield each
            yield from subclasses(each)


KINDS = [
    *(cls for cls in subclasses(pt.Orbit) if not inspect.isabstract(cls)),
    pt.orbits.LagrangePointPath,
    pt.orbits.ThreeBodyPath,
]
WAYS = {
    f"{cls.__name__}.{name}".removesuffix(".__init__"): getattr(cls, name)
    for cls in KINDS
    for name in dir(cls)
    if name == "__init__" or (name.startswith("from_") and inspect.ismethod(getattr(cls, name)))
} | {"two_body_orbit": pt.orbits.two_body_orbit}


def test_all_ways_are_here():
    assert {"KeplerOrbit.from_elements", "EscapeOrbit.from_vectors", "Ephemeris.from_table"} < set(WAYS)
    others = {
        name
        for cls in KINDS
        for name, method in vars(cls).items()
        if isinstance(method, classmethod) and not name.startswith(("_", "from_"))
    }
    assert not others


@pytest.mark.parametrize("name", WAYS)
def test_the_attractor_comes_first_and_the_rest_by_name(name):
    parameters = [p for p in inspect.signature(WAYS[name]).parameters.values() if p.name != "self"]
    by_place = [p.name for p in parameters if p.kind is not p.KEYWORD_ONLY]
    kind = name.partition(".")[0]
    assert by_place == (["mu_primary", "mu_secondary"] if kind in PAIRS else FIRST.get(kind, ["mu"]))
