"""`SkinSurface`: the skin of a deforming body, which can touch other surfaces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.part import Part
from flexmb.surfaces.patch import Patch
from flexmb.surfaces.surface import Surface

__all__ = ["SkinSurface", "pieces_of"]


@dataclass(frozen=True, eq=False)
class SkinSurface(Part):
    """Let the skin of a reduced body, a cable, beam or plate touch surfaces of other bodies.

    Its points move and turn with the modes or nodes of the body, and the forces on them act on these. It has no
    distance of its own: the other surface must be a `Surface`, whose edges and corners are felt where points of the
    skin are inside it.

    Parameters
    ----------
    name : str
    skin : str
        "body.skin", named in the body's `skins`.
    """

    name: str
    _: KW_ONLY
    skin: str

    family: ClassVar[str] = "Surface"
    spacing: ClassVar[float] = 1.0
    """It is sampled."""

    def body_and_skin(self, model) -> tuple[Any, str]:
        """Return the body, and the name of its skin; ModelError if it has none of this name."""
        body_name, _, name = str(self.skin).partition(".")
        body = model.body(body_name, self.title)
        known = tuple(getattr(body, "skin_patches", ()))
        if name not in known:
            raise ModelError(
                self.title,
                found=f"body '{body_name}' has no skin '{name}'",
                expected=f"One of: {', '.join(known)}" if known else "'body.skin' of a body with skins",
                remedy=did_you_mean(name, known) or f"Write skins={{'{name or 'top'}': fmb.Skin(spacing=0.01)}}",
            )
        return body, name

    def check(self, model) -> None:
        """Raise ModelError if the body has no such skin."""
        self.body_and_skin(model)

    def pieces(self, model) -> tuple[Surface, ...]:
        """Return the surfaces of its patches, each on a marker of its own."""
        body, name = self.body_and_skin(model)
        kept = self.__dict__.get("_pieces")
        if kept is None or kept[0] is not body:
            behind = body.skin_thickness[name]
            made = tuple(
                Surface(
                    f"{self.name}[{k}]",
                    marker=f"{body.name}.{patch.marker}",
                    shape=Patch(patch, behind),
                    spacing=patch.areas.max() ** 0.5,
                )
                for k, patch in enumerate(body.skin_patches[name])
            )
            kept = body, made
            object.__setattr__(self, "_pieces", kept)
        return kept[1]


def pieces_of(model, names: Iterable[str], asker: str) -> list[Surface]:
    """Return the surfaces of these names, skins as their pieces."""
    found: list[Surface] = []
    for name in names:
        surface = model.surface(name, asker)
        found += surface.pieces(model) if isinstance(surface, SkinSurface) else [surface]
    return found
