"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import secrets
from collections.abc import Iterator
from pathlib import Path

__all__ = ["new_file", "write_text"]


@contextlib.contextmanager
def new_file(path: str | Path, overwrite: bool) -> Iterator[Path]:
    """Give the path of a file to write beside `path`, which takes its name if all went well and goes otherwise.

    Raises
    ------
    FileNotFoundError, FileExistsError, IsADirectoryError
        If there is no such folder, a file of that name and no leave to overwrite it, or a folder of that name.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"path must be in a folder that exists, but there is no {path.parent}.")
    if path.is_dir():
        raise IsADirectoryError(f"path must be the name of a file, but {path} is a folder.")
    if path.exists() and not overwrite:
        raise FileExistsError(f"path must be a new file, but {path} exists. overwrite=True replaces it.")
    part = path.parent / f".{path.name}.{secrets.token_hex(4)}.part"
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: str | Path, text: str, overwrite: bool) -> Path:
    """Write a text in UTF-8, whole or not at all; return its path."""
    with new_file(path, overwrite) as part, part.open("x", encoding="utf-8", newline="\n") as stream:
        stream.write(text)
    return Path(path)
