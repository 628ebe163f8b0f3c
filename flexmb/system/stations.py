"""Joints on stations: markers that a reduction gives no shapes of their own."""

from __future__ import annotations

from flexmb.told import tell

__all__ = ["warn_of_stations"]

LISTED = 6


def warn_of_stations(model) -> None:
    """Warn of joints on stations of reduced bodies: under their forces the body deforms by its retained modes alone."""
    observing = {f"{body.name}.{name}" for body in model.bodies for name in body.stations}
    if not observing:
        return
    held: dict[str, list[str]] = {}
    for joint in model.joints:
        for place in joint.resolved_markers(model):
            if place in observing:
                held.setdefault(place, []).append(f"'{joint.name}'")
    if not held:
        return
    listed = [f"{', '.join(dict.fromkeys(joints))} on '{place}'" for place, joints in list(held.items())[:LISTED]]
    more = f" and {len(held) - LISTED} more" if len(held) > LISTED else ""
    tell(
        f"Model '{model.name}': joints are mounted on stations, which have no shapes of their own: "
        f"{'; '.join(listed)}{more}. There the body is stiffer than its mesh, and reactions along what its modes do "
        "not bend are arbitrary; expected: joints on interfaces. Make the station an interface of the reduction"
    )
