"""Machine code in tests: little is optimized, since it takes longer to compile than to run, and it is stored.

Kernels are compiled without optimization: three to five times as fast, to code that takes twice as long and gives the
same bits. The package's cache on disk lies in pytest's cache, so that another worker, or a later run, does not compile
a kernel again.
"""

import contextlib
import functools
import os
import warnings

from poinsot.taylor import object_cache


def pytest_configure(config):
    object_cache.CODE_GENERATION = 0
    with contextlib.suppress(ImportError):  # heyoka has wheels for Linux alone
        import heyoka as hy

        for name in ("taylor_adaptive", "taylor_adaptive_batch"):
            setattr(hy, name, functools.partial(getattr(hy, name), opt_level=0))
    if hasattr(config, "cache"):
        folder = config.cache.mkdir("kernels")
        folder.chmod(0o700)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            os.environ["POINSOT_CACHE"] = str(folder) if object_cache._is_safe(folder) else ""
