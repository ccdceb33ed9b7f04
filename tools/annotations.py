"""Count annotations that contain `Any` or `object`, by package: `python -m tools.annotations integration mechanics`.

Annotations of parameters, returns, fields and variables count, each once: as `Any` if it contains the name, otherwise
as an alias if it contains an alias of `Any` or of a type that contains `Any`, otherwise as `object`. Packages are named
by their paths below the package poinsot.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from tools.lines import SOURCE, modules

__all__ = ["aliases_of_any", "annotations_in", "count"]

DEFAULT = ("taylor", "integration", "systems", "mechanics", "kinematics", "records", "propagation")

TYPE_EXPRESSION = (ast.Name, ast.Attribute, ast.Subscript, ast.BinOp)
"""Kinds of values of aliases."""

Aliases = dict[str, set[str]]


def annotations_in(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield the annotations in a syntax tree, those in quotation marks parsed."""
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign):
            found = node.annotation
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found = node.returns
        else:
            continue
        if isinstance(found, ast.Constant) and isinstance(found.value, str):
            found = ast.parse(found.value, mode="eval").body
        if found is not None:
            yield found


def aliases_of_any(trees: Mapping[str, ast.Module]) -> Aliases:
    """Return for each module the names in it, dotted ones included, of aliases whose value contains `Any`.

    Parameters
    ----------
    trees : mapping
        Syntax tree of each module by the module's name.
    """
    known: set[str] = set()  # module.name
    while True:
        local = {name: _imported(tree, known) | _own(name, known) for name, tree in trees.items()}
        defined = {
            f"{module}.{name}"
            for module, tree in trees.items()
            for name, value in _assignments(tree)
            if _contains(value, {*local[module], "Any"})
        }
        if defined <= known:
            return local
        known |= defined


def _own(module: str, known: set[str]) -> set[str]:
    return {full.rpartition(".")[2] for full in known if full.rpartition(".")[0] == module}


def _imported(tree: ast.Module, known: set[str]) -> set[str]:
    """Return the names by which a module imports known aliases."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                name, full = alias.asname or alias.name, f"{node.module}.{alias.name}"
                found |= {name} if full in known else {f"{name}.{own}" for own in _own(full, known)}
    return found


def _assignments(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Yield name and value of what may be an alias."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            target, value = node.targets[0], node.value
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value:
            if ast.unparse(node.annotation) != "TypeAlias":
                continue
            target, value = node.target, node.value
        else:
            continue
        if isinstance(value, TYPE_EXPRESSION):
            yield target.id, value


def _contains(expression: ast.AST, names: set[str]) -> bool:
    parts = (node for node in ast.walk(expression) if isinstance(node, ast.Name | ast.Attribute))
    return any(ast.unparse(part) in names for part in parts)


def count(trees: Mapping[str, ast.Module], aliases: Aliases) -> Counter[str]:
    """Return how many annotations of modules there are, and how many contain each kind of name."""
    found = Counter(all=0, Any=0, alias=0, object=0)
    for module, tree in trees.items():
        kinds = {"Any": {"Any", "typing.Any"}, "alias": aliases[module], "object": {"object"}}
        for annotation in annotations_in(tree):
            found["all"] += 1
            found.update([kind for kind, names in kinds.items() if _contains(annotation, names)][:1])
    return found


def _rows(packages: Sequence[str]) -> Iterator[tuple[object, ...]]:
    """Yield package, annotations and the kinds of names with their sum; the last row is the sum of packages."""
    trees = {name: ast.parse(path.read_text()) for name, path in modules().items()}
    aliases, total = aliases_of_any(trees), Counter[str]()
    for package in packages:
        start = ".".join((SOURCE.name, *Path(package).parts))
        found = count({name: tree for name, tree in trees.items() if f"{name}.".startswith(f"{start}.")}, aliases)
        total.update(found)
        yield package, *found.values(), found.total() - found["all"]
    yield "total", *total.values(), total.total() - total["all"]


if __name__ == "__main__":
    for row in [("package", "annotations", "Any", "alias", "object", "sum"), *_rows(sys.argv[1:] or DEFAULT)]:
        print("{:24}{:>12}{:>8}{:>8}{:>8}{:>8}".format(*row))
