"""Notes of a model file: what its author tells whoever uses it, ``[[note]]``."""

from __future__ import annotations

from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.told import tell

__all__ = ["tell_note"]


def tell_note(raw: dict[str, Any], where: str) -> None:
    """Give the text of a note as a warning: a restriction that holds with these parameters.

    Raises
    ------
    ModelError
        There is no text, or another field.
    """
    text = raw.get("text")
    if not isinstance(text, str) or not text.strip():
        raise ModelError(
            where,
            found=f"text = {text!r}" if "text" in raw else "the field 'text' is missing",
            expected="a sentence",
            remedy='Write [[note]], if = "= rigid", text = "Rigid parts show 7 % less in strut 1."',
        )
    for field in raw:
        if field != "text":
            raise ModelError(
                where,
                found=f"there is no field '{field}'",
                expected="Fields: text, if, unless",
                remedy=did_you_mean(field, ("text", "if", "unless")) or "Remove it",
            )
    tell(f"{where.partition(',')[0]}: {text.strip()}")
