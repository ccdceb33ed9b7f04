"""Files that a scenario may name: files in its own folder and below."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from poinsot.printable import quoted

__all__ = ["Folder"]


class Folder:
    """Folder of a scenario, whose files the scenario may name. `used` lists the names of opened files.

    The text of a scenario without a folder must not name files.
    """

    def __init__(self, path: Path | None) -> None:
        self._path, self.used = path, list[str]()

    def file(self, name: str) -> Path:
        """Return the path of a file; a ValueError has the second half of a sentence, if the name leads elsewhere."""
        if self._path is None:
            raise ValueError("must not be in a text without a folder, got the name of a file.")
        given = quoted(name)
        parts = PurePosixPath(name).parts
        if not parts or name.startswith(("/", "~")) or ".." in parts or any(mark in name for mark in "\\:\0\n"):
            raise ValueError(f"must be a path from the folder of the scenario to a file in it or below, got {given}.")
        path = self._path / name
        try:
            inside = path.resolve(strict=True).is_relative_to(self._path.resolve())
        except (OSError, RuntimeError):
            raise ValueError(f"must be a file in the folder of the scenario, got {given}: no such file.") from None
        if not inside:
            raise ValueError(f"must be a file in the scenario's folder, got {given}, which links out of it.")
        if not path.is_file():
            raise ValueError(f"must be a file, got {given}, a folder or a device.")
        self.used.append(name)
        return path
