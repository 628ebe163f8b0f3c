"""`Fixed`: no relative motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmb.constraints import Coincident, Perpendicular
from flexmb.errors import ModelError
from flexmb.model.kinds import Body, Joint

__all__ = ["Fixed"]


@dataclass(frozen=True, eq=False)
class Fixed(Joint):
    """Let nothing move between the two markers.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a and marker b, "body.marker"; reactions are those on the body of marker b.
    """

    forbids = (Coincident(), Perpendicular("x", "y"), Perpendicular("y", "z"), Perpendicular("z", "x"))
    permits = ()

    @classmethod
    def at_cuts(cls, bodies: Sequence[Body]) -> tuple[Fixed, ...]:
        """Return the joints between the parts of a body (`flexmb.FloatingBody.split`): one for each pair of markers
        with the same name ``"cut_..."``, under that name with the name of the body."""
        ends: dict[str, list[str]] = {}
        for body in bodies:
            for marker in body.marker_poses():
                if marker.startswith("cut_"):
                    ends.setdefault(f"{body.name.rpartition('_')[0]}_{marker}", []).append(f"{body.name}.{marker}")
        alone = [names[0] for names in ends.values() if len(names) != 2]
        if alone:
            raise ModelError(
                f"Marker '{alone[0]}'",
                found="no marker of another body to join it with",
                expected="all bodies of FloatingBody.split",
                remedy="Give them all at once",
            )
        return tuple(cls(name, markers=(a, b)) for name, (a, b) in ends.items())
