"""`Status`: how a simulation ended, and what to do about it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

__all__ = ["SHARED", "STORED", "Status"]

SHARED = "reactions not unique"
"""Name of the statistic that lists the joints, with their equations, between which reactions are not unique."""
STORED = "solution file"
"""Name of the statistic that says where the solution file is, if it was removed or moved while it was written; an empty
text if it is nowhere."""


@dataclass(frozen=True)
class Status:
    """How a simulation ended.

    Parameters
    ----------
    kind : str
        "finished", "stopped", "interrupted", "limited", "failed" or "running"; make a status with the method of that
        name.
    message : str
        What happened, with its time.
    remedy : str
        What the user can do now; empty if nothing is wrong.

    Examples
    --------
    >>> status = Status.failed("step size below 1e-12 s at t = 0.31 s", "Check for an impact without damping")
    >>> print(status)
    failed: step size below 1e-12 s at t = 0.31 s. Check for an impact without damping.
    >>> status.ok
    False
    """

    kind: str
    message: str = ""
    remedy: str = ""

    @staticmethod
    def finished(t: float | None = None) -> Status:
        """The end time was reached."""
        return Status("finished", "" if t is None else f"end time t = {t:.6g} s reached")

    @staticmethod
    def stopped(event: str, t: float) -> Status:
        """An event asked for the end."""
        return Status("stopped", f"event '{event}' at t = {t:.6g} s")

    @staticmethod
    def interrupted(t: float | None = None) -> Status:
        """The user, or the end of the process, cut the run off; all samples so far are there."""
        when = "" if t is None else f" after t = {t:.6g} s"
        return Status("interrupted", f"the run was cut off{when}", "What was computed is complete and can be read")

    @staticmethod
    def limited(seconds: float, t: float) -> Status:
        """The run has used up the time that it was given; all samples so far are there."""
        found = f"the limit of {seconds:g} s of clock time was reached at t = {t:.6g} s"
        return Status("limited", found, "What was computed is complete; resume the run to go on from there")

    @staticmethod
    def running(t: float, who: str = "another process") -> Status:
        """The run is in progress: the file was read while it was written."""
        return Status("running", f"{who} has come to t = {t:.6g} s", "Read it again later for more")

    @staticmethod
    def failed(message: str, remedy: str) -> Status:
        """The integrator could not continue; all samples so far are there."""
        return Status("failed", message, remedy)

    @property
    def ok(self) -> bool:
        """Did the run end as planned, at its end time or by an event?"""
        return self.kind in ("finished", "stopped")

    def __str__(self) -> str:
        sentences = ". ".join(text.rstrip(".") for text in (self.message, self.remedy) if text)
        return f"{self.kind}: {sentences}." if sentences else self.kind

    def to_text(self) -> str:
        """Return the status as JSON text, as it is stored in files."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_text(text: str) -> Status:
        """Return the status that `to_text` wrote."""
        return Status(**json.loads(text))
