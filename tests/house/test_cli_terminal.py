"""The command line as a terminal sees it: bars, Ctrl-C, pipes, and how soon it answers."""

import ast
import dataclasses
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import forked
import poinsot as pt
from poinsot.cli import app, terminal
from poinsot.validation import cases, paper

TOP = """\
title = "a top"
body.moments = [1.25, 1.0, 0.75]
state = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 1, 0.2]}
forces = [{type = "UniformGravity", weight = 0.5, center_of_mass = [1, 0, 0]}]
"""
EXACT = """\
title = "a top"
body.moments = [1.25, 1.0, 0.75]
state = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 1, 0.2]}
times = {stop = 10, count = 11}
run.method = "closed form"
"""
ENSEMBLE = '[ensemble]\nmembers = 40\nseed = 1\n[[ensemble.spread]]\nof = "state.omega_body"\nsize = 0.1\n'

INTERRUPT = """
import os, signal, sys
from importlib import import_module
number = int(sys.argv.pop(1))
owner = import_module(sys.argv.pop(1))
*path, name = sys.argv.pop(1).split(".")
at, calls = int(sys.argv.pop(1)), []
for part in path:
    owner = getattr(owner, part)
right = getattr(owner, name)
def patched(*arguments, **options):
    calls.append(1)
    if len(calls) == at:
        os.kill(os.getpid(), number)
    return right(*arguments, **options)
setattr(owner, name, patched)
from poinsot.cli import app
app()
"""


SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143}
LOOPED = "poinsot.integration.run"


def interrupted(module, name, at, *arguments, number=signal.SIGINT):
    """Run the command in a process of its own, which gets a signal at the n-th call of a function of the package."""
    done = forked.run(INTERRUPT, int(number), module, name, at, *arguments)
    assert done.returncode == SIGNALS[number], done.stderr
    assert "Traceback" not in done.stderr
    return done


# ------------------------------------------------------------------ Ctrl-C


@pytest.mark.parametrize(
    ("number", "kernel", "name"),
    [
        (signal.SIGINT, LOOPED, "Slab._check_progress"),
        (signal.SIGTERM, LOOPED, "Slab._check_progress"),
    ],
)
def test_single_run_keeps_what_there_is(tmp_path, number, kernel, name):
    scenario = tmp_path / "long.toml"
    scenario.write_text(TOP + "times = {stop = 1e9, step = 1e3}\n")
    done = interrupted(kernel, name, 3, "run", scenario, number=number)
    partial = pt.load(tmp_path / "long.partial.nc")
    assert f"The output times reached so far are in {tmp_path}/long.partial.nc." in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""
    assert 2 <= partial.times.size < 100
    assert max(abs(partial.drift["energy"])) < 1e-11
    assert {path.name for path in tmp_path.iterdir()} == {"long.toml", "long.partial.nc"}


@pytest.mark.parametrize(
    ("number", "kernel", "name", "at"),
    [
        (signal.SIGINT, LOOPED, "Slab._check_progress", 5),
        (signal.SIGTERM, LOOPED, "Slab._check_progress", 5),
    ],
)
def test_ensemble_keeps_the_members_that_are_done(tmp_path, number, kernel, name, at):
    scenario = tmp_path / "tops.toml"
    scenario.write_text(TOP + "times = {stop = 3e4, count = 11}\n" + ENSEMBLE)
    done = interrupted(kernel, name, at, "run", scenario, "--threads", "1", number=number)
    assert re.search(
        r"propagation was interrupted: \d+ of 40 members are done\. The output times reached so far are in ",
        done.stderr,
    )
    output_text = CliRunner().invoke(app, ["info", str(tmp_path / "tops.partial.nc")]).stdout
    finished = np.isfinite(pt.load(tmp_path / "tops.partial.nc").quaternion[..., 0])
    assert np.array_equal(finished.any(axis=1), finished.all(axis=1))
    assert 0 < int(re.search(r"at the last time: (\d+) of 40 members", output_text)[1]) == finished[:, 0].sum() < 40


@pytest.mark.parametrize("number", SIGNALS)
def test_an_interrupted_store_says_the_command_that_goes_on(tmp_path, number):
    scenario, store = tmp_path / "my tops.toml", tmp_path / "tops.zarr"
    scenario.write_text(TOP + "times = {stop = 30, count = 11}\n" + ENSEMBLE)
    command = ("run", scenario, "--out", store, "--chunk", "8", "--threads", "1")
    done = interrupted("poinsot.storage.ensemble_store", "EnsembleStore.write", 3, *command, number=number)
    goes_on = f"poinsot run '{scenario}' --out {store} --resume"
    message = re.fullmatch(
        r"poinsot: propagation was interrupted: (\d+) of 40 members are done\. `(.*)` continues the run\.\n",
        done.stderr,
    )
    assert message[2] == goes_on
    assert int(message[1]) in (16, 24)
    invoked(*shlex.split(goes_on)[1:], code=0)
    invoked("run", scenario, "--out", tmp_path, code=0)
    whole, found = pt.load(tmp_path / "my tops.nc"), pt.load(store)
    assert np.asarray(found.quaternion).tobytes() == whole.quaternion.tobytes()


def test_signal_from_outside_ends_a_run_that_ignores_interrupts(tmp_path):
    """As a shell starts it in the background."""
    scenario = tmp_path / "tops.toml"
    scenario.write_text(TOP + "times = {stop = 1e9, count = 11}\n" + ENSEMBLE)
    code = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from poinsot.cli import app; app()"
    owner, name = "run import Slab", "advance"
    output_text = f"from poinsot.integration.{owner} as owner; right = owner.{name}\n"
    # One write for the word and its line end: threads write it at the same time.
    output_text += f"owner.{name} = lambda *a: (print('begun\\n', end='', flush=True), right(*a))[1]\n"
    command = [sys.executable, "-c", output_text + code, "run", str(scenario)]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    begun = running.stdout.readline()
    running.terminate()
    _, message = running.communicate(timeout=60)
    assert begun == "begun\n"
    assert running.returncode == 143, message
    assert "propagation was interrupted" in message
    assert "Traceback" not in message


def test_interrupt_before_anything_is_computed_is_a_sentence(tmp_path):
    (tmp_path / "top.toml").write_text(TOP + "times = {stop = 10, count = 11}\n")
    done = interrupted("poinsot.integration.equations", "traced_equations", 1, "run", tmp_path / "top.toml")
    assert done.stderr == "poinsot: interrupted. Only the files named above were written.\n"
    assert [path.name for path in tmp_path.iterdir()] == ["top.toml"]


@pytest.fixture
def interrupting(monkeypatch):
    """Send Ctrl-C to this process at the n-th call of a function."""

    def patch(owner, name, at=1):
        right, calls = getattr(owner, name), []

        def patched(*arguments, **options):
            calls.append(1)
            if len(calls) == at:
                os.kill(os.getpid(), signal.SIGINT)
            return right(*arguments, **options)

        monkeypatch.setattr(owner, name, patched)

    return patch


def invoked(*arguments, code=130):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "300"})
    assert result.exit_code == code, (result.output, result.exception)
    return result


@pytest.fixture
def result(tmp_path):
    (tmp_path / "top.toml").write_text(EXACT)
    invoked("run", tmp_path / "top.toml", code=0)
    return tmp_path / "top.nc"


def test_result_is_written_before_an_interrupt_is_heard(tmp_path, interrupting, result):
    from poinsot.files import netcdf

    before = result.read_bytes()
    result.unlink()
    interrupting(netcdf, "new_file")
    message = invoked("run", tmp_path / "top.toml").stderr
    assert "Writing the computed results first. Press Ctrl-C again to discard them." in message
    assert pt.load(result).times.size == 11
    assert len(result.read_bytes()) == len(before)


@pytest.mark.parametrize("command", ["plot", "view", "animate"])
def test_pictures_are_whole_or_not_there(interrupting, result, command):
    from matplotlib.figure import Figure

    from poinsot.plot import animation, view

    where = {"plot": (Figure, "savefig"), "view": (view, "view"), "animate": (animation, "_draw")}
    interrupting(*where[command])
    message = invoked(command, result).stderr
    assert message == "poinsot: interrupted. Only the files named above were written.\n"
    assert {path.name for path in result.parent.iterdir()} == {"top.toml", "top.nc"}


def test_verify_shows_what_it_compared(interrupting, monkeypatch):
    cheap = [case for case in cases.CASES if case.title in ("4179 Toutatis", "Fast heavy top")]
    monkeypatch.setattr(cases, "CASES", cheap)
    interrupting(cases, "comparisons_of", 2)
    message = invoked("verify")
    assert cheap[0].title in message.stdout
    assert cheap[1].title not in message.stdout
    assert message.stderr == "poinsot: interrupted. 1 of 2 cases were compared.\n"


def test_paper_keeps_the_cases_that_are_done(interrupting, monkeypatch, tmp_path):
    monkeypatch.setattr(paper, "PROBLEMS", paper.PROBLEMS[-2:])
    interrupting(paper, "solve", 2)
    invoked("paper", "--out", tmp_path)
    done = paper.PROBLEMS[0].name
    assert {path.name for path in tmp_path.iterdir()} == {f"{done}.png", f"{done}.pdf", f"{done}.nc", "table.md"}
    assert pt.load(tmp_path / f"{done}.nc").times.size == 2001


# ------------------------------------------------------------------ terminals and pipes


SLOW = """
import threading
from poinsot.integration import run
from poinsot.display import progress
progress.PATIENCE = 0.05
for owner, name in ((run.Slab, "advance"),):
    def slow(*arguments, right=getattr(owner, name)):
        for thread in threading.enumerate():
            if isinstance(thread, threading.Timer):
                thread.join()  # it begins the display
        return right(*arguments)
    setattr(owner, name, slow)
from poinsot.cli import app
app()
"""


def test_long_run_shows_itself_on_a_terminal(result):
    scenario = result.with_name("top.toml")
    scenario.write_text(TOP + "times = {stop = 10, count = 11}\n")
    written, code = forked.on_terminal(SLOW, "run", scenario, "--overwrite")
    assert code == 0
    assert "time" in written
    assert "\x1b[?25h" in written  # the cursor is back
    assert str(result) in screen(written)
    piped = forked.run(SLOW, "run", scenario, "--overwrite")
    assert (piped.stdout, piped.stderr) == (f"{result}\n", "")


def test_ensemble_has_one_bar(tmp_path):
    (tmp_path / "tops.toml").write_text(TOP + "times = {stop = 10, count = 11}\n" + ENSEMBLE)
    written, code = forked.on_terminal(SLOW, "run", tmp_path / "tops.toml")
    assert code == 0
    assert "40/40" in written
    assert "time" not in written


def test_short_things_show_nothing_else(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with terminal.busy("short"):
        time.sleep(0.01)
    assert capsys.readouterr().err == ""


def test_without_colour_and_on_narrow_terminals(monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    code = "from poinsot.cli import app; app()"
    written, status = forked.on_terminal(code, "plot", "--help", columns="50")
    assert status == 0
    assert not re.search(r"\x1b\[[0-9;]*3[0-7]m", written)
    lines = re.sub(r"\x1b\[[0-9;]*m", "", written).splitlines()
    assert max(map(len, lines)) <= 50


def test_output_that_cannot_be_written_is_a_sentence():
    code = "from poinsot.cli import app; app()"
    for arguments in (["--help"], ["new", "--schema"]):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-c", code, *arguments], stdout=full, stderr=subprocess.PIPE, text=True
            )
        assert done.returncode == 2
        assert done.stderr.startswith(
            "poinsot: the output must be a file that can be used, but the operating system reported: No"
        )
        assert done.stderr.count("\n") == 1


CLOSED = {
    "run >&-": (0, "", ""),
    "run 2>&-": (0, "top.nc\n", ""),
    "run >&- 2>&-": (0, "", ""),
    "info >&-": (
        2,
        "",
        "poinsot: the standard output must be a file that can be used, but the operating system "
        "reported: Bad file descriptor.\n",
    ),
    "info >&- 2>&-": (2, "", ""),
    "missing 2>&-": (2, "", ""),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_streams_lose_messages_and_no_result(name, tmp_path):
    command, _, closed = name.partition(" ")
    (tmp_path / "top.toml").write_text(EXACT)
    arguments = {"run": "run top.toml", "info": "info top.toml", "missing": "info missing.nc"}[command]
    program = f"{shlex.quote(sys.executable)} -c 'from poinsot.cli import app; app()' {arguments} {closed}"
    done = subprocess.run(["/bin/sh", "-c", program], capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == CLOSED[name]
    assert (tmp_path / "top.nc").exists() == (command == "run")


def test_a_reader_that_has_read_enough_is_no_error(tmp_path):
    program = f"{shlex.quote(sys.executable)} -c 'from poinsot.cli import app; app()' --help"
    command = f"{{ {program}; echo $? >status; }} | head -1"
    done = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True, cwd=tmp_path)
    assert (done.stderr, (tmp_path / "status").read_text()) == ("", "0\n")


def screen(written):
    """The lines that a terminal shows in the end: what was erased or written over is not there."""
    lines, row, column = [""], 0, 0
    for part in re.findall(r"\x1b\[[?0-9;]*[A-Za-z]|[\r\n]|[^\x1b\r\n]+", written):
        if part.endswith("A") and part.startswith("\x1b"):
            row -= int(part[2:-1] or 1)
        elif part == "\x1b[2K":
            lines[row] = ""
        elif part == "\r":
            column = 0
        elif part == "\n":
            row += 1
            lines += [""] * (row == len(lines))
        elif not part.startswith("\x1b"):
            lines[row] = lines[row].ljust(column)[:column] + part + lines[row][column + len(part) :]
            column += len(part)
    return [line.rstrip() for line in lines]


INTERRUPTED_WHILE = """
import os, signal, time
from poinsot.display import progress
progress.PATIENCE = {patience}
from poinsot.files import netcdf
right = netcdf.{function}
def slow(*arguments, **options):
    time.sleep(0.25)
    os.write(2, b"^C")
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.25)
    return right(*arguments, **options)
netcdf.{function} = slow
from poinsot.cli import app
app()
"""


@pytest.mark.parametrize("patience", [0.01, 10])
def test_messages_stand_on_lines_of_their_own(result, patience):
    """Next to a spinner, and next to the ^C of the terminal."""
    code = INTERRUPTED_WHILE.format(patience=patience, function="save")
    written, status = forked.on_terminal(code, "run", result.with_name("top.toml"), "--overwrite")
    assert status == 130
    lines = [line for line in screen(written) if line]
    first = "Writing the computed results first. Press Ctrl-C again to discard them."
    assert [line for line in lines if "Ctrl-C" in line] == [first]
    assert lines[-1] == "poinsot: interrupted. Only the files named above were written."
    assert "^C" not in "".join(lines)
    reading = INTERRUPTED_WHILE.format(patience=patience, function="load")
    written, status = forked.on_terminal(reading, "info", result)
    assert status == 130
    assert [line for line in screen(written) if line] == [lines[-1]]


def test_words_are_whole_on_a_terminal(result):
    body, start = pt.load(result).system.body, pt.load(result).initial
    circle = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.3)
    system = pt.System(body, pt.GravityGradient(circle), units={"time": "s", "inertia": "kg m2"})
    path = pt.save(pt.propagate(system, start, [0, 1]), result.with_name("satellite.nc"))
    piped = forked.run(MAIN, "info", path).stdout
    assert max(map(len, piped.splitlines())) > 90
    assert "moments=[1.25, 1.0, 0.75] kg m2" in piped
    assert "inclination=0.3 rad" in piped
    assert "epoch=0.0 s" in piped
    written, _ = forked.on_terminal(MAIN, "info", path)
    lines = screen(written)
    assert max(map(len, lines[: lines.index("Next:")])) <= 80
    assert "\n".join(lines[: lines.index("Next:")]).split() == piped.split()


USED = {
    "new": "new it.toml",
    "run": "run it.toml",
    "info": "info it.nc",
    "plot": "plot it.nc",
    "view": "view it.nc",
    "animate": "animate it.nc --seconds 0.1 --time 0:3000",
    "convert": "convert it.nc it.csv",
    "observe": "observe seen.toml",
    "verify": "verify",
    "paper": "paper",
}
SEEN = """
title = "A gyro"
body = {moments = [1.25, 1, 0.75]}
state = {quaternion = [1, 0, 0, 0], omega_body = [0.1, 1, 0.2]}
times = {stop = 10, count = 11}
[[observe]]
type = "Gyro"
"""
FEW = """
from poinsot.validation import cases, paper
from poinsot.display import progress
progress.PATIENCE = 1e9
cases.CASES = [case for case in cases.CASES if case.title == "4179 Toutatis"]
paper.PROBLEMS = paper.PROBLEMS[:1]
from poinsot.cli import app
import sys
for call in sys.argv[1:]:
    try: app(call.split())
    except SystemExit as ended: assert not ended.code, call
    sys.stdout.flush()
    sys.stderr.write("\\n====\\n")
"""


def test_every_command_says_what_to_do_next(tmp_path, monkeypatch):
    """On a terminal; what it names are commands that there are. The commands themselves run in their order."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seen.toml").write_text(SEEN)
    assert USED.keys() == {command.callback.__name__ for command in app.registered_commands}
    written, status = forked.on_terminal(FEW, *USED.values(), columns="200")
    assert status == 0, written
    message = "\n".join(screen(written)).split("\n====\n")[:-1]
    assert len(message) == len(USED)
    for call, text in zip(USED.values(), message, strict=True):
        _, _, steps = text.rpartition("Next:\n")
        assert steps.strip(), call
        for step in steps.strip().splitlines():
            command, what = step.strip().split("  # ")
            assert what.strip()
            assert (
                command.split()[1] in USED
                if command.startswith("poinsot ")
                else "it.html" in command or call == "paper"
            )


@pytest.mark.parametrize("command", ["", *USED])
def test_wrong_command_lines_are_sentences(command):
    """In the words that a terminal shows, without a frame."""
    wrong = ["--overwrit", "--nothing"] if command else ["nothing", "--nothing"]
    for more in wrong:
        message = invoked(*command.split(), more, code=2).stderr
        assert re.fullmatch(r"poinsot: No such .*--help` lists the commands and options\.\n", message), message
    if command in ("run", "info", "plot", "view", "animate", "convert"):
        assert invoked(command, code=2).stderr.startswith("poinsot: Missing argument '")
    if command:
        assert invoked(command, *"abc", *"def", code=2).stderr.startswith("poinsot: Got unexpected extra argument")


@pytest.mark.parametrize("command", ["", *USED])
def test_help_names_no_type_of_flags(command):
    output_text = invoked(*command.split(), "--help", code=0).stdout
    assert "<bool>" not in output_text
    assert "BOOL" not in output_text


def completed(*words):
    """What a shell gets for a command line that is not finished."""
    given = {"_POINSOT_COMPLETE": "complete_bash", "COMP_WORDS": " ".join(["poinsot", *words])}
    given["COMP_CWORD"] = str(len(words))
    code = f"import os; os.environ |= {given}\nfrom poinsot.cli import app; app(prog_name='poinsot')"
    return forked.run(code).stdout.split()


def test_shells_complete_commands_options_and_words():
    assert completed("v") == ["view", "verify"]
    assert set(completed("run", "--o")) == {"--out", "--overwrite"}
    assert set(completed("plot", "a.nc", "--kind", "po")) == {"polhode", "poinsot_construction"}
    assert completed("plot", "a.nc", "--body", "s") == ["secondary"]
    assert set(completed("plot", "a.nc", "--angle-unit", "arc")) == {"arcmin", "arcsec"}
    script = forked.run("from poinsot.cli import app; app(prog_name='poinsot')", "--show-completion", "bash").stdout
    assert script.rstrip().endswith("complete -o default -F _poinsot_completion poinsot")


# ------------------------------------------------------------------ what files say


HOSTILE = (
    "\x1b[31mRED\x1b]0;owned\x07\x9b2J\x08\r\u202egpj.\u2066\u2028\u200b [red]rich[/red] [link=http://x]x[/link] {0}"
)
"""C0 and C1 controls, marks that turn the writing, ends of lines, and markup."""

MAIN = "from poinsot.cli import app; app()"


def hostile_files(folder):
    """A scenario, a result and files of others that have it wherever they have text."""
    text, top = json.dumps(HOSTILE), TOP.partition("\n")[2]
    scenario = folder / "it.toml"
    units = f"units = {{time = {text}, inertia = {text}}}\ntimes = {{stop = 1, count = 3}}\n"
    scenario.write_text(f"title = {text}\n{top}{units}")
    motion = pt.files.read_scenario(scenario).propagate(progress=False)
    motion._complete(run=dataclasses.replace(motion.run, versions={"llvmlite": HOSTILE, "poinsot": HOSTILE}))
    pt.save(motion, folder / "it.nc")
    pt.save(motion, folder / "it.zarr")
    (folder / "key.toml").write_text(f"{text} = 1\n")
    (folder / "value.toml").write_text(f"[body]\ntype = {text}\n")
    (folder / "it.aem").write_text(f"CCSDS_AEM_VERS = {HOSTILE}\nMETA_START\n")
    (folder / "it.oem").write_text(f"CCSDS_OEM_VERS = 2.0\nMETA_START\nOBJECT_NAME = {HOSTILE}\n")
    (folder / "it.csv").write_text(f"# order: {HOSTILE}\n")
    (folder / "it.gfc").write_text(f"begin_of_head\nradius {HOSTILE}\nmax_degree 2\nend_of_head\n")
    (folder / "it.obj").write_text(f"v {HOSTILE}\n")
    (folder / f"{HOSTILE.replace('/', '')}.nc").write_text("")
    (folder / f"{HOSTILE.replace('/', '')}.toml").write_text(TOP)
    return sorted(folder.iterdir())


def obeyed(written):
    """What a terminal would obey or hide in what was written, but for the ends of its lines."""
    return sorted({letter for letter in written.replace("\r\n", "").replace("\n", "") if not letter.isprintable()})


def test_nothing_in_a_file_is_obeyed_by_a_terminal(tmp_path):
    """The commands that read files, each on all of them, on a terminal that is there."""
    paths = hostile_files(tmp_path)
    code = (
        "import sys\nfrom poinsot.cli import app\nfrom poinsot.display import progress\nprogress.PATIENCE = 1e9\n"
        + (
            "for command in ('info', 'info --scenario', 'run --overwrite', 'plot', 'convert'):\n"
            "    for path in sys.argv[2:]:\n"
            "        more = [sys.argv[1]] if command == 'convert' else []\n"
            "        try: app([*command.split(), path, *more])\n"
            "        except SystemExit: pass\n"
        )
    )
    written, status = forked.on_terminal(code, tmp_path / "out.aem", *paths)
    assert status == 0
    assert "RED" in written
    assert "[link=http://x]x[/link]" in written
    assert written.count("can be run again") == 2
    assert obeyed(re.sub(r"\x1b\[\??[0-9;]*[a-z]", "", re.sub(r"\r|\x1b\[[0-9;]*[AK]", "", written))) == []
    assert "\x1b[31mRED" not in written


def test_what_a_repeated_result_says_is_not_obeyed(tmp_path, capsys):
    from poinsot.cli.runs import _compared

    motion = pt.load(hostile_files(tmp_path)[0].parent / "it.nc")
    now = pt.free_motion(motion.system.body, motion.initial, motion.times)
    same, compared = _compared(motion, now)
    assert not same
    terminal.answer(*compared)
    output_text = capsys.readouterr().out
    assert "RED" in output_text
    assert obeyed(output_text) == []


def test_scenarios_are_handed_over_as_they_are(tmp_path):
    paths = hostile_files(tmp_path)
    done = forked.run(MAIN, "info", "--scenario", tmp_path / "it.nc")
    assert done.stdout == (tmp_path / "it.toml").read_bytes().decode()
    assert paths


def test_only_the_terminal_writes():
    """The law: what commands write goes through the functions that escape it, or is a table of the package's own."""
    folder = Path(terminal.__file__).parent
    for path in folder.glob("*.py"):
        calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
        writers = {func.attr for func in calls if isinstance(func, ast.Attribute)} & {"echo", "secho", "print"}
        writers |= {func.id for func in calls if isinstance(func, ast.Name)} & {"print"}
        assert writers <= {"terminal.py": {"echo", "print"}, "checks.py": {"print"}}.get(path.name, set()), path.name


def test_hints_name_options_alone():
    """What is no option stays as it is: a scale that another class has."""
    message = ValueError("axes must agree, got Thin(scale='low') and Thin(motion='high'). Give reference_frame='ICRF'.")
    assert terminal._sentence(message) == (
        "axes must agree, got Thin(scale='low') and Thin(motion='high'). Give --frame ICRF."
    )


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        (["simulate", "a.toml"], "No such command 'simulate'. Write `poinsot run FILE`."),
        (["version"], "No such command 'version'. Write `poinsot --version`."),
        (["view", "a.nc", "--out", "b.html"], "No such option: --out. The file to write is the argument after FILE."),
        (["info", "a.nc", "-o", "b.html"], "No such option: -o."),
        (["--import"], "Option '--import' requires an argument."),
    ],
)
def test_first_guesses_are_answered(arguments, answer):
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith(f"poinsot: {answer} `")
