"""What a model file takes over from other files: a base model (``base``), and shared data (``parameters_from``).

A case is a base and what differs; FE scripts and model files of one machine read one file of data. Both are resolved
here, on the level of TOML tables, so that everything else sees one file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.files import resolved
from flexmb.io import kind_lists
from flexmb.io.limits import CHAIN, named_file
from flexmb.io.toml_text import read_toml

__all__ = ["flat_parameters", "read_tables"]

_LISTS = (*kind_lists.FAMILIES, "assembly", "note")
_MERGED = ("parameters", "signals", "simulation")


def read_tables(path: Path, chain: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Return the tables of a model file, with its base before its own and with the shared parameters it names.

    Parts of the base come first; values of [parameters], [signals] and [simulation] replace the base's.

    Raises
    ------
    ModelError
        A file is missing, bases form a circle, a base lies in another folder, or a table of data does not exist.
    """
    tables = dict(read_toml(path))
    shared = _shared(tables.pop("parameters_from", []), path)
    if shared:
        own = tables.get("parameters", {})
        tables["parameters"] = {**shared, **own} if isinstance(own, dict) else own
    base = tables.pop("base", None)
    if base is None:
        return tables
    return _joined(read_tables(_base_path(base, path, chain), (*chain, resolved(path))), tables)


def _base_path(base: Any, path: Path, chain: tuple[Path, ...]) -> Path:
    where = f"{path.name}, base"
    if not isinstance(base, str) or Path(base).name != base:
        raise ModelError(
            where,
            found=f"base = {base!r:.80}",
            expected="the name of a model file in the same folder",
            remedy='Write base = "wing.toml"; files of the base are relative to its folder',
        )
    found = named_file(path.parent, base, where)
    if len(chain) >= CHAIN:
        raise ModelError(
            where,
            found=f"more than {CHAIN} files that build on each other",
            expected="a few",
            remedy="Put what they change into one file",
        )
    circle = (*chain, resolved(path))
    if resolved(found) in circle:
        raise ModelError(
            where,
            found=f"the files form a circle: {' -> '.join(p.name for p in (*circle, found))}",
            expected="a base that does not build on this file",
            remedy="Name another base",
        )
    return found


def _joined(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a base joined with the tables of the file that builds on it."""
    whole = {**base, **own}
    for name in _LISTS:
        if isinstance(base.get(name), list) and isinstance(own.get(name), list):
            whole[name] = [*base[name], *own[name]]
    for name in _MERGED:
        if isinstance(base.get(name), dict) and isinstance(own.get(name), dict):
            whole[name] = {**base[name], **own[name]}
    return whole


def _shared(entries: Any, path: Path) -> dict[str, Any]:
    """Return the parameters that `parameters_from` names."""
    values: dict[str, Any] = {}
    for entry in entries if isinstance(entries, list) else [entries]:
        given = {"file": entry} if isinstance(entry, str) else entry
        if not isinstance(given, dict) or not isinstance(given.get("file"), str) or not set(given) <= {"file", "table"}:
            raise ModelError(
                f"{path.name}, parameters_from",
                found=repr(entry),
                expected="a file, or a table with file and table",
                remedy='Write parameters_from = [{ file = "data.toml", table = "flap" }]',
            )
        table = read_toml(named_file(path.parent, given["file"], f"{path.name}, parameters_from"))
        for word in [w for w in str(given.get("table", "")).split(".") if w]:
            if not isinstance(table.get(word), dict):
                raise ModelError(
                    f"{path.name}, parameters_from",
                    found=f"{given['file']} has no table '{given['table']}'",
                    expected=f"One of: {', '.join(k for k, v in table.items() if isinstance(v, dict)) or 'none'}",
                    remedy=did_you_mean(word, table) or "Correct the name of the table",
                )
            table = table[word]
        values.update(flat_parameters(table))
    return values


def flat_parameters(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of nested tables by names joined with underscores; lists of tables count from 1.

    Examples
    --------
    >>> flat_parameters({"track": {"y": 3.3, "drive": {"length": 0.9}}, "shaft": [{"d": 0.05}]})
    {'track_y': 3.3, 'track_drive_length': 0.9, 'shaft_1_d': 0.05}
    """
    flat: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
            value = {str(number): entry for number, entry in enumerate(value, 1)}
        if isinstance(value, Mapping):
            flat.update({f"{name}_{inner}": entry for inner, entry in flat_parameters(value).items()})
        else:
            flat[name] = value
    return flat
