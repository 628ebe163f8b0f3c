"""Markers of bushings that turn against each other by half a turn, beyond which their law means nothing."""

from __future__ import annotations

from typing import Any

from flexmb.errors import IntegrationError

__all__ = ["require_unturned"]


def require_unturned(system: Any, variables: Any) -> None:
    """Raise IntegrationError if the markers of a force have turned too far, as the switches of a run tell."""
    switching = getattr(variables, "switching", None)
    turned = 0 if switching is None or not len(switching.now) else int(switching.limits["turned"][0])
    if turned:  # the number of its switch, from 1 on
        raise IntegrationError(
            system.switch_owners[turned - 1],
            found="its markers have turned against each other by half a turn",
            expected="less than half a turn, where its moment would jump to the opposite sign",
            remedy="Use a TorsionSpring on a joint, which counts full turns, or no stiffness about this axis",
        )
