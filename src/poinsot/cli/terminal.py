"""Shared by the commands: exit statuses, error messages, and progress on a terminal."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import math
import os
import re
import shlex
import shutil
import signal
import sys
import textwrap
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typing_extensions import override

from poinsot.display.progress import later
from poinsot.habits import HABITS
from poinsot.printable import printable, quoted

if TYPE_CHECKING:
    from poinsot.propagation.trajectory import Trajectory

__all__ = [
    "DIFFERS",
    "IMPORT",
    "INTERRUPTED",
    "OPTIONS",
    "RESULTS",
    "STOPPED",
    "Command",
    "Commands",
    "Group",
    "Json",
    "Member",
    "OfTwo",
    "Overwrite",
    "advise",
    "answer",
    "busy",
    "check_ending",
    "check_new",
    "check_there",
    "checked_result",
    "exit_statuses",
    "hand_over",
    "hand_over_json",
    "listed_formats",
    "loaded_motion",
    "one_of",
    "opened",
    "report_path",
    "results_written_first",
    "say",
]


def one_of(*words: str) -> Callable[[str], list[str]]:
    """Return a function that completes one of some words in a shell."""
    return lambda incomplete: [word for word in words if word.startswith(incomplete)]


OfTwo = Annotated[
    str | None,
    typer.Option(
        "--body", help="Body of a two-body system: primary or secondary.", autocompletion=one_of("primary", "secondary")
    ),
]
Member = Annotated[int | None, typer.Option(min=0, help="Index of the ensemble member; the first has index 0.")]
Json = Annotated[bool, typer.Option("--json", help="Print the output as JSON.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]

DIFFERS, WRONG, STOPPED, INTERRUPTED, TERMINATED = 1, 2, 3, 130, 143

STATUSES = {
    0: "success",
    WRONG: "invalid option, file or value",
    INTERRUPTED: "interrupted by Ctrl-C",
    TERMINATED: "terminated by SIGTERM",
}

RESULTS = (".nc", ".zarr")

OPTIONS = {
    **{name: f"--{name}" for name in ("body", "chunk", "frame", "member", "orbit", "out", "overwrite")},
    **{name: f"--{name}" for name in ("part", "quantity", "scenario", "zero")},
    **{"client": "--scheduler", "others": "--with"},
    **{"angle_unit": "--angle-unit", "rate_unit": "--rate-unit", "time_unit": "--time-unit", "other": "--with"},
    "seconds": "--seconds",
    **{"ensemble": "the result", "reference_frame": "--frame", "epoch": "--zero", "calendar": "--zero"},
    **{"scale": "the scale in --zero", "motion": "the result"},
}
"""Command-line names of the arguments of functions."""

NO_OUT = tuple(f"No such option: {option}" for option in ("-o", "--out", "--output"))
"""Messages of commands without such an option."""

WITH_TARGET = ("plot", "view", "animate", "convert")
"""Commands whose second argument is the file to write."""

UsageError: Any = typer.BadParameter.__bases__[0]
"""Exception for an invalid command line."""

KEYWORD = re.compile(r"\b(\w+)=(?:True|'(\w+)'|Calendar\('([^']+)', '([^']+)'\))")
"""An argument as a hint writes it: overwrite=True, reference_frame='ICRF'."""


def exit_statuses(own: dict[int, str]) -> str:
    """Return the list of the exit statuses of a command, general and specific ones."""
    return f"Exit status: {', '.join(f'{code} ({what})' for code, what in sorted((STATUSES | own).items()))}."


# ------------------------------------------------------------------ words


def say(sentence: str) -> None:
    """Write a sentence to the standard error; on a terminal on separate lines above the progress displays."""
    text = printable(sentence)
    if not sys.stderr.isatty():
        typer.echo(text, err=True)
        return
    from rich.text import Text

    displays = [progress for display in _displays for progress in display]
    if displays:
        displays[-1].console.print(Text(text))
    else:
        typer.echo(f"\r{_fitted(text)}", err=True)  # over the ^C that a terminal shows


def answer(*lines: str) -> None:
    """Write lines to the standard output; those too long for a terminal are broken between words."""
    fitted = _fitted if sys.stdout.isatty() else str
    typer.echo("\n".join(fitted(printable(line)) for line in lines))


def _fitted(line: str) -> str:
    """Return a line in as many as it needs on the terminal, the others further in than the first."""
    indent = " " * (len(line) - len(line.lstrip()) + 4 * line.startswith(" "))
    columns = shutil.get_terminal_size().columns
    return textwrap.fill(
        line, columns, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False, drop_whitespace=True
    )


def hand_over(text: str) -> None:
    """Write a text to the standard output: as it is for a file or a program, and as it can be seen for a terminal."""
    if sys.stdout.isatty():
        typer.echo("\n".join(map(printable, text.removesuffix("\n").split("\n"))))
    else:
        typer.echo(text, nl=False)


def hand_over_json(content: Any) -> None:
    """Write JSON to the standard output: NumPy numbers as numbers, infinite and undefined numbers as null."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [plain(item) for item in value]
        value = value.item() if hasattr(value, "item") else value
        return None if isinstance(value, float) and not math.isfinite(value) else value

    hand_over(json.dumps(plain(content), indent=1, allow_nan=False) + "\n")


def report_path(path: Path) -> None:
    """Write the path of a file that was written, if the standard output is open."""
    if sys.stdout.writable():
        hand_over(f"{path}\n")


def advise(*steps: tuple[str, str]) -> None:
    """Print the next commands on a terminal, each with its purpose."""
    if sys.stderr.isatty():
        width = max(len(command) for command, _ in steps)
        lines = [f"  {printable(command):{width}}  # {what}" for command, what in steps]
        typer.echo("\n".join(["Next:", *lines]), err=True)


def opened(command: str, *paths: Path) -> str:
    """Return a command on files, quoted as a shell needs it."""
    return " ".join(["poinsot", command, *(shlex.quote(str(path)) for path in paths)])


def listed_formats() -> str:
    """Return the formats of attitude files, with the ends of their names."""
    from poinsot.files.attitudes.attitude_format import attitude_formats

    return ", ".join(f"{each.title} ({', '.join(each.suffixes)})" for each in attitude_formats())


class Command(TyperCommand):
    """Command whose errors are one sentence each. Its help lists the file formats, and no types of flags."""

    @override
    def invoke(self, ctx: Any) -> Any:
        with _sentences():
            return super().invoke(ctx)

    @override
    def format_help(self, ctx: Any, formatter: Any) -> None:
        self.help = (self.help or "").replace("{attitudes}", listed_formats())
        _without_types_of_flags(self, ctx)
        super().format_help(ctx, formatter)


IMPORT = "--import"
"""Option with a module of the user, which is imported before any command."""


class Group(TyperGroup):
    """Group of commands whose help omits the types of flags, and whose usage errors are single sentences."""

    @override
    def make_context(self, *arguments: Any, **options: Any) -> Any:
        with _usage():
            return super().make_context(*arguments, **options)

    @override
    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the options of all commands; `--import MODULE` may also stand behind the command."""
        found = [i for i in range(len(args) - 1) if args[i] == IMPORT and "--" not in args[:i]]
        pairs = [part for i in found for part in args[i : i + 2]]
        others = [args[i] for i in range(len(args)) if i not in found and i - 1 not in found]
        return super().parse_args(ctx, [*pairs, *others])

    @override
    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if answer := HABITS["commands"].get(args[0]):
            raise UsageError(f"No such command {quoted(args[0])}. Write {answer}", ctx)
        return super().resolve_command(ctx, args)

    @override
    def invoke(self, ctx: Any) -> Any:
        with _usage(), _sentences():
            return super().invoke(ctx)

    @override
    def format_help(self, ctx: Any, formatter: Any) -> None:
        _without_types_of_flags(self, ctx)
        super().format_help(ctx, formatter)


def _without_types_of_flags(command: Any, ctx: Any) -> None:
    for parameter in command.get_params(ctx):
        if getattr(parameter, "is_flag", False):
            parameter.metavar = ""


class Commands(typer.Typer):
    """Commands whose help and usage, too, end in a sentence where they cannot be written."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run the command line."""
        with _terminated() as heard, _open_streams():
            try:
                return super().__call__(*arguments, **options)
            except OSError as error:
                say(f"poinsot: {_sentence(error)}")
                sys.exit(WRONG)
            except SystemExit as ended:
                if ended.code == INTERRUPTED and heard:
                    sys.exit(TERMINATED)
                if isinstance(ended.__context__, BrokenPipeError):  # for example `head`, which has read enough
                    sys.exit(0)
                raise


class _ClosedOutput(io.TextIOBase):
    """The standard output of a process that was started without one."""

    @override
    def write(self, text: str) -> int:
        if text:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF), "the standard output")
        return 0


@contextlib.contextmanager
def _open_streams() -> Iterator[None]:
    """Replace standard streams that were closed before the process started, for which Python has None.

    Messages to a closed standard error are lost; output to a closed standard output is an error. Characters that the
    encoding of a stream lacks are written as escapes.
    """
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        before = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = sys.stdout or _ClosedOutput(), sys.stderr or nowhere
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
                stream.reconfigure(errors="backslashreplace")
        try:
            yield
        finally:
            sys.stdout, sys.stderr = before


@contextlib.contextmanager
def _terminated() -> Iterator[list[int]]:
    """Treat SIGTERM like Ctrl-C, even if the shell ignores Ctrl-C; yield the list of received signals.

    An ignored Ctrl-C stays without effect: it has the usual handler, to which SIGTERM leads, and is blocked.
    """
    heard = list[int]()

    def interrupt(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        as_interrupt = signal.getsignal(signal.SIGINT)
        if not callable(as_interrupt):
            raise KeyboardInterrupt
        as_interrupt(number, frame)

    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN and hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        signal.signal(signal.SIGINT, signal.default_int_handler)
    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield heard
    finally:
        signal.signal(signal.SIGTERM, before)


@contextlib.contextmanager
def _sentences() -> Iterator[None]:
    """Print errors, warnings and Ctrl-C as one sentence each, and exit with the corresponding status."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield
        except (typer.Exit, BrokenPipeError):
            raise
        except KeyboardInterrupt:
            say("poinsot: interrupted. Only the files named above were written.")
            raise typer.Exit(INTERRUPTED) from None
        except (OSError, ValueError, IndexError, ImportError, MemoryError, RuntimeError) as error:
            say(f"poinsot: {_sentence(error)}")
            raise typer.Exit(WRONG) from None
        finally:
            for message in dict.fromkeys(str(warning.message) for warning in caught if warning.category is UserWarning):
                say(f"warning: {message}")


@contextlib.contextmanager
def _usage() -> Iterator[None]:
    """Print a usage error as a sentence."""
    try:
        yield
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # its help is on the screen
            raise
        message, help_of = error.format_message().rstrip("."), error.ctx.command_path if error.ctx else "poinsot"
        if message in NO_OUT and error.ctx.info_name in WITH_TARGET:
            message += ". The file to write is the argument after FILE"
        stop = "" if message.endswith("?") else "."
        say(f"poinsot: {message}{stop} `{help_of} --help` lists the commands and options.")
        raise typer.Exit(WRONG) from None


def _sentence(error: Exception) -> str:
    """Return the message of an error with the names of the command line."""
    if isinstance(error, OSError) and error.strerror:
        name = error.filename or "the output"
        return f"{name} must be a file that can be used, but the operating system reported: {error.strerror}."
    message = (str(error) or f"it ended in {type(error).__name__}.").replace("motion.member(0)", "--member 0")
    name, _, rest = message.partition(" ")
    return KEYWORD.sub(_option, f"{OPTIONS.get(name, name) if rest.startswith('must ') else name} {rest}")


def _option(keyword: re.Match[str]) -> str:
    """Return an argument of a hint as an option of the command line."""
    name, text, date, scale = keyword.groups()
    value = f" '{date} {scale}'" if date else f" {text}" if text else ""
    option = OPTIONS.get(name, "")
    return f"{option}{value}" if option.startswith("--") else keyword[0]


# ------------------------------------------------------------------ files


def check_there(path: Path) -> None:
    """Raise a FileNotFoundError for a path that does not exist."""
    from poinsot.atomic_write import exists

    if not exists(path):
        raise FileNotFoundError(f"No such file: {path}")


def loaded_motion(file: Path) -> Trajectory:
    """Return the motion in a result; a store may have other things."""
    from poinsot.files.netcdf import load

    motion = load(file)
    if not hasattr(motion, "provenance"):
        raise ValueError(
            f"{file} must have a motion, quaternions and momenta at the same times, got another dataset. "
            "`poinsot info` lists its variables."
        )
    return motion


def check_ending(path: Path, *endings: str) -> None:
    """Raise a ValueError for a path with another ending."""
    if path.suffix not in endings:
        raise ValueError(f"{path} must end in {', '.join(endings)}, got {path.suffix or 'no ending'}.")


def check_new(path: Path, overwrite: bool, more: str = "") -> None:
    """Raise an OSError, before the computation, for a file that exists or in a folder that does not exist."""
    if path.is_dir() and path.suffix != ".zarr":
        raise IsADirectoryError(f"{path} must be the name of a file, got a folder.")
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} already exists; use --overwrite{more}.")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"No such folder: {path.parent}")


def checked_result(file: Path) -> Path:
    """Return the path of a result; for another file, the error names the command that makes a result of it."""
    if file.suffix in RESULTS:
        check_there(file)
        return file
    from poinsot.files.attitudes.attitude_format import format_of

    hint = f" `poinsot run {file}` writes one." if file.suffix == ".toml" else ""
    if format_of(file):
        hint = f" `poinsot convert {file} NAME.nc --scenario ...` writes one."
    raise ValueError(f"{file} must be a result, {' or '.join(RESULTS)}, but it is none.{hint}")


@contextlib.contextmanager
def results_written_first() -> Iterator[None]:
    """Delay a Ctrl-C until the computed results are written; a second Ctrl-C acts at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before, heard = signal.getsignal(signal.SIGINT), list[int]()

    def note(number: int, _: FrameType | None) -> None:
        heard.append(number)
        signal.signal(signal.SIGINT, before)
        say("Writing the computed results first. Press Ctrl-C again to discard them.")

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if heard:
        raise KeyboardInterrupt


# ------------------------------------------------------------------ progress displays

_displays: list[list[Any]] = []
"""Progress displays on the terminal, each empty until it is shown."""


@contextlib.contextmanager
def busy(what: str) -> Iterator[None]:
    """Show on a terminal an operation in progress and its elapsed time."""

    def begun() -> Any:
        from rich.console import Console
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
        progress = Progress(*columns, console=Console(stderr=True), transient=True)
        progress.add_task(printable(what), total=None)
        return progress

    if not sys.stderr.isatty():
        yield
        return
    with later(begun) as display:
        _displays.append(display)
        try:
            yield
        finally:
            _displays.pop()
