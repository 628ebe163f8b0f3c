"""Materials of parts: objects, or names of the ready-made ones."""

from __future__ import annotations

from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.material import MATERIALS, Material
from flexmb.model.orthotropic_material import OrthotropicMaterial

__all__ = ["material_of"]


def material_of(value: Any, title: str, *, orthotropic: bool = False) -> Any:
    """Return the material that is given or named; ModelError for anything else."""
    if isinstance(value, Material) or (orthotropic and isinstance(value, OrthotropicMaterial)):
        return value
    if isinstance(value, str) and value in MATERIALS:
        return MATERIALS[value]
    near = did_you_mean(value, MATERIALS) if isinstance(value, str) else ""
    raise ModelError(
        f"{title}, material",
        found=f"{value!r:.80}",
        expected=f"one of {', '.join(MATERIALS)}, or a material with its numbers",
        remedy=near or 'Write material = { kind = "Material", young = 210e9, poisson = 0.3, density = 7850 }',
    )
