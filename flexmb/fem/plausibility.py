"""Units that cannot be meant, of meshes: parts larger than a bridge, heavier than a house, of no known material."""

from __future__ import annotations

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.told import tell
from flexmb.model.plausibility import WAVE_SPEED, material_doubts, size_doubts

__all__ = ["WAVE_SPEED", "require_material", "warn_about_material", "warn_about_size"]

SCALE = (
    "read_mesh(..., scale=1e-3) or flexmb reduce --scale 1e-3; in a model file scale = 1e-3 of a MeshFile, and lengths "
    "in metres of all other pieces"
)


def require_material(part: str, material, call: str) -> None:
    """Raise MeshError where no material is given; `call` shows how to give it."""
    if material is None:
        raise MeshError(
            part,
            found="no material",
            expected="one: a mesh has places only",
            remedy=f"Write {call.format('fmb.Material(young=210e9, poisson=0.3, density=7850.0)')} for steel",
        )


def warn_about_size(part: str, nodes: np.ndarray, remedy: str = SCALE, mass: float | None = None) -> None:
    """Warn of an implausible size of nodes (n, 3), m, or mass, kg: the mesh is in millimetres, most likely."""
    for text in size_doubts(float(np.linalg.norm(np.ptp(nodes, axis=0))), mass, remedy):
        tell(f"{part}: {text}")


def warn_about_material(part: str, young: float, density: float) -> None:
    """Warn of a modulus (Pa) and a density (kg/m3) that no solid has."""
    for text in material_doubts(young, density):
        tell(f"{part}: {text}")
