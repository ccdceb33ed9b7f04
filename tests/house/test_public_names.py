"""The public names, and what importing them costs."""

import ast
import pkgutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import poinsot

SPACES = [
    poinsot,
    *(
        import_module(f"poinsot.{name}")
        for name in ("analysis", "events", "files", "forces", "mechanics", "orbits", "plot", "shapes")
    ),
]


@pytest.mark.parametrize("package", SPACES, ids=lambda package: package.__name__)
def test_every_name_of_the_stub_is_public_and_documented(package):
    stub = ast.parse(Path(package.__file__).with_suffix(".pyi").read_text())
    imported = [alias.name for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    (public,) = (ast.literal_eval(node.value) for node in stub.body if isinstance(node, ast.Assign))
    assert public == sorted(imported) == package.__all__ == dir(package)
    assert all(getattr(package, name).__doc__ for name in public)


@pytest.mark.parametrize("package", SPACES[1:], ids=lambda package: package.__name__)
def test_no_module_hides_a_public_name(package):
    """An imported module is an attribute of its package, in the place of what has its name."""
    assert not {module.name for module in pkgutil.iter_modules(package.__path__)} & set(package.__all__)


def test_the_root_is_short_and_has_what_it_shares_with_a_namespace():
    assert len(poinsot.__all__) <= 46
    for space in SPACES[1:]:
        for name in set(space.__all__) & set(poinsot.__all__):
            assert getattr(space, name) is getattr(poinsot, name)


@pytest.mark.parametrize(
    ("use", "more"),
    [
        ("", {"numpy", "scipy"}),
        ("poinsot.propagate, poinsot.System, poinsot.KeplerOrbit", set()),
        ("[getattr(poinsot.plot, name) for name in poinsot.plot.__all__]", set()),
        (
            "from poinsot import analysis, events, files, forces, orbits, plot, shapes",
            {"numpy", "scipy"},
        ),
    ],
)
def test_import_leaves_heavy_packages_alone(use, more):
    code = f"import sys, poinsot; {use}; print(*sys.modules)" if use else "import sys, poinsot; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"matplotlib", "xarray", "pydantic", "zarr", "pandas", "netCDF4", "typer", "rich", "scipy.spatial"}
    assert not (heavy | more | {"astropy", "erfa", "sgp4", "spiceypy", "trimesh"}) & set(loaded)


def test_no_two_classes_have_one_name():
    """A reader who searches for the class of a message or of an annotation finds one."""
    found = {}
    for path in Path(poinsot.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(f"{path.name}, line {node.lineno}")
    assert {name: places for name, places in found.items() if len(places) > 1} == {}


@pytest.mark.parametrize("name", ["Environment", "Frame", "Jump", "Load", "PairInstant", "PairLoad"])
def test_the_root_names_the_namespace_of_names_for_authors(name):
    with pytest.raises(AttributeError, match=f"poinsot has no attribute '{name}'. Write poinsot.mechanics.{name}."):
        getattr(poinsot, name)


def test_no_public_name_is_the_name_of_its_module():
    """The import of the module would replace a function in its namespace."""
    for stub in Path(poinsot.__path__[0]).rglob("__init__.pyi"):
        imports = [node for node in ast.parse(stub.read_text()).body if isinstance(node, ast.ImportFrom)]
        names = {alias.name: (node.module or "").split(".")[0] for node in imports for alias in node.names}
        assert [name for name, module in names.items() if name == module] == []
