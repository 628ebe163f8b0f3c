"""The file that is to be reduced: that it cannot be a mesh is said before any option that does not fit it."""

from __future__ import annotations

import os
from pathlib import Path

from flexmb.errors import MeshError
from flexmb.found import no_file_because

__all__ = ["require_mesh"]

OTHER = {".toml": ("a model file", "check"), ".h5": ("a data file", "show")}
"""Files of ours that are not meshes, and the verbs that look at them."""


def require_mesh(path: Path) -> None:
    """Raise MeshError if what is there cannot be a mesh or a deck; that nothing is there, readers say."""
    from flexmb import fem

    if os.path.exists(path) and no_file_because(path, {*fem.DECK_READERS, ".msh"}) is not None:
        (fem.read_deck if path.suffix.lower() in fem.DECK_READERS else fem.read_mesh)(path)  # says what is there
    if path.suffix.lower() in OTHER:
        kind, verb = OTHER[path.suffix.lower()]
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"it is {kind}",
            expected="a mesh or a deck",
            remedy=f"Name what it was made from; what it holds: flexmb {verb} {path}",
        )
