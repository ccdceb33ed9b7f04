"""Machine code in tests: little is optimized, since it takes longer to compile than to run, and it is kept.

Kernels are compiled without optimization: three to five times as fast, to code that takes twice as long and gives the
same bits. That of looped kernels is kept in pytest's cache: another worker, or a later run, does not compile it
again. The engine does the same with its own. The name of a file follows from all that decides what is in it.
"""

import functools
import hashlib
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import heyoka as hy

from poinsot.engine import llvm_ir, looped_kernel

WEEK = 7 * 86400.0


def pytest_configure(config):
    _do_not_optimize()
    try:
        import llvmlite
        import llvmlite.binding as llvm
    except ModuleNotFoundError:
        return
    if not hasattr(config, "cache"):
        return
    folder = config.cache.mkdir("kernels")
    machine = llvmlite.__version__, llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    looped: Any = looped_kernel
    plain, create = looped.machine_code, llvm.create_mcjit_compiler

    def machine_code(text, library):
        decided = repr((machine, llvm_ir.CODE_GENERATION, text)).encode()
        path = folder / hashlib.sha256(decided).hexdigest()

        def kept(_):
            try:
                code = path.read_bytes()
                os.utime(path)
            except FileNotFoundError:
                return None
            return code

        def create_with_cache(*given):
            engine = create(*given)
            engine.set_object_cache(lambda _, code: _write(path, code), kept)
            return engine

        llvm.create_mcjit_compiler = create_with_cache
        try:
            return plain(text, library)
        finally:
            llvm.create_mcjit_compiler = create

    looped.machine_code = machine_code


def _do_not_optimize():
    """Compile looped kernels and the engine's integrators as they are written."""
    llvm_ir.CODE_GENERATION = 0
    for name in ("taylor_adaptive", "taylor_adaptive_batch"):
        setattr(hy, name, functools.partial(getattr(hy, name), opt_level=0))


def _write(path, code):
    """Write a file that others see only when it is whole."""
    number, name = tempfile.mkstemp(dir=path.parent)
    with os.fdopen(number, "wb") as stream:
        stream.write(code)
    Path(name).replace(path)


def pytest_unconfigure(config):
    if hasattr(config, "cache") and not hasattr(config, "workerinput"):
        for path in config.cache.mkdir("kernels").iterdir():
            if path.stat().st_mtime < time.time() - WEEK:
                path.unlink(missing_ok=True)
