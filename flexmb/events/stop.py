"""`Stop`: the run ends."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.events.event import Action

__all__ = ["Stop"]


@dataclass(frozen=True)
class Stop(Action):
    """End the simulation; its status then is "stopped" with the name of the event."""

    def apply(self, model, series):
        """Return None."""
        return None
