"""What has happened in a run, and whether it happens again and again."""

from __future__ import annotations

from typing import Any

__all__ = ["Happened"]

OFTEN = 20
"""How often a repeating event may happen in the time between two looks at its sensor."""


class Happened:
    """The events of a run, one after another."""

    def __init__(self) -> None:
        self._times: dict[str, list[float]] = {}

    def too_often(self, event: Any, t: float, within: float) -> bool:
        """Take an event at the time t, s; has it happened so often lately that less than `within`, s, has passed?"""
        times = self._times.setdefault(event.name, [])
        times.append(t)
        return len(times) > OFTEN and t - times[-OFTEN] < within
