"""Remedies in the words of the command line and of model files, where messages give those of Python.

The same message serves a program and a terminal. What one writes in Python is of no use at the other.
"""

from __future__ import annotations

import re

__all__ = ["in_files_and_options"]

AT_REST = 'start = "equilibrium" in the table [simulation]'
CALL = re.compile(r"(?<![\w.])(?:fmb|flexmb)\.([A-Za-z_]\w*)\(")
SIGNALS = ("ramp", "step", "harmonic", "table", "expression", "constant")
"""Signals whose name is a key of model files; what begins with a capital is a kind."""

_STATICS = r"(?:fmb|flexmb)\.statics\(model\)"
FOUND_ALREADY = (
    (
        rf"Begin at one: about={_STATICS}",
        "It is the equilibrium that was found: look at what moves or slides there, drives, contacts and friction",
    ),
    (rf", or start from {_STATICS}", ""),
    (rf"start from {_STATICS}, and compare", "compare"),
    (rf"Give the result of {_STATICS}, or leave", "Leave"),
)
"""Remedies of a state that is no equilibrium, and what they are where the equilibrium was asked for."""


def in_files_and_options(text: str, statics: bool = False, at_rest: bool = False) -> str:
    """Return a message with its remedies for users of the command line.

    Parameters
    ----------
    text : str
    statics : bool
        Does the verb have ``--statics``?
    at_rest : bool
        Did it begin in the equilibrium that statics found? Then this is no remedy.
    """
    if at_rest:
        for said, meant in FOUND_ALREADY:
            text = re.sub(said, meant, text)
    rest = f"--statics, or {AT_REST}" if statics else AT_REST
    for said, meant in (
        (r"start from (?:fmb|flexmb)\.statics\(model\)", f"begin in the equilibrium ({rest})"),
        (r"(?:about=)?(?:fmb|flexmb)\.statics\(model\)", rest),
        (r"the result of " + re.escape(rest), rest),
        (r"\(state=, or other places in the model\)", "(other places in the model)"),
        (r"(?:fmb|flexmb)\.check\(model\)", "`flexmb check`"),
        (r"geometric_stiffness=True \(--geometric-stiffness; (of a part [^)]*)\)", r"--geometric-stiffness, \1"),
        (
            r"reduction\.reduce\(\.\.\., modes=\.\.\.\)",
            "flexmb reduce ... --modes, of a part modes = ...",
        ),
        (r"reduction\.reduce\(\.\.\., loads=\{\.\.\.\}\)", "flexmb reduce ... --load"),
        (r"path=flexmb\.ArcLength\(\)", "statics(model, path=ArcLength()) of the Python package"),
        (r"fem\.read_deck\(\.\.\., lumped=False\), (--consistent-mass)", r"\1"),
    ):
        text = re.sub(said, meant, text)
    return _calls(text)


def _calls(text: str) -> str:
    """Return a text with descriptions of kinds and signals as tables of a model file."""
    out, at = "", 0
    while (found := CALL.search(text, at)) is not None:
        end = _closing(text, found.end())
        name = found.group(1)
        table = None if end < 0 or not (name in SIGNALS or name[0].isupper()) else _table(name, text[found.end() : end])
        out += text[at : found.start()] + (table or text[found.start() : found.end()])
        at = end + 1 if table else found.end()
    return out + text[at:]


def _closing(text: str, at: int) -> int:
    """Return where the bracket closes that was opened before; -1 if it does not."""
    depth = 1
    for k in range(at, len(text)):
        depth += (text[k] in "([{") - (text[k] in ")]}")
        if not depth:
            return k
    return -1


def _table(name: str, inner: str) -> str | None:
    """Return a call with named values as a table; None for one with other values."""
    fields = []
    for part in _split(inner):
        field, equals, value = part.partition("=")
        if part != "..." and not (equals and field.strip().isidentifier()):
            return None
        fields.append(part if part == "..." else f"{field.strip()} = {_value(_calls(value.strip()))}")
    words = ", ".join(fields)
    if name in SIGNALS:
        return f"{{ {name} = {{ {words} }} }}"
    return f'{{ kind = "{name}", {words} }}' if words else f'{{ kind = "{name}" }}'


def _split(inner: str) -> list[str]:
    """Return the values between the commas of the outermost level."""
    parts, depth, begin = [], 0, 0
    for k, letter in enumerate(inner):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and not depth:
            parts.append(inner[begin:k].strip())
            begin = k + 1
    return [part for part in (*parts, inner[begin:].strip()) if part]


def _value(text: str) -> str:
    """Return a value as model files have it: lists in square brackets, texts in double quotes."""
    return {"True": "true", "False": "false"}.get(text, re.sub(r"\(([^()]*)\)", r"[\1]", text).replace("'", '"'))
