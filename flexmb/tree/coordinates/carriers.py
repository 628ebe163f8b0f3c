"""The joints whose relative coordinates may carry bodies in a tree, and those that a user wants there."""

from __future__ import annotations

from flexmb.errors import CompileError, did_you_mean
from flexmb.system.system import System

__all__ = ["carriers"]


def carriers(system: System, plain: dict[str, bool], keep: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the joints that may carry bodies, and those that must."""
    for name in keep:
        if name not in plain:
            raise CompileError(
                "JointTree",
                found=f"joint '{name}' to keep does not exist",
                expected=f"one of: {', '.join(plain)}",
                remedy=did_you_mean(name, plain),
            )
        if not plain[name]:
            kind = type(system.joints[system.joint_index[name]]).__name__
            raise CompileError(
                f"Joint '{name}'",
                found=f"{kind} permits no turns or slides that could carry a body",
                expected="a joint with relative coordinates in the tree",
                remedy=f"Leave '{name}' out of keep: it closes a loop by its equations",
            )
    return tuple(name for name, good in plain.items() if good), keep
