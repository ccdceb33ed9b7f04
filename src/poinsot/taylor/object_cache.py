"""Machine code of modules: compiled by LLVM, and stored on disk as object code that a later process loads.

A file of the cache starts with the SHA-256 digest of the object code behind it, which detects damage. The digest needs
no secret: a user who can change files in the folder can already execute any code of this user, so the folder, all
folders above it and the file must be writable by this user and root alone. Access control lists are not checked.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import hashlib
import os
import platform
import stat
import sys
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from poinsot.errors import level_of_user
from poinsot.operating_system import BINARY, REGULAR_FILE
from poinsot.printable import shortened
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, POINTER, Module, llvm

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

__all__ = ["ObjectCache", "folder", "function_of", "machine_code", "symbols_of"]

CODE_GENERATION = 1
"""Optimization level of LLVM: code of level 2 is not faster, and large systems take nearly twice as long to compile."""

MAX_OPTIMIZED = 20_000_000
"""Characters of a text above which the optimization level is 0. For some 35,000 operations level 1 takes 10 s and level
0 takes 2 s, but a step of level 0 takes nearly twice as long."""

CODE_FORMAT = 1
"""A number to change where the same text is compiled or loaded otherwise than before."""

LIBRARY = ("acos", "asin", "asinh", "atan", "atan2", "cos", "exp", "log", "log2", "pow", "sin", "tan", "tanh")
"""The functions of the C library that kernels may call."""

USES_FLOATS = ctypes.c_int(1)
"""The symbol `_fltused`, which code with floating-point numbers names on Windows and nothing reads."""

NATIVE: Mapping[str, type[ctypes.c_double | ctypes.c_int64 | ctypes.c_void_p]] = {
    DOUBLE: ctypes.c_double,
    INTEGER: ctypes.c_int64,
    POINTER: ctypes.c_void_p,
}
"""Types of the C library by the types of LLVM."""

MAX_BYTES = 256 * 1024**2
"""The most that the folder contains: the files that were used longest ago are removed."""

SUFFIX, DIGEST = ".object", hashlib.sha256().digest_size

VARIABLE = "POINSOT_CACHE"

OTHERS = stat.S_IWGRP | stat.S_IWOTH

REMEDY = f"The run continues without it. Set {VARIABLE} to another folder, or to an empty text to use none."


def folder() -> Path | None:
    """Return the folder of the cache, `POINSOT_CACHE` or the system's folder for caches; None if it is turned off."""
    given = os.environ.get(VARIABLE)
    if given is not None:
        return Path(os.path.abspath(given)) if given else None
    place = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME", "")
    if not os.path.isabs(place):  # the standard ignores a relative path
        place = os.path.expanduser("~/Library/Caches" if sys.platform == "darwin" else "~/.cache")
    return Path(place) / "poinsot" if os.path.isabs(place) else None  # a user without a home


class ObjectCache:
    """Object code by keys, in a folder.

    Any number of processes and threads may use one folder. No failure stops a run: each gives one warning a process.

    Parameters
    ----------
    folder : Path or None
        None stores nothing.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder if folder is not None and _is_safe(folder) else None

    def load(self, key: str) -> bytes | None:
        """Return the object code of a key, if it is stored and undamaged."""
        if self._folder is None:
            return None
        path = self._folder / (key + SUFFIX)
        try:
            content = _content(path)
        except FileNotFoundError:
            return None
        except OSError as error:
            _warn(f"the cache folder {shortened(self._folder)} must be readable, got: {error.strerror}. {REMEDY}")
            return None
        if content is None or hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
            found = "a file that another user can write" if content is None else "damaged contents"
            _warn(f"a kernel in the cache must be as it was stored, got {found} in {shortened(path)}. It is removed.")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return content[DIGEST:]

    def store(self, key: str, code: bytes) -> None:
        """Store object code, whole or not at all."""
        if self._folder is None:
            return
        from poinsot.atomic_write import new_file

        try:
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_safe(self._folder):
                return
            with new_file(self._folder / (key + SUFFIX), overwrite=True) as part:
                number = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o600)
                with os.fdopen(number, "wb") as stream:
                    stream.write(hashlib.sha256(code).digest() + code)
            _evict(self._folder)
        except OSError as error:
            _warn(f"the cache folder {shortened(self._folder)} must be writable, got: {_reason(error)}. {REMEDY}")


def _evict(folder: Path) -> None:
    """Remove the files that were used longest ago until the others have room."""
    files = []
    for path in folder.glob(f"*{SUFFIX}"):
        with contextlib.suppress(FileNotFoundError):  # another process has removed it
            status = path.stat()
            files.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in files)
    for _, size, path in sorted(files):
        if total <= MAX_BYTES:
            break
        path.unlink(missing_ok=True)
        total -= size


def _content(path: Path) -> bytes | None:
    """Return the contents of a file; None if it is no regular file that only this user can write."""
    with contextlib.ExitStack() as stack:
        number = os.open(path, os.O_RDONLY | REGULAR_FILE)
        stream = stack.enter_context(os.fdopen(number, "rb"))
        status = os.fstat(number)
        if not stat.S_ISREG(status.st_mode) or not _is_own(status, {_user()}):
            return None
        return stream.read()


def _is_safe(folder: Path) -> bool:
    """Return True if only this user and root can change the contents of a folder; otherwise warn, if it exists.

    Others may write in folders above it whose sticky bit protects files of each user, such as /tmp.
    """
    place = Path(os.path.realpath(folder))
    for each in (place, *place.parents):
        try:
            status = os.stat(each)
        except FileNotFoundError:
            continue
        except OSError as error:
            _warn(f"the cache folder {shortened(folder)} must be readable, got: {error.strerror}. {REMEDY}")
            return False
        sticky = each != place and status.st_mode & stat.S_ISVTX and status.st_uid in (_user(), 0)
        if not stat.S_ISDIR(status.st_mode) or not (sticky or _is_own(status, {_user(), 0})):
            _warn(
                f"the cache folder {shortened(folder)} must be a folder that no other user can write, got "
                f"{shortened(each)}, {stat.filemode(status.st_mode)} of user {status.st_uid}. {REMEDY}"
            )
            return False
    return True


def _is_own(status: os.stat_result, users: set[int]) -> bool:
    """Return True if a file belongs to one of some users and nobody else can write it; on Windows, always."""
    return sys.platform == "win32" or (status.st_uid in users and not status.st_mode & OTHERS)


def _user() -> int:
    return os.geteuid() if hasattr(os, "geteuid") else 0


def _reason(error: OSError) -> str:
    """Return the message of the system; an error of `new_file` contains its message alone."""
    return error.strerror or str(error).rpartition("reported: ")[-1].rstrip(".")


@functools.lru_cache(64)
def _warn(sentence: str) -> None:
    """Warn once a process."""
    warnings.warn(sentence, stacklevel=level_of_user())


def function_of(module: Module, name: str) -> Callable[..., int]:
    """Return a function of a module, compiled or loaded from disk."""
    text, engine = module.functions[name], machine_code(str(module))
    kinds = [NATIVE[value.type] for value in text.arguments]
    function = ctypes.CFUNCTYPE(NATIVE.get(text.returns), *kinds)(engine.get_function_address(name))
    function.engine = engine  # type: ignore[attr-defined]  # the code lives as long as its owner
    return function


def symbols_of(system: str) -> dict[str, str | None]:
    """Return the functions that machine code may call on a system, by name the library that contains them.

    None is the program itself. On Windows a function with more than 4 KB on the stack calls `__chkstk`.
    """
    library = "ucrtbase" if system == "Windows" else None
    found: dict[str, str | None] = dict.fromkeys(("fma", *LIBRARY), library)
    if system == "Windows":
        found["__chkstk"] = "ntdll"
    return found


def machine_code(text: str) -> ExecutionEngine:
    """Compile a module, or load it from disk; return the owner of the code.

    A module may call some functions of the C library. On a processor that does not multiply and add in one instruction
    LLVM calls its `fma`, which gives the same bits in a much longer time.
    """
    binding = llvm()
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    for name, library in symbols_of(platform.system()).items():
        binding.add_symbol(name, ctypes.cast(getattr(ctypes.CDLL(library), name), ctypes.c_void_p).value)
    if platform.system() == "Windows":
        binding.add_symbol("_fltused", ctypes.addressof(USES_FLOATS))
    cpu, features = binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()
    level = CODE_GENERATION if len(text) <= MAX_OPTIMIZED else 0
    machine = binding.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=level)
    cache, key = ObjectCache(folder()), _key(text, machine.triple, cpu, features, level)
    code = cache.load(key)
    if code is None:
        code = machine.emit_object(binding.parse_assembly(text))
        cache.store(key, code)
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


def _key(text: str, *machine: str | int) -> str:
    """Return a hash of all data that determine the object code."""
    import llvmlite

    decided = (CODE_FORMAT, llvmlite.__version__, llvm().llvm_version_info, *machine)
    return hashlib.sha256(repr(decided).encode() + b"\0" + text.encode()).hexdigest()
