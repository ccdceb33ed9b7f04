"""Reference pages of scenario files, generated from their JSON Schema."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import poinsot
from poinsot.mechanics.gravity_field import GravityField
from poinsot.scenarios.registry import makers
from poinsot.scenarios.schema import schema
from poinsot.shapes.scattering import ScatteringLaw

__all__ = ["pages"]

Node = dict[str, Any]

GROUPS = {
    "runs": (
        "units, times and outputs",
        "Tables that describe the whole file: names of units, calendar, output times, options of the propagation, and "
        "output files.",
    ),
    "bodies": ("bodies", "Types of the table `[body]`: one rigid body, or two bodies that attract each other."),
    "shapes": (
        "shapes and gravity fields",
        "Shapes and gravity fields of bodies, for keys such as `shape` and `field` in the tables of bodies and forces.",
    ),
    "states": ("initial states", "The table `[state]`: attitude, and angular velocity or momentum, of the bodies."),
    "forces": (
        "forces and torques",
        "Types of the tables `[[forces]]`, with the surfaces, atmospheres and magnetic fields on which they depend.",
    ),
    "parts": (
        "moving parts",
        "Types of the tables `[[forces]]` that describe wheels, gyroscopes, dampers and pendulums.",
    ),
    "control": ("control laws", "Types of the tables `[[forces]]` that control the attitude, and models of sensors."),
    "orbits": ("orbits", "Types of the tables `[orbits.NAME]`. Forces and frames refer to an orbit by its name."),
    "frames": ("frames", "Types of the tables `[frames.NAME]`: uniformly rotating axes and planet-fixed axes."),
    "observables": (
        "observables",
        "Types of the tables `[[observe]]`: light curves, gyroscopes and other instruments, with laws of scattering.",
    ),
    "ensembles": ("ensembles", "The table `[ensemble]`: many members, whose initial states or parameters vary."),
}
"""Title and introduction of each page."""

PAGE_OF_KEY = {"state": "states", "ensemble": "ensembles"}
"""Pages of the tables that are not on the page of settings."""

WORDS = {"string": "text", "boolean": "true or false"}
"""The words of a page for some types of JSON."""

MOST_LINKS = 4
"""The longest list of types in a cell; a longer one becomes a link to their page."""

INDEX = """# Scenario files

These pages list every table and key of a scenario file (TOML). They are generated from the JSON Schema
([scenario.schema.json](../scenario.schema.json), also `poinsot new --schema`), with which poinsot checks the files.
[Scenarios and results](../scenarios.md) explains their use with examples.

In the column *value*, a quantity is a number, or a text with a unit such as `"2 deg"`, and a name in brackets such as
`[state]` is a table. Where a further level of arrays is allowed, it contains one value for each member of an ensemble.

"""


def pages() -> dict[str, str]:
    """Return the pages in MyST, by the names of their files: an index, and one page for each group of tables."""
    whole = schema()
    book = Book(whole)
    toctree = "\n".join(["```{toctree}", ":hidden:", "", *(f"scenario_{name}" for name in GROUPS), "```"])
    listed = [f"| [{title}](scenario_{name}.md) | {about} |" for name, (title, about) in GROUPS.items()]
    contents = "\n".join(["| page | contents |", "|---|---|", *listed])
    index = f"{INDEX}{contents}\n\n## Keys of the file\n\n{book.keys(whole)}\n\n{toctree}\n"
    return {"scenario.md": index} | {f"scenario_{name}.md": book.page(name) for name in GROUPS}


class Book:
    """Titles, anchors and pages of all tables of a schema.

    Parameters
    ----------
    whole : dict
        JSON Schema of scenarios.
    """

    def __init__(self, whole: Node) -> None:
        self.tables: dict[str, Node] = whole["$defs"]
        paths = dict(self.paths(whole))
        typed_tables = {name: title for name, node in self.tables.items() if (title := type_of(node))}
        self.titles = {name: title for name, title in (paths | typed_tables).items() if shown(name) == name}
        typed = {key: set(makers(key)) for key in ("body", "orbit", "frame", "observable")}
        own = {title: key + "s" if key != "body" else "bodies" for key, titles in typed.items() for title in titles}
        shapes = dict.fromkeys([*makers("shape"), *makers(GravityField)], "shapes")
        laws = dict.fromkeys(makers(ScatteringLaw), "observables")
        spaces = {title: space for space in ("parts", "control") for title in getattr(poinsot, space).__all__}
        self.groups = {title: self.group(title, own | shapes | laws | spaces) for title in self.titles.values()}

    def paths(self, node: Node, place: str = "") -> Iterator[tuple[str, str]]:
        """Yield the names of the tables without a type, each with its place in the file, such as `[state.primary]`."""
        for key, each in node["properties"].items():
            for name in re.findall(r"'#/\$defs/(\w+)'", str(each)):
                if not type_of(self.tables[name]):
                    path = f"{place}{key}"
                    yield name, f"[[{path}]]" if each.get("type") == "array" else f"[{path}]"
                    yield from self.paths(self.tables[name], f"{path}.")

    def group(self, title: str, known: dict[str, str]) -> str:
        """Return the page of a table by its title."""
        if title.startswith("["):
            return PAGE_OF_KEY.get(re.split(r"[\W]+", title)[1], "runs")
        return known.get(title) or known.get(title.partition(".")[0], "forces")

    def page(self, group: str) -> str:
        """Return the page of a group: each of its tables once."""
        title, about = GROUPS[group]
        sections = [
            self.section(each, self.tables[name]) for name, each in self.titles.items() if self.groups[each] == group
        ]
        return "\n\n".join([f"# Scenario files: {title}", about, *sections]) + "\n"

    def section(self, title: str, node: Node) -> str:
        """Return the section of one table: description and keys."""
        described = re.sub(r"^Return (the |an? )?(\w)", lambda found: found[2].upper(), node.get("description", ""))
        parts = (f"({anchor(title)})=\n## {escaped(title)}", escaped(" ".join(described.split())), self.keys(node))
        return "\n\n".join(part for part in parts if part)

    def keys(self, node: Node) -> str:
        """Return the list of the keys of a table."""
        required = node.get("required", [])
        rows = [
            f"| `{key}` | {self.kind(each)} | {default(key, each, required)} | {meaning(key, each)} |"
            for key, each in node.get("properties", {}).items()
        ]
        return "\n".join(["| key | value | default | meaning |", "|---|---|---|---|", *rows]) if rows else ""

    def kind(self, node: Node) -> str:
        """Return the allowed values of a key."""
        if "$ref" in node:
            return self.link(node["$ref"])
        for choice in ("oneOf", "anyOf"):
            if choice in node:
                return self.alternatives([each for each in node[choice] if each != {"type": "null"}])
        if "const" in node:
            return f"`{node['const']}`"
        if "enum" in node:
            return ", ".join(f"`{each}`" for each in node["enum"])
        return self.plain(node)

    def link(self, reference: str) -> str:
        """Return a link to a table."""
        title = self.titles[shown(reference.rpartition("/")[2])]
        return f"[{escaped(title)}](#{anchor(title)})"

    def alternatives(self, nodes: list[Node]) -> str:
        """Return the alternatives for the value of a key; many types become a link to their pages."""
        types = [self.titles[shown(node["$ref"].rpartition("/")[2])] for node in nodes if "$ref" in node]
        if len(types) > MOST_LINKS:
            groups = dict.fromkeys(self.groups[title] for title in types)
            return "table of a type in " + ", ".join(f"[{GROUPS[group][0]}](scenario_{group}.md)" for group in groups)
        return " or ".join(dict.fromkeys(map(self.kind, nodes)))

    def plain(self, node: Node) -> str:
        """Return the allowed values of a key without choices."""
        if node.get("type") == "array":
            return f"array of {plural(self.kind(node['items']))}" if isinstance(node.get("items"), dict) else "array"
        if isinstance(node.get("additionalProperties"), dict):
            return f"{plural(self.kind(node['additionalProperties']))} by name"
        names = node.get("type", "any")
        return "quantity" if names == ["number", "string"] else WORDS.get(names, str(names))


def shown(name: str) -> str:
    """Return the name of a model under which its table is described: models with the same type are alike."""
    return re.sub(r"__2$", "__1", name.removesuffix("_within_another"))


def plural(words: str) -> str:
    """Return the words for several values."""
    nouns = {"quantity": "quantities", "array": "arrays", "table": "tables", "number": "numbers", "text": "texts"}
    first, *others = words.split(" or ")
    noun, space, rest = first.partition(" ")
    return " or ".join([f"{nouns.get(noun, noun)}{space}{rest}", *map(plural, others)])


def type_of(node: Node) -> str | None:
    """Return the type that selects a table; None for a table with a fixed place in the file."""
    kind: str | None = node["properties"].get("type", {}).get("const")
    return kind


def anchor(title: str) -> str:
    """Return the target of links to a table."""
    return f"scenario-{re.sub(r'[^a-z0-9]+', '-', title.lower()).strip('-')}"


def default(key: str, node: Node, required: list[str]) -> str:
    """Return the default value of a key."""
    if key in required:
        return "required"
    return "" if node.get("default") in (None, "") else f"`{node['default']}`"


def meaning(key: str, node: Node) -> str:
    """Return the description of a key."""
    described = "Type of this table." if key == "type" and "const" in node else node.get("description", "")
    return escaped(" ".join(described.split()))


def escaped(text: str) -> str:
    """Return a text with the marks of MyST escaped."""
    for mark in "\\|*<>[]{}$_":
        text = text.replace(mark, f"\\{mark}")
    return text
