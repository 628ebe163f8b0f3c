"""What a scene of glTF 2.0 asks of its reader: trimesh passes over what it does not know, and zeros come out of it.

Source: Khronos Group, glTF 2.0 Specification (2021): 3.6 buffers and accessors, 3.12 extensions, 4.4 GLB.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

from flexmb.errors import MeshError

__all__ = ["require_plain_scene"]

_HEAD, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_LOOKS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_xmp", "MSFT_texture_")
"""Beginnings of the names of extensions that change how a scene looks, not where its points are."""


def require_plain_scene(part: str, path: Path) -> None:
    """Raise MeshError if points or corners of a scene are compressed, sparse or scaled integers."""
    scene = _scene(path)
    needed = [str(name) for name in scene.get("extensionsRequired", ()) if not str(name).startswith(_LOOKS)]
    if needed:
        raise _refused(part, f"it needs the extensions {', '.join(needed)} of glTF")
    accessors = scene.get("accessors", [])
    for mesh in scene.get("meshes", ()):
        for primitive in mesh["primitives"]:
            for what, number in (
                ("points", primitive["attributes"].get("POSITION")),
                ("corners", primitive.get("indices")),
            ):
                if number is not None:
                    _require_plain(part, what, accessors[number])


def _scene(path: Path) -> dict[str, Any]:
    """Return the text of a scene; ValueError or struct.error if there is none."""
    content = path.read_bytes()
    if content[:4] == b"glTF":
        (length, _), start = _CHUNK.unpack_from(content, _HEAD.size), _HEAD.size + _CHUNK.size
        content = content[start : start + length]
    scene = json.loads(content)
    if not isinstance(scene, dict):
        raise ValueError("the scene is no object")
    return scene


def _require_plain(part: str, what: str, accessor: dict[str, Any]) -> None:
    if "sparse" in accessor:
        raise _refused(part, f"{what} that are stored as changes (sparse)")
    if "bufferView" not in accessor:
        raise _refused(part, f"{what} without numbers")
    if accessor.get("normalized"):
        raise _refused(part, f"{what} as scaled integers (normalized)")


def _refused(part: str, found: str) -> MeshError:
    return MeshError(
        part,
        found=found,
        expected="plain numbers, neither compressed nor quantised",
        remedy="Export without compression (Draco, meshopt, quantisation), or as .stl or .ply",
    )
