"""Models as TOML text and files: every expression evaluated, defaults left out."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError
from flexmb.files import complaints, resolved, write_text
from flexmb.io import kind_lists
from flexmb.io.field_values import own_kind, toml_fields
from flexmb.io.simulation_settings import Simulation
from flexmb.io.toml_text import table_lines
from flexmb.model.block import Block
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.model import Model
from flexmb.model.signal import Signal

__all__ = ["model_text", "save_model"]


def save_model(
    model: Model, path: str | Path, simulation: Simulation | None = None, *, bodies_in: str | None = None
) -> Path:
    """Write a model to a TOML file that `load_model` reads back, and return the path.

    Reduced bodies are written beside it, each once, as "<model>.<name of the data>.h5"; with `bodies_in`, the name of
    a solution file in the same folder that holds them, they are named as "<solution file>#<body>" instead.
    """
    path = Path(path)
    with complaints(f"Model file '{path}'", "write"):
        path.parent.mkdir(parents=True, exist_ok=True)
    if bodies_in is not None:
        names = _first_bodies(model)
        return write_text(path, _text(model, simulation, lambda data: f"{bodies_in}#{names[id(data)]}", path.parent))
    stored: dict[int, str] = {}

    def store(data: ModalNeutralData) -> str:
        if id(data) not in stored:
            safe = "".join(c if c.isalnum() or c in "-_" else "_" for c in data.name) or "body"
            names = (f"{path.stem}.{safe}{end}.h5" for end in ("", *(f"_{n}" for n in range(2, len(stored) + 3))))
            stored[id(data)] = next(name for name in names if name not in stored.values())
            data.save(path.parent / stored[id(data)])
        return stored[id(data)]

    return write_text(path, _text(model, simulation, store, path.parent))


def model_text(model: Model) -> str:
    """Return a model as TOML; reduced bodies are named by the first body that has them (see `read_model_text`)."""
    names = _first_bodies(model)
    return _text(model, None, lambda data: names[id(data)])


def _first_bodies(model: Model) -> dict[int, str]:
    """Return the name of the first body that has them, by the identity of the data."""
    return {id(body.data): body.name for body in reversed(model.bodies) if body.reduced is not None}


def _text(
    model: Model,
    simulation: Simulation | None,
    data_name: Callable[[ModalNeutralData], str],
    folder: Path | None = None,
) -> str:
    """Return the text; files are named relative to the folder that it will be in, absolute if it has none."""
    blocks = _shared_blocks(model)

    def written(value: Any) -> str:
        if isinstance(value, Path):
            return _relative(resolved(value), folder)
        return blocks.get(id(value), ("", value))[0] if isinstance(value, Signal) else data_name(value)

    top: dict[str, Any] = {"name": model.name}
    if any(model.gravity):
        top["gravity"] = list(model.gravity)
    lines = table_lines("", top)
    if model.origin is not None:
        lines += table_lines("[origin]", toml_fields(model.origin, "Orbit", written))
    if model.parameters:
        lines += ["# The values below are evaluated already; these are the parameters they came from."]
        try:
            lines += table_lines("[parameters]", model.parameters)
        except ValueError as error:
            raise ModelError(
                f"Model '{model.name}', parameters",
                found=str(error),
                expected="numbers, texts and lists of them",
                remedy="Keep other objects out of the parameters: no file can hold them",
            ) from None
    if blocks:
        named = {text[2:]: {b.word: toml_fields(b, b.title, written)} for text, b in blocks.values()}
        lines += table_lines("[signals]", named)
    for table, family in kind_lists.FAMILIES.items():
        for part in getattr(model, family):
            entries = toml_fields(part, part.title, written)
            entries.pop("name", None)
            kind = type(part).__name__
            if own_kind(type(part)) and "kind" in entries:
                kind += f".{entries.pop('kind')}"
            lines += table_lines(f"[[{table}]]", {"kind": kind, "name": part.name, **entries})
    if simulation is not None:
        lines += table_lines("[simulation]", toml_fields(simulation, "Simulation", written))
    return "\n".join(lines)


def _relative(file: Path, folder: Path | None) -> str:
    """Return how a file is named in a folder; on another drive it has no relative name."""
    if folder is None or file.drive != resolved(folder).drive:
        return file.as_posix()
    return Path(os.path.relpath(file, resolved(folder))).as_posix()


def _shared_blocks(model: Model) -> dict[int, tuple[str, Block]]:
    """Return by identity what is written for each block that is used more than once, "= name", and the block.

    Written out at each of its uses, it would be read as several, each with states of its own. A block comes behind
    those that it follows.
    """
    found: dict[int, Block] = {}
    again = set()

    def visit(value: Any) -> None:
        if isinstance(value, Block) and id(value) in found:
            again.add(id(value))
            return
        for inner in _inner(value):
            visit(inner)
        if isinstance(value, Block):
            found[id(value)] = value

    for family in kind_lists.FAMILIES.values():
        visit(getattr(model, family))
    names: dict[int, tuple[str, Block]] = {}
    taken = {*model.parameters, "t"}
    for key, block in found.items():
        if key in again:
            plain = "".join(c if c.isalnum() else "_" for c in block.name or block.word)
            plain = plain if plain.isidentifier() else f"block_{plain}"
            name = next(n for n in (plain, *(f"{plain}_{k}" for k in range(2, len(found) + 9))) if n not in taken)
            taken.add(name)
            names[key] = (f"= {name}", block)
    return names


def _inner(value: Any) -> Iterator[Any]:
    """Yield what a value of a field is made of."""
    if isinstance(value, Mapping):
        yield from value.values()
    elif isinstance(value, list | tuple):
        yield from value
    elif is_dataclass(value) and not isinstance(value, type | ModalNeutralData):
        yield from (getattr(value, f.name) for f in fields(value) if f.init)
