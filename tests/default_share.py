"""The default run takes a share of the cases of large tests; the rest is marked `slow`.

A test of more than SHARE cases runs one of SHARE, chosen by a hash of their ids, and of the others each with an entry
of a list that no test of its module runs otherwise. So a product keeps about a quarter of its cases; a list that one
test alone goes through (of wrong calls, say) is run whole, unless it is marked as `samples` of one statement; and where
several tests go through one list (of forces, of parts), each takes other members of it.
"""

import math
import zlib
from collections import defaultdict

import pytest

SHARE = 4


@pytest.hookimpl(tryfirst=True)  # before pytest leaves out what `-m` does not ask for
def pytest_collection_modifyitems(config, items):
    if config.getoption("--margins", None) or config.getoption("--shake", None) is not None:
        return  # bounds are measured on all cases
    modules = defaultdict(lambda: defaultdict(list))
    for item in items:
        if not any(item.get_closest_marker(mark) for mark in ("slow", "docs", "browser")):
            modules[item.path][item.nodeid.partition("[")[0]].append(item)
    for tests in modules.values():
        for case in _rest(tests.values()):
            case.add_marker("slow")


def _rest(tests):
    """Return the cases that the default run leaves out, from the tests of a module."""
    taken, others = [], []
    for cases in tests:
        few = len(cases) if len(cases) <= SHARE else math.ceil(len(cases) / SHARE)
        in_order = sorted(cases, key=_hash)
        taken += in_order[:few]
        others += in_order[few:]
    seen = {entry for case in taken for entry in _entries(case)}
    rest = []
    for case in others:
        if _entries(case) <= seen:
            rest.append(case)
        seen |= _entries(case)
    return rest


def _hash(case):
    """Return what is the same in every process, which Python's own hash of a text is not."""
    return zlib.crc32(case.nodeid.encode())


def _entries(case):
    """Return which entry of which list each parametrisation of a case takes; parameters of fixtures are their own."""
    if not hasattr(case, "callspec") or case.get_closest_marker("samples"):
        return set()
    values = {name: id(value) for name, value in case.callspec.params.items()}
    entries = set()
    for mark in case.iter_markers("parametrize"):
        names = (mark.args[0],) if isinstance(mark.args[0], str) else mark.args[0]
        entries.add((id(mark.args[1]), *(values.pop(name) for name in names)))
    return entries | set(values.items())
