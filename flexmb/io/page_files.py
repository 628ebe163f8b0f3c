"""A web page and its numbers, side by side."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flexmb.errors import DataFileError

__all__ = ["write_page"]


def write_page(path, page: Callable[[], str], numbers: Callable[[], Any]) -> tuple[Path, Path]:
    """Write ``x.html`` and ``x.json`` for any ``x.*``, and return their paths.

    Raises
    ------
    DataFileError
        They cannot be written.
    """
    web, table = Path(path).with_suffix(".html"), Path(path).with_suffix(".json")
    try:
        web.parent.mkdir(parents=True, exist_ok=True)
        web.write_text(page(), encoding="utf-8", errors="replace")
        table.write_text(json.dumps(numbers(), indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise DataFileError(
            f"Report '{web}'",
            found=f"cannot write it ({error})",
            expected="a writable folder with free space",
            remedy="Free space, or choose another folder",
        ) from error
    return web, table
