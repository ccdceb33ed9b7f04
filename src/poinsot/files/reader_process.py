"""Readers in C of untrusted files, each file in a separate process: a crash becomes an error message.

A clean process imports a reader once, and is forked for each file; it has one thread, and so no lock that another one
holds. The fork has limits of processor time, memory and open files. Windows cannot fork: there a process starts for
each file, with a limit of elapsed time alone. Both sides send messages: the length of a text in JSON, the text, and the
bytes of the arrays that it announces.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import json
import os
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

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

__all__ = ["Answer", "ReaderProcess", "serve", "serve_one"]

Arrays = Sequence[NDArray[Any]]

Answer = tuple[Any, list[NDArray[Any]]]

MIN_PROCESSOR_SECONDS = 1.0
"""Processor time for each question, in addition to the time for its size, seconds."""

ELAPSED_PER_PROCESSOR_SECOND = 60.0
"""Seconds that may pass for each second of processor time on a busy machine."""

MIN_MEMORY = 96 * 1024 * 1024
"""Bytes in addition to the memory of the libraries and of the file."""

MAX_TEXT_BYTES = 64 * 1024 * 1024

PAIR = struct.Struct("<qq")
"""Question to the clean process, the number of a process to end or 0 for a new one, and its answer."""

KINDS = {kind.__name__: kind for kind in (ValueError, TypeError)}
"""Errors that retain their class. All others become a ValueError."""

ENDS = {
    "SIGPROF": "it takes too much processor time",
    "SIGKILL": "it takes too long",
    "SIGSEGV": "its reader leaves the memory that it has",
    "SIGABRT": "its reader gives up",
}

EXIT_CODES = {3: "SIGABRT", 0xC0000005: "SIGSEGV"}
"""Exit codes of Windows, which has no signals."""

START = "import sys; sys.path[:] = {path!r}; from poinsot.files import reader_process; reader_process.{call}"
"""The program of a process that imports this package from where its parent does."""

FORKS = hasattr(os, "fork") and hasattr(socket, "send_fds")

_clean: dict[str, _Clean] = {}
_lock = threading.Lock()


class ReaderProcess:
    """Process that calls the functions of one module for one file. `close` ends it.

    The functions have values of JSON and arrays as arguments, and return a value of JSON and a list of arrays. `rule`
    precedes the reason in the error of a process that ends during a call. `memory` and `files` are bytes, and open
    files, that the reader may use in addition to the limits of all readers.
    """

    def __init__(self, module: str, rule: str, *, memory: int = 0, files: int = 0) -> None:
        self._process, self._rule = (_Forked if FORKS else _Spawned)(module), rule
        _send(self._process.input, {"folder": os.getcwd(), "memory": MIN_MEMORY + memory, "files": files}, ())

    def call(self, function: str, *values: Any, arrays: Arrays = (), seconds: float = 0.0) -> Answer:
        """Return the result of a function, or raise its error. `seconds` add to the limit of processor time."""
        seconds += MIN_PROCESSOR_SECONDS
        deadline = threading.Timer(ELAPSED_PER_PROCESSOR_SECOND * seconds, self._process.kill)
        deadline.daemon = True
        deadline.start()
        try:
            _send(self._process.input, {"function": function, "values": values, "seconds": seconds}, arrays)
            answer = _received(self._process.output)
        except (OSError, ValueError):
            answer = None
        finally:
            deadline.cancel()
        if answer is None:
            raise ValueError(f"{self._rule}{ENDS.get(self._process.close(), 'its reader ends')}.")
        header, found = answer
        if "error" in header:
            raise KINDS.get(header["kind"], ValueError)(str(header["error"]))
        return header["value"], found

    def close(self) -> None:
        """End the process."""
        self._process.close()


class _Forked:
    """Process for one file, forked from the clean process of its module."""

    def __init__(self, module: str) -> None:
        self._module = module
        ours, theirs = _pair()
        with theirs:
            self.pid = _asked(module, 0, theirs.fileno())
        self.input = self.output = ours.makefile("rwb")
        ours.close()

    def kill(self) -> None:
        os.kill(self.pid, signal.SIGKILL)

    def close(self) -> str:
        """End the process, and return the name of the signal that ended it."""
        pid, self.pid = self.pid, 0
        with contextlib.suppress(OSError):
            self.input.close()
        return _signal(os.WTERMSIG(_asked(self._module, pid))) if pid else ""


class _Spawned:
    """Process for one file, started for this file alone."""

    def __init__(self, module: str) -> None:
        self._killed = False
        self._process = _started(f"serve_one({module!r})", stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.pid, self.input, self.output = self._process.pid, self._process.stdin, self._process.stdout

    def kill(self) -> None:
        self._killed = True
        self._process.kill()

    def close(self) -> str:
        """End the process, and return the name of the signal that ended it."""
        for stream in (self.input, self.output):
            with contextlib.suppress(OSError):
                stream.close()  # type: ignore[union-attr]
        self._process.kill()
        code = self._process.wait()
        return "SIGKILL" if self._killed else EXIT_CODES.get(code, _signal(-code))


def _signal(number: int) -> str:
    return signal.Signals(number).name if number > 0 else ""


def _started(call: str, **streams: Any) -> subprocess.Popen[bytes]:
    """Start this Python with a call of this module, without imports of the user's environment."""
    path = [entry or os.getcwd() for entry in sys.path]
    return subprocess.Popen(  # noqa: S603 - this Python, and nothing of a file
        [sys.executable, "-I", "-c", START.format(path=path, call=call)],
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is heard in the parent
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # likewise, on Windows
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        **streams,
    )


class _Clean:
    """Clean process, which is forked for each file."""

    def __init__(self, module: str) -> None:
        self.socket, theirs = _pair()
        with theirs:
            call, files = f"serve({module!r}, {theirs.fileno()})", [theirs.fileno()]
            self.process = _started(call, pass_fds=files, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    def close(self) -> None:
        self.socket.close()
        self.process.wait()


def _pair() -> tuple[socket.socket, socket.socket]:
    pair = socket.socketpair()
    for end in pair:
        end.settimeout(None)  # whatever the default of this program
    return pair


def _asked(module: str, pid: int, *files: int) -> int:
    """Return the number of a new process that communicates through a file, or the exit status of a process."""
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
            _clean.pop(module).close()  # an answer to this question may still arrive
            if not isinstance(error, OSError | struct.error):
                raise
            raise RuntimeError(f"a process that reads files must start, got none for {module}.") from None


@atexit.register
def _close() -> None:
    while _clean:
        _clean.popitem()[1].close()


def _forget() -> None:
    """Forget the processes of the parent after a fork."""
    global _lock
    _lock = threading.Lock()
    for clean in _clean.values():
        clean.process.returncode = 0
    _clean.clear()


if FORKS:
    os.register_at_fork(after_in_child=_forget)


# ------------------------------------------------------------------ messages


def _send(stream: Any, header: dict[str, Any], arrays: Arrays) -> None:
    contiguous = [np.asarray(array, order="C") for array in arrays]
    text = json.dumps(header | {"arrays": [[array.dtype.str, array.shape] for array in contiguous]}).encode()
    stream.write(struct.pack("<Q", len(text)) + text)
    for array in contiguous:
        stream.write(_bytes_of(array))
    stream.flush()


def _received(stream: Any) -> tuple[dict[str, Any], list[NDArray[Any]]] | None:
    """Return a message, or None after the last one and for an incomplete one."""
    head = stream.read(8)
    if len(head) < 8:
        return None
    size = struct.unpack("<Q", head)[0]
    header = json.loads(stream.read(size) if size <= MAX_TEXT_BYTES else b"")
    return header, [_array(stream, str(kind), shape) for kind, shape in header.pop("arrays")]


def _array(stream: Any, kind: str, shape: Sequence[int]) -> NDArray[Any]:
    array = np.empty(tuple(map(int, shape)), dtype=kind)
    if array.dtype.kind not in "fiu" or stream.readinto(_bytes_of(array)) < array.nbytes:
        raise ValueError(kind)
    return array


def _bytes_of(array: NDArray[Any]) -> Any:
    return memoryview(array.reshape(-1).view("u1"))  # type: ignore[arg-type]


# ------------------------------------------------------------------ in the processes


def serve(module: str, file: int) -> None:
    """Fork for each file on request, and answer with the exit statuses of the forks."""
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
                with socket.socket(fileno=files[0]) as own:
                    stream = own.makefile("rwb")
                _serve_file(functions, stream, stream)
            os.close(files[0])
        control.sendall(PAIR.pack(answer, 0))


def serve_one(module: str) -> None:
    """Answer questions about one file through the standard streams."""
    nowhere, streams = os.open(os.devnull, os.O_RDWR), [os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")]
    for number in (0, 1):  # a library in C may write to them
        os.dup2(nowhere, number)
    _serve_file(importlib.import_module(module), *streams)


def _serve_file(functions: Any, questions: Any, answers: Any) -> None:
    """Answer questions until the last one, and end the process."""
    try:
        given, _ = _received(questions) or ({}, [])
        os.chdir(given["folder"])
        _limit(given["memory"], given["files"])
        while (question := _received(questions)) is not None:
            header, arrays = question
            _limit_time(header["seconds"])
            answer, found = _answer(getattr(functions, header["function"]), header["values"], arrays)
            _limit_time(0.0)
            _send(answers, answer, found)
    finally:
        os._exit(0)


def _answer(function: Any, values: list[Any], arrays: list[NDArray[Any]]) -> tuple[dict[str, Any], Arrays]:
    try:
        value, found = function(*values, *arrays)
    except MemoryError:
        return {"error": "a file must take little more memory than its size, got one that takes more.", "kind": ""}, []
    except Exception as error:  # what a library raises about a broken file is of any kind
        message = getattr(error, "strerror", None) or str(error) or type(error).__name__
        return {"error": message, "kind": type(error).__name__}, []
    return {"value": value}, found


def _limit(memory: int, files: int) -> None:
    """Limit memory and open files, and forbid writing to files and dumping a core."""
    if resource is None:
        return
    with open(os.devnull) as stream:
        most = {"NOFILE": stream.fileno() + files, "CORE": 0, "FSIZE": 0}
    with contextlib.suppress(FileNotFoundError), open("/proc/self/statm") as stream:  # macOS limits no memory
        most["AS"] = int(stream.read().split()[0]) * resource.getpagesize() + memory
    for name, value in most.items():
        resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (value, value))


def _limit_time(seconds: float) -> None:
    """End this process after a further processor time; 0 removes the limit."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, seconds)
