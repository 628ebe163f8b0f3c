"""`ArcLength`, `LoadSteps`: equilibria along a growing load, and `LoadPath`, what came out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from flexmb.errors import IntegrationError, ModelError
from flexmb.integrate.equilibria.path import EquilibriumPath, Point
from flexmb.integrate.runs.validity import in_equilibrium
from flexmb.model.described import Described, is_number
from flexmb.results import Phase, Solution, Status

__all__ = ["ArcLength", "LimitPoint", "LoadPath", "LoadSteps", "follow"]

STRAIGHT = 0.9
"""Least cosine between the tangents of neighbouring points: a sharper turn is taken in shorter arcs."""


class LimitPoint(NamedTuple):
    """A point where the equilibrium under a given load is not unique.

    sample : int, number of its sample; load : load factor t; body : title of the body that moves most there;
    kind : "maximum" or "minimum" of the load, or "bifurcation": the body may leave the path sideways.
    """

    sample: int
    load: float
    body: str
    kind: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class LoadPath(Solution):
    """Equilibria along a load; its times `t` are the load factors, and go down where the load does.

    Parameters
    ----------
    limit_points : tuple of LimitPoint
        In the order of the path.
    """

    limit_points: tuple[LimitPoint, ...] = ()

    @property
    def factor(self) -> np.ndarray:
        """Load factor of every sample, (nt,)."""
        return self.t


@dataclass(frozen=True, kw_only=True)
class ArcLength(metaclass=Described):
    """Follow the equilibrium by arc length: past a maximum of the load the path continues with a falling one.

    Length is counted in displacements (root mean square, as shares of the largest so far) and load (as a share of
    what is to be reached). A step is shortened where the path turns and where Newton's method is slow.

    Parameters
    ----------
    start : float
        Load factor at which the path begins.
    step : float, -
        First arc.
    longest : float, -
        Longest arc.
    points : int
        The path ends after so many, or where it reaches the load factor asked for.

    Source: Riks 1979; Crisfield 1981; eq. (arc-length).
    """

    start: float = 0.0
    step: float = 0.02
    longest: float = 0.1
    points: int = 400

    def __post_init__(self):
        for name in ("step", "longest"):
            value = getattr(self, name)
            _require(self, name, is_number(value) and 0.0 < value <= 1.0, "a share between 0 and 1")
        _require(self, "start", is_number(self.start), "a load factor")
        _require_count(self, "points")


@dataclass(frozen=True, kw_only=True)
class LoadSteps(metaclass=Described):
    """Raise the load in equal steps; a limit point or a bifurcation on the way is an error that names the load reached.

    Parameters
    ----------
    steps : int
    start : float
        Load factor at which the path begins.
    """

    steps: int = 20
    start: float = 0.0

    def __post_init__(self):
        _require(self, "start", is_number(self.start), "a load factor")
        _require_count(self, "steps")


def _require(settings, name: str, holds: bool, expected: str) -> None:
    if not holds:
        raise ModelError(
            type(settings).__name__,
            found=f"{name} = {getattr(settings, name)!r}",
            expected=expected,
            remedy=f"Leave {name} out for {getattr(type(settings), name)}",
        )


def _require_count(settings, name: str) -> None:
    value = getattr(settings, name)
    _require(settings, name, isinstance(value, int | np.integer) and bool(value >= 1), "a whole number >= 1")


def follow(model, system, start, settings: ArcLength | LoadSteps, t: float, tolerance: float) -> LoadPath:
    """Return the path from an equilibrium `start` (State) at the load settings.start to the load `t`."""
    if t == settings.start:
        raise ModelError(
            "statics",
            found=f"the path begins and ends at the load factor {t:.6g}",
            expected="another load factor at the end",
            remedy="Write t=1.0: loads are functions of t",
        )
    path = EquilibriumPath(system, start, abs(t - settings.start), tolerance)
    walk = _Walk(model, path, t, settings if isinstance(settings, ArcLength) else ArcLength(start=settings.start))
    first = path.begin(start.q, start.lam, settings.start, np.sign(t - settings.start))
    if first is None:
        raise IntegrationError(
            f"Model '{model.name}'",
            found=f"the load factor {settings.start:.6g} has no regular equilibrium" + path.loose(start),
            expected="stiffness in every freedom",
            remedy="Support free motions, or begin at another load: start=0.01",
        )
    return walk.run(first) if isinstance(settings, ArcLength) else _stepped(walk, first, settings.steps)


class _Walk:
    """The points of a path so far, and what was found between them."""

    def __init__(self, model, path: EquilibriumPath, end: float, settings: ArcLength):
        self.model, self.path, self.end, self.settings = model, path, end, settings
        self.points: list[Point] = []
        self.marks: list[LimitPoint] = []

    def run(self, first: Point) -> LoadPath:
        """Return the whole path."""
        self.points.append(first)
        s, done = self.settings.step, False
        while not done and len(self.points) < self.settings.points:
            s, done = self.advance(s)
        del self.points[self.settings.points :]  # the last arc may have added a limit point too
        self.marks = [mark for mark in self.marks if mark.sample < len(self.points)]
        done = done and self.points[-1].t == self.end
        reached = self.points[-1].t
        return self.solution(
            Status.finished()
            if done
            else Status(
                "stopped",
                f"{len(self.points)} points, load factor {reached:.6g} of {self.end:.6g}",
                "Raise points= of the ArcLength to continue",
            )
        )

    def advance(self, s: float) -> tuple[float, bool]:
        """Add the next point, and special points before it; return the next arc and whether the end is reached."""
        path, base = self.path, self.points[-1]
        new = path.solve(base, s)
        while new is None or (path.cosine(base, new) < STRAIGHT and s > 1e-5):
            s *= 0.5
            if s < 1e-8:
                raise self.failure(
                    f"no equilibrium beyond the load factor {base.t:.6g}, where {path.foremost(base)} moves most",
                    "Begin with a shorter step=, or give the structure an imperfection",
                )
            new = path.solve(base, s)
        between = self.special(base, new)
        stations = [base, *between, new]
        for a, b in pairwise(stations):
            if (a.t - self.end) * (b.t - self.end) <= 0.0 and a.t != self.end:
                last = self.at_load(a, b, self.end) or b
                self.points.append(last._replace(t=self.end))
                return s, True
            self.points.append(b)
        self.points[-1] = path.reached(new)
        return min(self.settings.longest, s * float(np.clip((6.0 / max(new.iterations, 1)) ** 0.5, 0.5, 2.0))), False

    def at_load(self, a: Point, b: Point, load: float) -> Point | None:
        """Return the point between two at which the load factor has a value."""
        return self.path.locate(a, b, lambda point: point.t - load, 1e-12 * self.path.span)

    def special(self, base: Point, new: Point) -> list[Point]:
        """Return the limit point or bifurcation between two points, marked."""
        rising, later = base.tangent[-1], new.tangent[-1]
        if rising * later < 0.0:
            point = self.path.locate(base, new, lambda p: p.tangent[-1], 1e-8)
            kind = "maximum" if rising > 0.0 else "minimum"
        elif base.sign != new.sign:
            point, kind = self.path.bisect(base, new), "bifurcation"
        else:
            return []
        if point is None:
            return []
        self.marks.append(LimitPoint(len(self.points), float(point.t), self.path.foremost(point), kind))
        return [] if point is new else [point]

    def failure(self, found: str, remedy: str) -> IntegrationError:
        """Return an error with the path so far."""
        solution = self.solution(Status.failed(found, remedy))
        return IntegrationError(
            f"Model '{self.model.name}'", found=found, expected="a path of equilibria", remedy=remedy, solution=solution
        )

    def solution(self, status: Status) -> LoadPath:
        """Return the points as samples."""
        system, n = self.path.system, len(self.points)
        phase = Phase(
            model=self.model,
            system=system,
            t=np.array([p.t for p in self.points]),
            q=np.array([p.q for p in self.points]),
            u=np.zeros((n, system.nu)),
            a=np.zeros((n, system.nu)),
            lam=np.array([p.lam for p in self.points]).reshape(n, system.ng),
            works=np.zeros((n, 3)),
            ended=status.kind,
        )
        return LoadPath(
            phases=(phase,),
            status=status,
            limit_points=tuple(self.marks),
            statistics={
                "points": n,
                "iterations": sum(p.iterations for p in self.points),
                **in_equilibrium(phase, "from the load factor {t:.4g} on"),
            },
        )


def _stepped(walk: _Walk, first: Point, steps: int) -> LoadPath:
    """Return the equilibria at equal load steps; IntegrationError at a limit point or bifurcation."""
    walk.points.append(first)
    kept, s = [first], walk.settings.step
    levels = np.linspace(first.t, walk.end, steps + 1)[1:]
    done = False
    while not done:
        if len(walk.points) > walk.settings.points:
            raise walk.failure(
                f"the load factor {walk.points[-1].t:.6g} after {len(walk.points)} points",
                "Follow the path with path=flexmb.ArcLength()",
            )
        at = len(walk.points) - 1
        s, done = walk.advance(s)
        for a, b in pairwise(walk.points[at:]):
            if walk.marks:
                break
            for level in levels[(levels - a.t) * (levels - b.t) <= 0.0]:
                point = b if b.t == level else walk.at_load(a, b, float(level))
                if point is not None and level not in [p.t for p in kept]:
                    kept.append(point._replace(t=float(level)))
        if walk.marks:
            mark = walk.marks[0]
            what = "a bifurcation" if mark.kind == "bifurcation" else "a limit point"
            walk.points, walk.marks = kept, []
            raise walk.failure(
                f"{what} at the load factor {mark.load:.6g} (of {walk.end:.6g}), where {mark.body} buckles",
                "Follow the path beyond with path=flexmb.ArcLength(), or simulate the snap with flexmb.simulate",
            )
    walk.points = kept
    return walk.solution(Status.finished())
