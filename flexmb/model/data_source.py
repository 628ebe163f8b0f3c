"""`DataSource`: a description that modal neutral data can be made of, in the place of the data themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

__all__ = ["DataSource", "plain"]


@runtime_checkable
class DataSource(Protocol):
    """What a flexible body may be given instead of its data: it is reduced, or taken from a cache, when it is asked."""

    def reduced(self) -> Any:
        """Return the `ModalNeutralData`."""


def plain(value: Any) -> Any:
    """Return a description as JSON can hold it: objects as tables with their ``kind``, arrays as lists, files by name.

    Equal descriptions give equal results; fields without a value are left out.
    """
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, int | float):
        return value
    if isinstance(value, Path):
        return value.name
    if isinstance(value, Mapping):
        return {str(name): plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if is_dataclass(value) and not isinstance(value, type):
        entries = {f.name: getattr(value, f.name) for f in fields(value)}
        return {"kind": type(value).__name__, **{k: plain(v) for k, v in entries.items() if v is not None}}
    return repr(value)
