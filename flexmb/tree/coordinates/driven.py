"""Which coordinates of a tree drives prescribe, and to what."""

from __future__ import annotations

from typing import Any

__all__ = ["driven_coordinates"]


def driven_coordinates(system, tree, rows, names) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the drives of tree joints by the names of their coordinates, and the signals that these follow.

    A screw has one coordinate, its turn, also where its slide is driven.

    Parameters
    ----------
    tree : Spanning
    rows : (nb,) MOTION
        Of its bodies.
    names : names of all coordinates
    """
    carried = {tree.joints[body]: row for body, row in zip(tree.order, rows, strict=True) if body in tree.joints}
    drives, signals = {}, {}
    for drive in system.joints:
        if not drive.prescribes or drive.joint not in carried:
            continue
        name = f"{drive.joint}.{drive.freedom or ('slide' if drive.angle is None else 'turn')}"
        signal = drive.displacement if drive.angle is None else drive.angle
        if name not in names:
            row, name = carried[drive.joint], f"{drive.joint}.turn"
            signal = (signal - float(row["d"][2])) * (1.0 / float(row["advance"]))
        drives[name], signals[name] = drive, signal
    return drives, signals
