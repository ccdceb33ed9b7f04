"""Count lines and floors of the packages: `python -m tools.lines`.

A code line contains code, no blank line, comment or docstring alone; a string below a constant is a docstring. The
floors of a package are the modules in its longest chain of imports.
"""

from __future__ import annotations

import ast
import graphlib
import io
import sys
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

__all__ = ["code_lines", "floors", "import_graph", "imported_modules", "modules"]

SOURCE = Path(__file__).parents[1] / "src" / "poinsot"

BLANK = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
"""Tokens that are no code."""


def modules(source: Path = SOURCE) -> dict[str, Path]:
    """Return the file of each module of a package by the module's name."""
    paths = {path.relative_to(source.parent).with_suffix(""): path for path in sorted(source.rglob("*.py"))}
    return {".".join(name.parts).removesuffix(".__init__"): path for name, path in paths.items()}


def code_lines(text: str) -> int:
    """Return the number of lines of a source text that contain code."""
    lines = {
        line
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in BLANK
        for line in range(token.start[0], token.end[0] + 1)
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines -= {*range(node.lineno, (node.end_lineno or node.lineno) + 1)}
    return sum(bool(text.splitlines()[line - 1].strip()) for line in lines)


def imported_modules(text: str, name: str, known: Iterable[str]) -> set[str]:
    """Return the known modules that a module imports anywhere, in functions and for types alone included.

    Parameters
    ----------
    text : str
        Source of the module.
    name : str
        Name of the module, not of a package.
    known : iterable of str
        Names of modules and packages.
    """
    known, found = {*known}, set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = name.split(".")[: -node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            found |= {full if (full := f"{base}.{alias.name}") in known else base for alias in node.names}
    return (found & known) - {name}


def import_graph(files: Mapping[str, Path]) -> dict[str, set[str]]:
    """Return the modules that each module imports."""
    return {name: imported_modules(path.read_text(), name, files) for name, path in files.items()}


def floors(graph: Mapping[str, set[str]]) -> list[str]:
    """Return the longest chain of imports, from the importing module to the imported one.

    Raises
    ------
    graphlib.CycleError
        If the graph contains a cycle.
    """
    longest: dict[str, list[str]] = {}
    for name in graphlib.TopologicalSorter(graph).static_order():
        longest[name] = [name, *max((longest[other] for other in sorted(graph.get(name, ()))), key=len, default=[])]
    return max(longest.values(), key=len, default=[])


def _unit(module: str) -> str:
    """Return the package or module directly below the root that contains a module."""
    return module.split(".")[1]


def _rows() -> Iterator[tuple[object, ...]]:
    """Yield package, modules, lines, code lines and floors; for the root the floors of packages."""
    files = modules()
    root = files.pop(SOURCE.name)
    graph, texts = import_graph(files), {name: path.read_text() for name, path in files.items()}
    units = {unit: [name for name in files if _unit(name) == unit] for unit in sorted(map(_unit, files))}
    between: dict[str, set[str]] = {unit: set() for unit in units}
    for name, others in graph.items():
        between[_unit(name)] |= {_unit(other) for other in others} - {_unit(name)}
    for unit, names in units.items():
        chain = floors({name: {other for other in graph[name] if other in names} for name in names})
        yield unit, len(names), *_counted(texts[name] for name in names), len(chain)
    yield SOURCE.name, len(modules()), *_counted([root.read_text(), *texts.values()]), len(floors(between))


def _counted(texts: Iterable[str]) -> tuple[int, int]:
    texts = [*texts]
    return sum(len(text.splitlines()) for text in texts), sum(map(code_lines, texts))


if __name__ == "__main__":
    chosen = sys.argv[1:]
    for row in [("package", "modules", "lines", "code", "floors"), *_rows()]:
        if not chosen or row[0] in ("package", *chosen):
            print("{:16}{:>9}{:>9}{:>9}{:>9}".format(*row))
