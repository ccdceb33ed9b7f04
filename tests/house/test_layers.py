"""Imports go downwards and in no circle, those of TYPE_CHECKING and inside functions included."""

import ast
import tomllib
from pathlib import Path

import poinsot

SOURCE = Path(poinsot.__file__).parent
PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def modules():
    """Return the path of each module by its name."""
    names = {
        path: ".".join(("poinsot", *path.relative_to(SOURCE).with_suffix("").parts)) for path in SOURCE.rglob("*.py")
    }
    return {name.removesuffix(".__init__"): path for path, name in names.items()}


def imports(text, name, known):
    """Yield the modules that the source of a module imports, wherever the import stands."""
    package = name.split(".")
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: -node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            found = [f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base for alias in node.names]
        else:
            continue
        yield from (one for one in found if one in known and one != name)


def graph():
    known = modules()
    return {name: set(imports(path.read_text(), name, known)) for name, path in known.items()}


def circles(edges):
    """Return the sets of modules that import one another, directly or by others: Tarjan's components."""
    order, low, stack, found = {}, {}, [], []

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in sorted(edges[node]):
            if other not in order:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == order[node]:
            place = stack.index(node)
            found.append(sorted(stack[place:]))
            del stack[place:]

    for node in sorted(edges):
        if node not in order:
            visit(node)
    return [names for names in found if len(names) > 1]


def contracts():
    """Return the contracts on imports by their names."""
    rows = tomllib.loads(PROJECT.read_text())["tool"]["importlinter"]["contracts"]
    return {row["name"]: row for row in rows}


def layers():
    """Return the layers of the project, the uppermost first; modules of one layer stand side by side."""
    return [[name.strip() for name in row.split("|")] for row in contracts()["imports go down"]["layers"]]


def place_of(module, rows):
    places = [i for i, row in enumerate(rows) for name in row if f"{module}.".startswith(f"{name}.")]
    return places[0] if places else None


def upward(edges, rows):
    """Return the imports that go up, or across to another module of the layer."""
    found = []
    for name, others in edges.items():
        for other in others:
            here, there = place_of(name, rows), place_of(other, rows)
            if here is None or there is None:
                continue
            own = next(x for x in rows[here] if f"{name}.".startswith(f"{x}."))
            if there < here or (there == here and not f"{other}.".startswith(f"{own}.")):
                found.append(f"{name} -> {other}")
    return sorted(found)


def test_no_circle_of_imports():
    assert circles(graph()) == []


def test_no_import_goes_up():
    assert upward(graph(), layers()) == []


def test_every_module_is_in_a_layer():
    outside = [name for name in modules() if place_of(name, layers()) is None]
    assert outside == ["poinsot"]


def test_every_package_imports_the_compiler_by_one_rule():
    """Packages above the bridge and below it have a contract each; `integration` and `cuda` import any module."""
    names = [name for row in layers() for name in row]
    bridge, compiler = names.index("poinsot.integration"), names.index("poinsot.taylor")
    above = contracts()["results and analyses reach the compiler through integration alone"]
    below = contracts()["descriptions import the graph of formulas alone"]
    assert sorted(above["source_modules"]) == sorted(set(names[:bridge]) - {"poinsot.cuda"})
    assert sorted(below["source_modules"]) == sorted(names[bridge + 1 : compiler])
    for contract in (above, below):
        assert contract["forbidden_modules"] == ["poinsot.taylor"]


def set_elsewhere(text):
    """Yield the globals that a module declares without a value, and the globals that it sets in another module."""
    tree = ast.parse(text)
    yield from (ast.unparse(node.target) for node in tree.body if isinstance(node, ast.AnnAssign) and not node.value)
    nodes = [*ast.walk(tree)]
    imported = {
        (alias.asname or alias.name).partition(".")[0]
        for node in nodes
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    for node in nodes:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            name = ast.unparse(target) if isinstance(target, ast.Attribute) else ""
            if name.replace(".", "").isidentifier() and name.partition(".")[0] in imported:
                yield name


def test_no_module_sets_a_global_of_another_one():
    found = {name: [*set_elsewhere(path.read_text())] for name, path in modules().items()}
    assert {name: names for name, names in found.items() if names} == {}


def test_the_judges_find_what_they_look_for():
    """A circle through a function and one through TYPE_CHECKING; an import upwards and one across."""
    texts = {
        "p.a": "def f():\n    from p.b import x",
        "p.b": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import p.c",
        "p.c": "from . import a",
        "p.d": "import p.a",
    }
    edges = {name: set(imports(text, name, texts)) for name, text in texts.items()}
    assert circles(edges) == [["p.a", "p.b", "p.c"]]
    assert upward(edges, [["p.a"], ["p.b", "p.d"], ["p.c"]]) == ["p.c -> p.a", "p.d -> p.a"]
    assert upward({"p.b": {"p.d"}}, [["p.b", "p.d"]]) == ["p.b -> p.d"]
    hatch = "from p import a\nimport p.b\nstart: int\nend: int = 1\na.engine = end\np.b.engine = end\nstart.x = 1"
    assert [*set_elsewhere(hatch)] == ["start", "a.engine", "p.b.engine"]
