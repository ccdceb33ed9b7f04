"""Bounded reading of untrusted files: text, and XML without entities."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from poinsot.printable import shortened

__all__ = ["MAX_BYTES", "lazy_lines", "local_name", "parsed_xml", "read_bytes", "read_text"]

MAX_BYTES = 64 * 1024 * 1024
"""Largest size of a file that is read line by line."""

MAX_MESSAGE_BYTES = 16 * 1024 * 1024
MAX_LINES = 120_000
MAX_TAGS = 400_000
MAX_ATTRIBUTES = 200_000
"""Limits of a message or a table of attitudes. A larger one with an error at its end takes more than a second."""

ENDS = "\n\r\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029"
"""Characters that end a line."""


def read_bytes(path: str | Path, most: int) -> bytes:
    """Return the content of a file; refuse what is no file, or longer than the most bytes."""
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"No such file: {shortened(path)}")
    if not path.is_file():
        raise ValueError(f"{shortened(path)} must be a file, got a folder or a device.")
    with path.open("rb") as stream:
        size = path.stat().st_size
        content = stream.read(size + 1) if size <= most else b""
    if size > most or len(content) > most:
        raise ValueError(f"{shortened(path)} must have at most {most} bytes, got more.")
    return content


def read_text(path: str | Path, most: int | None = None) -> str:
    """Return the text in UTF-8 of a file; a message has at most 16 MiB and 120,000 lines, others the most bytes."""
    content = read_bytes(path, MAX_MESSAGE_BYTES if most is None else most)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise ValueError(f"{shortened(path)} must be text in UTF-8, got other bytes.")
    lines = sum(map(text.count, ENDS))
    if most is None and lines > 2 * MAX_LINES:  # each may end in two characters
        raise ValueError(f"{shortened(path)} must have at most {MAX_LINES} lines, got more.")
    return text


def lazy_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a long text, each after its number from 1, without a list of them."""
    start, count = 0, 0
    while start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        count += 1
        yield count, text[start:end]
        start = end + 1


def parsed_xml(text: str, name: str) -> ET.Element:
    """Return the root of a text in XML, which may declare no document type and no entities.

    A ValueError refuses these, and more than 400,000 tags or 200,000 attributes.
    """
    for what, mark, most in (("tags", "<", MAX_TAGS), ("attributes", "=", MAX_ATTRIBUTES)):
        if text.count(mark) > most:
            raise ValueError(f"{name} must have at most {most} {what}, got {text.count(mark)}.")
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise ValueError(f"{name} must be XML without a document type, got one.")
    try:
        return ET.fromstring(text)  # noqa: S314 - entities need a document type
    except (ET.ParseError, ValueError) as error:
        raise ValueError(f"{name} must be well-formed XML, got {error}.") from None


def local_name(element: ET.Element) -> str:
    """Return the tag of an element without its namespace."""
    return element.tag.rpartition("}")[2]
