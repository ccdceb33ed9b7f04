"""The pages of the scenario schema, one per group of tables."""

from __future__ import annotations

import re
from typing import Any

import poinsot
from poinsot.files.scenarios.schema import schema

__all__ = ["pages"]

Node = dict[str, Any]

HEAD = """# Scenario schema

The tables and keys of a scenario file (TOML), from the JSON Schema that checks it
([scenario.schema.json](../scenario.schema.json), also `poinsot new --schema`). [Scenarios and results](../scenarios.md)
is the guide to scenarios.

## Keys of the file"""

GROUPS = {
    "orbits": ("Orbits", ("orbits",)),
    "frames": ("Rotating frames", ("frames",)),
    "bodies": ("Bodies and shapes", ("body",)),
    "states": ("Initial states", ("state",)),
    "parts": ("Moving parts", ()),
    "control": ("Control laws and sensors", ()),
    "forces": ("Forces", ("forces",)),
    "runs": ("Units, times, runs and ensembles", ("units", "calendar", "times", "run", "outputs", "ensemble")),
}
"""Title of each page, and the keys of the file whose tables it describes first."""


def pages() -> dict[str, str]:
    """Return the pages of the scenario schema in MyST by name: keys of the file, and one page per group of tables."""
    whole = schema()
    listed = "\n".join(f"scenario_{group}" for group in GROUPS)
    made = {"scenario.md": f"{HEAD}\n\n{keys(whole)}\n\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n"}
    groups = grouped(whole)
    for group, (name, _) in GROUPS.items():
        sections = [section(each, whole["$defs"][each]) for each in sorted(groups) if groups[each] == group]
        made[f"scenario_{group}.md"] = "\n\n".join([f"# {name} in scenarios", *sections]) + "\n"
    return made


def grouped(whole: Node) -> dict[str, str]:
    """Return the group of each definition: its package, or the first group whose keys lead to it."""
    found = {
        name: group
        for group, package in (("parts", poinsot.parts), ("control", poinsot.control))
        for name in whole["$defs"]
        if title(name).split(".")[0] in package.__all__ and "_within_another" not in name
    }
    for group, (_, first) in GROUPS.items():
        waiting = [name for key in first for name in references(whole["properties"][key])]
        seen = set(waiting)
        while waiting:
            name = waiting.pop()
            if "_within_another" not in name:
                found.setdefault(name, group)
            further = references(whole["$defs"][name]) - seen
            seen |= further
            waiting += further
    return found


def references(node: Any) -> set[str]:
    """Return the names of the definitions to which a node of the schema refers."""
    if isinstance(node, dict):
        own = {node["$ref"].rpartition("/")[2]} if "$ref" in node else set()
        return own.union(*map(references, node.values()))
    return set().union(*map(references, node)) if isinstance(node, list) else set()


def section(name: str, node: Node) -> str:
    """Return the description of one kind of table."""
    description = " ".join(node.get("description", "").split())
    return "\n\n".join(
        part for part in (f"({anchor(name)})=\n## {title(name)}", escaped(description), keys(node)) if part
    )


def title(name: str) -> str:
    """Return the name of a kind of table in a scenario file."""
    plain = re.sub(r"__\d+$", "", name).rpartition("__")[2]
    return re.sub(r"^([A-Z]\w*?)_(?=from_|of_|earth$|iau$)", r"\1.", plain)


def anchor(name: str) -> str:
    """Return the target of links to a kind of table."""
    return f"scenario-{name.removesuffix('_within_another').lower()}"


def keys(node: Node) -> str:
    """Return the table of the keys of a table."""
    required = node.get("required", [])
    rows = [
        f"| `{key}` | {kind(each)} | {default(key, each, required)} | {meaning(each)} |"
        for key, each in node.get("properties", {}).items()
    ]
    return "\n".join(["| key | value | default | meaning |", "|---|---|---|---|", *rows]) if rows else ""


def default(key: str, node: Node, required: list[str]) -> str:
    """Return the value of a key that is left out."""
    if key in required:
        return "required"
    return "" if node.get("default") in (None, "") else f"`{node['default']}`"


def meaning(node: Node) -> str:
    """Return the description of a key."""
    return escaped(" ".join(node.get("description", "").split()))


def escaped(text: str) -> str:
    """Return a text as it goes into a cell."""
    for mark in "\\|*<>[]{}$_":
        text = text.replace(mark, f"\\{mark}")
    return text


def kind(node: Node) -> str:
    """Return what values a key takes."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2].removesuffix("_within_another")
        return f"[{title(name)}](#{anchor(name)})"
    for choice in ("oneOf", "anyOf"):
        if choice in node:
            return " or ".join(dict.fromkeys(map(kind, node[choice])))
    if "const" in node:
        return f"`{node['const']}`"
    if "enum" in node:
        return ", ".join(f"`{each}`" for each in node["enum"])
    return plain(node)


def plain(node: Node) -> str:
    """Return what values a key without choices takes."""
    if node.get("type") == "array":
        return f"array of {kind(node['items'])}" if isinstance(node.get("items"), dict) else "array"
    if isinstance(node.get("additionalProperties"), dict):
        return f"tables: {kind(node['additionalProperties'])}"
    names = node.get("type", "any")
    return names if isinstance(names, str) else " or ".join(names)
