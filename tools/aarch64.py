"""Make a folder with Python and the required packages for Linux on ARM, which QEMU runs: `python -m tools.aarch64`.

Python comes from the packages of Debian or Ubuntu, whose tools must be installed together with `qemu-user-static`; the
others are wheels. `tests/laws/test_on_arm.py` runs with the folder, and is skipped without it.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / ".aarch64"

VERSION = "3.11"

DEBIAN = (
    *(f"python{VERSION}-minimal", f"libpython{VERSION}-minimal", f"libpython{VERSION}-stdlib"),
    *("libbz2-1.0", "libc6", "libcrypt1", "libexpat1", "libffi8", "libgcc-s1", "liblzma5", "libsqlite3-0", "libssl3"),
    *("libstdc++6", "libuuid1", "zlib1g"),
)

TAGS = ("manylinux2014_aarch64", "manylinux_2_17_aarch64", "manylinux_2_27_aarch64", "manylinux_2_28_aarch64")


def emulated() -> tuple[list[str], dict[str, str]] | None:
    """Return the beginning of a command that runs Python for ARM, and its environment; None where it is missing."""
    qemu = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")
    system = FOLDER / "system"
    python = system / "usr" / "bin" / f"python{VERSION}"
    if qemu is None or not python.is_file():
        return None
    environment = {"PYTHONHOME": str(system / "usr"), "PYTHONPATH": f"{FOLDER / 'packages'}:{ROOT / 'src'}"}
    return [qemu, "-L", str(system), str(python)], os.environ | environment


def main() -> None:
    """Download and unpack everything."""
    lists, cache, debs = (FOLDER / name for name in ("apt/lists/partial", "apt/cache/archives/partial", "debs"))
    for folder in (lists, cache, debs):
        folder.mkdir(parents=True, exist_ok=True)
    (FOLDER / "apt" / "status").touch()
    options: dict[str, str | Path] = {
        "APT::Architecture": "arm64",
        "APT::Architectures::": "arm64",
        "APT::Sandbox::User": "root",
        "Dir::State::lists": lists.parent,
        "Dir::State::status": FOLDER / "apt" / "status",
        "Dir::Cache": cache.parents[1],
    }
    apt = ["apt-get", "-qq", *(f"-o{name}={value}" for name, value in options.items())]
    _run(debs, *apt, "update")
    _run(debs, *apt, "download", *DEBIAN)
    for package in debs.glob("*.deb"):
        _run(debs, "dpkg-deb", "-x", str(package), str(FOLDER / "system"))
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--upgrade", "--target", str(FOLDER / "packages")]
    platforms = [word for tag in TAGS for word in ("--platform", tag)]
    _run(ROOT, *pip, *platforms, "--python-version", VERSION, "--only-binary", ":all:", *needed)


def _run(folder: Path, *command: str) -> None:
    subprocess.run(command, check=True, cwd=folder)  # noqa: S603 - the commands above


if __name__ == "__main__":
    main()
