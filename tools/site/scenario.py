"""The reference of scenario files, from their JSON Schema."""

from __future__ import annotations

from typing import Any

from poinsot.files.scenarios.schema import schema

__all__ = ["page"]

Node = dict[str, Any]

HEAD = """# Scenario files

Every table and key that a scenario file (TOML) may have, from the JSON Schema that checks it
([scenario.schema.json](../scenario.schema.json), also `poinsot new --schema`). [Scenarios and results](../scenarios.md)
explains how they go together."""


def page() -> str:
    """Return the page, in MyST."""
    whole = schema()
    defined = {name: each for name, each in whole["$defs"].items() if "_within_another" not in name}
    sections = [section(name, each) for name, each in sorted(defined.items())]
    return "\n\n".join([HEAD, "## The file", keys(whole), "## Tables", *sections]) + "\n"


def section(name: str, node: Node) -> str:
    """Return what there is about one kind of table."""
    said = " ".join(node.get("description", "").split())
    return "\n\n".join(part for part in (f"({anchor(name)})=\n### {title(name)}", escaped(said), keys(node)) if part)


def title(name: str) -> str:
    """Return the name that a file gives to a kind of table."""
    return name.rpartition("__schema__")[2].replace("__", " ").replace("_from_", ".from_")


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
