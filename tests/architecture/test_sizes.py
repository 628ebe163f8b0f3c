"""Files and functions stay readable, names say what a thing is, nothing is left half done."""

import re

from architecture.sources import FILES, for_each, name, source

FILE_LINES = 440
FUNCTION_LINES = 90
STATEMENT_LINES = 75
"""Without the docstring."""
EMPTY_NAMES = {"util", "utils", "helper", "helpers", "manager", "base", "misc", "core", "common", "tools"}
UNFINISHED = re.compile(r"NotImplementedError|\b(?:TO" r"DO|FIX" r"ME|X" r"XX|HA" r"CK)\b")


@for_each(FILES)
def test_a_file_is_one_thing(path):
    lines = len(path.read_text(encoding="utf-8").splitlines())
    assert lines <= FILE_LINES, f"{name(path)} has {lines} lines: it is probably two things"


@for_each(FILES)
def test_a_function_fits_on_a_screen(path):
    long = [
        f"{name(path)}:{first} {function} has {last - first + 1} lines, {told} of them docstring"
        for function, first, last, told in source(path).functions
        if last - first + 1 > FUNCTION_LINES or last - first + 1 - told > STATEMENT_LINES
    ]
    assert not long, "\n".join(long)


@for_each(FILES)
def test_nothing_is_left_half_done(path):
    text = path.read_text(encoding="utf-8")
    found = [
        f"{name(path)}:{number} {line.strip()}"
        for number, line in enumerate(text.splitlines(), 1)
        if UNFINISHED.search(line)
    ]
    assert not found, "\n".join(found)


@for_each(FILES)
def test_names_say_what_a_thing_is(path):
    words = set(path.stem.strip("_").split("_"))
    assert not words & EMPTY_NAMES, f"{name(path)}: what is it about?"


@for_each(FILES)
def test_a_module_says_what_it_is(path):
    assert len(source(path).docstring.split()) >= 3, f"{name(path)} has no docstring that says what it holds"
