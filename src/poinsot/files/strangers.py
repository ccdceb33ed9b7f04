"""Reading what others wrote: bounded, decoded, and XML without entities."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

__all__ = ["local_name", "parsed_xml", "read_bytes", "read_text"]

MOST_BYTES = 64 * 1024 * 1024


def read_bytes(path: str | Path, most: int) -> bytes:
    """Return the content of a file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no file, or longer than the most bytes.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"path must lead to a file, but there is no {path}.")
    if not path.is_file():
        raise ValueError(f"path must lead to a file, but {path} is none.")
    with path.open("rb") as stream:
        content = stream.read(min(most, path.stat().st_size) + 1)
    if len(content) > most:
        raise ValueError(f"{path} must have at most {most} bytes, but it has more.")
    return content


def read_text(path: str | Path) -> str:
    """Return the text of a file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no file, longer than 64 MiB, or no text.
    """
    content = read_bytes(path, MOST_BYTES)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise ValueError(f"{path} must be text in UTF-8, but it has other bytes.")
    return text


def parsed_xml(text: str, name: str) -> ET.Element:
    """Return the root of a text in XML, which may declare no document type and no entities.

    Raises
    ------
    ValueError
        If it does, or is no XML.
    """
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise ValueError(f"{name} must be XML without a document type, but it declares one.")
    try:
        return ET.fromstring(text)  # noqa: S314 - entities need a document type
    except (ET.ParseError, ValueError) as error:
        raise ValueError(f"{name} must be XML, but it is not well-formed: {error}.") from None


def local_name(element: ET.Element) -> str:
    """Return the tag of an element without its namespace."""
    return element.tag.rpartition("}")[2]
