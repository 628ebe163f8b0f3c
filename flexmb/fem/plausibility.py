"""Units that cannot be meant: parts larger than a bridge, materials through which no sound travels like that."""

from __future__ import annotations

import warnings

import numpy as np

from flexmb.fem.mesh import MeshWarning

__all__ = ["WAVE_SPEED", "warn_about_material", "warn_about_size"]

SIZE = (1e-3, 150.0)
"""Diagonal, m, outside of which the unit of length is doubted."""

WAVE_SPEED = (30.0, 30e3)
"""m/s; rubber 50, lead 1200, steel 5100, diamond 18 000 (sqrt(E / rho))."""


def warn_about_size(
    part: str, nodes: np.ndarray, remedy: str = "read_mesh(..., scale=1e-3) or flexmb reduce --scale 1e-3"
) -> None:
    """Warn of an implausible size of nodes (n, 3), m: the mesh is in millimetres, most likely."""
    diagonal = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    if not SIZE[0] <= diagonal <= SIZE[1]:
        warnings.warn(
            f"{part}: the diagonal is {diagonal:.6g} m; coordinates must be metres. "
            f"For a model in millimetres use {remedy}",
            MeshWarning,
            stacklevel=4,
        )


def warn_about_material(part: str, young: float, density: float) -> None:
    """Warn of a modulus (Pa) and a density (kg/m3) whose speed of sound sqrt(E / rho) no solid has."""
    speed = float(np.sqrt(young / density))
    if not WAVE_SPEED[0] < speed < WAVE_SPEED[1]:
        warnings.warn(
            f"{part}: {young:.4g} Pa and {density:.4g} kg/m3 give a speed of sound of {speed:.2g} m/s; solids have "
            f"{WAVE_SPEED[0]:g} to {WAVE_SPEED[1]:g}. Units: 1 MPa = 1e6 Pa, 1 t/mm3 = 1e12 kg/m3",
            MeshWarning,
            stacklevel=4,
        )
