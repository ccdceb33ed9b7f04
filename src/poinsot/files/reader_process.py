"""Readers in C of untrusted files, each file in a separate process: a crash becomes an error message.

A clean process imports a reader once, and is forked for each file; it has one thread, and so no lock that another one
holds. The fork has limits of processor time, memory and open files. Both sides send messages: the length of a text in
JSON, the text, and the bytes of the arrays that it announces.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import json
import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Answer", "ReaderProcess", "serve"]

Arrays = Sequence[NDArray[Any]]

Answer = tuple[Any, list[NDArray[Any]]]

MIN_PROCESSOR_SECONDS = 1.0
"""Processor time for each question, in addition to the time for its size, seconds."""

ELAPSED_PER_PROCESSOR_SECOND = 60.0
"""Seconds that may pass for each second of processor time, on a machine that has much else to do."""

MIN_MEMORY = 96 * 1024 * 1024
"""Bytes in addition to the memory of the libraries and of the file."""

MAX_TEXT_BYTES = 64 * 1024 * 1024

PAIR = struct.Struct("<qq")
"""What is said to the clean process: a number of a process to end, or 0 for a new one; and what it says."""

KINDS = {kind.__name__: kind for kind in (ValueError, TypeError)}
"""Errors that keep their kind; all others are a ValueError."""

ENDS: dict[int, str] = {
    signal.SIGPROF: "it takes too much processor time",
    signal.SIGKILL: "it takes too long",
    signal.SIGSEGV: "its reader leaves the memory that it has",
    signal.SIGABRT: "its reader gives up",
}

START = "import sys; sys.path[:] = {path!r}; from poinsot.files.reader_process import serve; serve({module!r}, {file})"

_clean: dict[str, _Clean] = {}
_lock = threading.Lock()


class ReaderProcess:
    """A process that calls the functions of one module about one file, to be closed in the end.

    The functions take values of JSON, and arrays after them, and return one and a list of arrays. `rule` stands before
    the reason in the error of a process that does not survive a call; `memory` and `files` are the bytes, and the files
    kept open, that the reader may take more than others.
    """

    def __init__(self, module: str, rule: str, *, memory: int = 0, files: int = 0) -> None:
        self._module, self._rule = module, rule
        ours, theirs = _pair()
        with theirs:
            self._pid = _asked(module, 0, theirs.fileno())
        self._stream = ours.makefile("rwb")
        ours.close()
        _send(self._stream, {"folder": os.getcwd(), "memory": MIN_MEMORY + memory, "files": files}, ())

    def call(self, function: str, *values: Any, arrays: Arrays = (), seconds: float = 0.0) -> Answer:
        """Return what a function returns, or raise its error; `seconds` of processor time more than others may pass."""
        seconds += MIN_PROCESSOR_SECONDS
        deadline = threading.Timer(ELAPSED_PER_PROCESSOR_SECOND * seconds, os.kill, (self._pid, signal.SIGKILL))
        deadline.daemon = True
        deadline.start()
        try:
            _send(self._stream, {"function": function, "values": values, "seconds": seconds}, arrays)
            answer = _received(self._stream)
        except (OSError, ValueError):
            answer = None
        finally:
            deadline.cancel()
        if answer is None:
            raise ValueError(f"{self._rule}{ENDS.get(self.close(), 'its reader ends')}.")
        said, found = answer
        if "error" in said:
            raise KINDS.get(said["kind"], ValueError)(str(said["error"]))
        return said["value"], found

    def close(self) -> int:
        """End the process, and return the signal that it ended with."""
        pid, self._pid = self._pid, 0
        with contextlib.suppress(OSError):
            self._stream.close()
        return os.WTERMSIG(_asked(self._module, pid)) if pid else 0


class _Clean:
    """The process that is forked."""

    def __init__(self, module: str) -> None:
        self.socket, theirs = _pair()
        path = [entry or os.getcwd() for entry in sys.path]
        with theirs:
            self.process = subprocess.Popen(  # noqa: S603 - this Python, and nothing of a file
                [sys.executable, "-I", "-c", START.format(path=path, module=module, file=theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is heard here
                env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            )

    def close(self) -> None:
        self.socket.close()
        self.process.wait()


def _pair() -> tuple[socket.socket, socket.socket]:
    pair = socket.socketpair()
    for end in pair:
        end.settimeout(None)  # whatever the default of this program
    return pair


def _asked(module: str, pid: int, *files: int) -> int:
    """Return the number of a new process that talks through a file, or how an old one ended."""
    with _lock:
        clean = _clean.get(module)
        if clean is not None and clean.process.poll() is not None:
            _clean.pop(module).close()
            clean = None
        clean = _clean.setdefault(module, clean or _Clean(module))
        try:
            socket.send_fds(clean.socket, [PAIR.pack(pid, 0)], files)
            answer = clean.socket.recv(PAIR.size, socket.MSG_WAITALL)
            return int(PAIR.unpack(answer)[0])
        except BaseException as error:
            _clean.pop(module).close()  # an answer may be on its way that nobody hears
            if not isinstance(error, OSError | struct.error):
                raise
            raise RuntimeError(f"a process that reads files must start, got none for {module}.") from None


@atexit.register
def _close() -> None:
    while _clean:
        _clean.popitem()[1].close()


def _forget() -> None:
    """Leave the processes to the one that this process was forked from."""
    global _lock
    _lock = threading.Lock()
    for clean in _clean.values():
        clean.process.returncode = 0
    _clean.clear()


os.register_at_fork(after_in_child=_forget)


# ------------------------------------------------------------------ messages


def _send(stream: Any, said: dict[str, Any], arrays: Arrays) -> None:
    kept = [np.asarray(array, order="C") for array in arrays]
    text = json.dumps(said | {"arrays": [[array.dtype.str, array.shape] for array in kept]}).encode()
    stream.write(struct.pack("<Q", len(text)) + text)
    for array in kept:
        stream.write(_bytes_of(array))
    stream.flush()


def _received(stream: Any) -> tuple[dict[str, Any], list[NDArray[Any]]] | None:
    """Return a message, None where there are no more or it ends before its end."""
    head = stream.read(8)
    if len(head) < 8:
        return None
    size = struct.unpack("<Q", head)[0]
    said = json.loads(stream.read(size) if size <= MAX_TEXT_BYTES else b"")
    return said, [_array(stream, str(kind), shape) for kind, shape in said.pop("arrays")]


def _array(stream: Any, kind: str, shape: Sequence[int]) -> NDArray[Any]:
    array = np.empty(tuple(map(int, shape)), dtype=kind)
    if array.dtype.kind not in "fiu" or stream.readinto(_bytes_of(array)) < array.nbytes:
        raise ValueError(kind)
    return array


def _bytes_of(array: NDArray[Any]) -> Any:
    return memoryview(array.reshape(-1).view("u1"))  # type: ignore[arg-type]


# ------------------------------------------------------------------ in the processes


def serve(module: str, file: int) -> None:
    """Fork for each file that is asked for, and tell how the forks ended."""
    functions = importlib.import_module(module)
    control = socket.socket(fileno=file)
    while True:
        asked, files, _, _ = socket.recv_fds(control, PAIR.size, 1)
        if len(asked) < PAIR.size:
            return
        pid = PAIR.unpack(asked)[0]
        if pid:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
            answer = os.waitpid(pid, 0)[1]
        else:
            answer = os.fork()
            if not answer:
                control.close()
                _serve_file(functions, files[0])
            os.close(files[0])
        control.sendall(PAIR.pack(answer, 0))


def _serve_file(functions: Any, file: int) -> None:
    """Answer questions until there are no more, and end."""
    try:
        with socket.socket(fileno=file) as own:
            stream = own.makefile("rwb")
        given, _ = _received(stream) or ({}, [])
        os.chdir(given["folder"])
        _limit(given["memory"], given["files"])
        while (question := _received(stream)) is not None:
            said, arrays = question
            signal.setitimer(signal.ITIMER_PROF, said["seconds"])
            answer, found = _answer(getattr(functions, said["function"]), said["values"], arrays)
            signal.setitimer(signal.ITIMER_PROF, 0)
            _send(stream, answer, found)
    finally:
        os._exit(0)


def _answer(function: Any, values: list[Any], arrays: list[NDArray[Any]]) -> tuple[dict[str, Any], Arrays]:
    try:
        value, found = function(*values, *arrays)
    except MemoryError:
        return {"error": "a file must take little more memory than its size, got one that takes more.", "kind": ""}, []
    except Exception as error:  # what a library raises about a broken file is of any kind
        said = getattr(error, "strerror", None) or str(error) or type(error).__name__
        return {"error": said, "kind": type(error).__name__}, []
    return {"value": value}, found


def _limit(memory: int, files: int) -> None:
    """Bound the memory and the open files from now on; nothing is written, and no core is dumped."""
    with open("/proc/self/statm") as stream:
        used = int(stream.read().split()[0]) * resource.getpagesize()
        free = stream.fileno()
    most = {"AS": used + memory, "NOFILE": free + files, "CORE": 0, "FSIZE": 0}
    for name, value in most.items():
        resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (value, value))
