"""The command itself: verbs, help, version, exit codes."""

import os
import re
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest

from flexmb.cli import command_line, main
from flexmb.cli.progress import ProgressBar
from flexmb.errors import caused_by_interrupt


@pytest.mark.parametrize("verb", command_line.VERBS, ids=lambda verb: verb.NAME)
def test_every_verb_says_what_it_does(verb, capsys):
    with pytest.raises(SystemExit) as ended:
        main([verb.NAME, "--help"])
    assert ended.value.code == 0
    assert f"usage: flexmb {verb.NAME}" in capsys.readouterr().out
    assert verb.SUMMARY
    assert verb.__doc__


def test_overview(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    printed = capsys.readouterr().out
    assert all(verb.NAME in printed and verb.SUMMARY in " ".join(printed.split()) for verb in command_line.VERBS)


@pytest.mark.parametrize("arguments", [[], ["rune"], ["run"], ["run", "a.toml", "--what"]])
def test_wrong_usage(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert "usage: flexmb" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("reduce a.msh --mods 5", "flexmb reduce: error: there is no option --mods. Did you mean '--modes'?"),
        ("run a.toml --what", "flexmb run: error: there is no option --what. `flexmb run --help` lists the options."),
        ("run a.toml b.toml", "flexmb run: error: 'b.toml' is one argument too many."),
        ("reduce a.msh --scale mm", "--scale: 'mm' is no number. Expected: metres per unit of the mesh: 0.001 for a"),
        ("run a.toml --t-end 1s", "--t-end: '1s' is no number. Expected: end time; default: as in [simulation]"),
        ("run a.toml --samples 1e3", "--samples: '1e3' is no whole number. Expected: "),
    ],
)
def test_wrong_options_say_what_was_meant(arguments, told, capsys):
    """Of the verb, not of the whole command; a wrong number says what the option is."""
    with pytest.raises(SystemExit) as ended:
        main(arguments.split())
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_version(capsys):
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out.startswith("flexmb")


def test_interruption_has_its_code(monkeypatch, capsys):
    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(command_line.check, "execute", interrupted)
    assert main(["check", "a.toml"]) == 130
    assert capsys.readouterr().err == "flexmb check: interrupted\n"


def test_an_interruption_lost_in_a_first_call_too(monkeypatch, capsys):
    """Python makes a SystemError of Ctrl-C in the first call of a compiled function; another one is no interruption."""

    def lost(arguments):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as struck:
            raise SystemError("returned a result with an exception set") from struck

    def broken(arguments):
        raise SystemError("another")

    monkeypatch.setattr(command_line.check, "execute", lost)
    assert main(["check", "a.toml"]) == 130
    assert capsys.readouterr().err == "flexmb check: interrupted\n"
    monkeypatch.setattr(command_line.check, "execute", broken)
    with pytest.raises(SystemError):
        main(["check", "a.toml"])


def test_warnings_are_sentences(monkeypatch, capsys):
    def warn(arguments):
        for text in ("two cells are distorted", "the joint is open", "two cells are distorted"):
            warnings.warn(text, UserWarning, stacklevel=1)
        return 0

    monkeypatch.setattr(command_line.check, "execute", warn)
    shown = warnings.showwarning
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        main(["check", "a.toml"])
    assert capsys.readouterr().err == "flexmb: warning: two cells are distorted\nflexmb: warning: the joint is open\n"
    assert warnings.showwarning is shown


def test_a_closed_pipe_is_no_error(tmp_path):
    code = (
        "from flexmb.cli import command_line as c\n"
        "def execute(a):\n    for _ in range(100000): print('line')\n    return 0\n"
        "c.check.execute = execute\nimport sys\nsys.exit(c.main(['check', 'x']))"
    )
    process = subprocess.run(
        f'"{sys.executable}" -c "$CODE" | head -1; exit ${{PIPESTATUS[0]}}',
        shell=True,
        text=True,
        executable="/bin/bash",
        capture_output=True,
        check=False,
        env={**os.environ, "CODE": code, "PYTHONPATH": ":".join(sys.path)},
    )
    assert (process.returncode, process.stdout, process.stderr) == (0, "line\n", "")


class Terminal:
    """A stream that is a terminal, or not."""

    def __init__(self, shown=True):
        self.text, self.shown = "", shown

    def isatty(self):
        return self.shown

    def write(self, text):
        self.text += text

    def flush(self):
        pass


def test_progress_on_a_terminal():
    stream = Terminal()
    with ProgressBar(stream) as progress:
        progress("normal modes", 0.5)
        progress("done", 1.0)
    assert "normal modes  [" + 15 * "#" + 15 * "." + "]  50 %" in stream.text
    assert stream.text.split("\r")[-1] == ""
    assert stream.text.split("\r")[-2].strip() == ""


LOADING = """
import sys

class Struck:
    def __set_name__(self, owner, name):
        raise {error}

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "flexmb.cli.command_line":
            type("Loaded", (), {{"struck": Struck()}})

sys.meta_path.insert(0, Finder())
from flexmb.cli import main

sys.exit(main(["check", "any.toml"]))
"""


@pytest.mark.parametrize(("error", "code"), [("KeyboardInterrupt", 130), ("ValueError", 1)])
def test_an_interruption_while_a_class_is_loaded(error, code):
    """Until 3.12, Python makes a RuntimeError of what `__set_name__` raises; an error of another kind is shown."""
    child = subprocess.run(
        [sys.executable, "-c", LOADING.format(error=error)], capture_output=True, text=True, check=False
    )
    assert child.returncode == code, child.stderr
    assert ("Traceback" in child.stderr) == (code == 1)


EARLY = """
import os, signal, sys
sys.argv = ["flexmb", "check", "any.toml"]

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "flexmb.cli.command_line":
            exec("os.kill(os.getpid(), signal.{number})")  # as where a named tuple is being made

sys.meta_path.insert(0, Finder())
from flexmb.cli import main

code = main()
os.kill(os.getpid(), signal.{number})  # once more, when the command is done
sys.exit(code)
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows sends no signals")
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_a_signal_while_the_package_is_loaded_and_another_at_the_end(number, tmp_path):
    """One message and one code from the first moment on: it was -15, and -2 where a named tuple was being made."""
    (tmp_path / "early.py").write_text(EARLY.format(number=number))
    surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    surroundings.pop("PYTHONSAFEPATH", None)  # -m finds the module in the folder it is started from
    child = subprocess.run(
        [sys.executable, "-m", "early"],  # as python -m flexmb
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=surroundings,
    )
    assert child.returncode == 130, child.stderr
    assert child.stderr == "flexmb: interrupted\n"


def test_an_error_while_an_interrupted_run_is_stored_is_no_interruption():
    failed, stopped = RuntimeError("unable to flush the file"), ImportError("partly loaded")
    failed.__context__ = stopped.__cause__ = KeyboardInterrupt()
    assert not caused_by_interrupt(failed)
    assert caused_by_interrupt(stopped)


def test_no_progress_in_a_file():
    stream = Terminal(shown=False)
    with ProgressBar(stream) as progress:
        progress("normal modes", 0.5)
    assert stream.text == ""


def test_an_interruption_that_is_lost_comes_again(monkeypatch, capsys):
    """An exception in a destructor goes nowhere: Ctrl-C that strikes there must end the command all the same."""

    class Falling:
        def __del__(self):
            raise KeyboardInterrupt

    def execute(arguments):
        Falling()
        for _ in range(500):
            time.sleep(0.01)
        return 0

    monkeypatch.setattr(command_line.check, "execute", execute)
    assert main(["check", "any.toml"]) == 130
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [["run", "a.toml", "--out", "x\0y"], ["reduce", "a\0.msh"], ["plot", "runs/a", "F\0", "--out", "p.png"]],
)
def test_a_zero_byte_has_a_name(arguments, capsys):
    """No shell passes one, but a program that calls `main` may; before, a traceback of the file system."""
    assert main(arguments) == 2
    assert re.search(r"Argument '\w+': '.*\\x00.*', with a zero byte\. Expected", capsys.readouterr().err)


def test_names_of_a_file_steer_no_terminal(tmp_path, capsys):
    """Escape sequences of a foreign file reached the terminal, and with them its colours, title and clipboard."""
    path = tmp_path / "m.toml"
    for name in ("a\\u001b]52;c;ZWNobw==\\u0007", "two\\nlines", "a\\u0085b"):
        path.write_text(f'[[body]]\nkind = "PointMass"\nname = "{name}"\nmass = 1.0\n', encoding="utf-8")
        assert main(["check", str(path)]) == 2
        told = capsys.readouterr().err
        assert "none that ends a line or steers a terminal" in told
        assert told.count("\n") == 1
        assert not set(told) & {"\x1b", "\x07", "\x85"}
    turned = 'name = "\u202efdp.exe"\n[[body]]\nkind = "PointMass"\nname = "p"\nmass = 1.0\n\'\x1b[31m\' = 1\n'
    path.write_text(turned, encoding="utf-8")
    assert main(["check", str(path)]) == 2  # TOML has no such key
    assert "\x1b" not in capsys.readouterr().err
    path.write_text(turned[: turned.index("'")], encoding="utf-8")
    assert main(["check", str(path)]) == 0
    assert "Model '\\u202efdp.exe'" in capsys.readouterr().out


def test_names_of_a_million_characters_are_refused(tmp_path, capsys):
    path = tmp_path / "m.toml"
    path.write_text(f'[[body]]\nkind = "PointMass"\nname = "{"x" * 1_000_000}"\nmass = 1.0\n', encoding="utf-8")
    assert main(["check", str(path)]) == 2
    told = capsys.readouterr().err
    assert "at most 1000 characters" in told
    assert len(told) < 3000


def test_an_empty_name_of_a_run_folder_is_refused(tmp_path, capsys, monkeypatch):
    """An empty variable of the shell, --out "$PLACE", wrote into the folder that is usual."""
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text('[[body]]\nkind = "PointMass"\nname = "p"\nmass = 1.0\n', encoding="utf-8")
    assert main(["run", "m.toml", "--t-end", "0.1", "--out", ""]) == 2
    assert "an empty name. Expected: the name of a file or folder to write" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.toml"]


@pytest.mark.skipif(os.name == "nt", reason="a folder in use cannot be removed there")
def test_a_working_folder_that_is_gone_is_named(tmp_path, capsys, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert main(["check", "m.toml"]) == 2
    assert "working folder: it does not exist any more" in capsys.readouterr().err


def test_a_misspelt_verb_is_met_with_the_one_that_is_like_it(capsys):
    with pytest.raises(SystemExit):
        main(["rum", "crane.toml"])
    assert "Did you mean 'run'?" in capsys.readouterr().err
