"""The bench of the campaigns of faults: small models, a folder to run them in, and the judgement of what is left."""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from faults.children import Ended, begin, ended
from fuzz.data_files import reduced
from results.spinning import block_data

import flexmb as fmb
from flexmb.errors import FlexmbError

__all__ = ["SAMPLES", "SCENES", "Bench", "Counts"]

SAMPLES = 601
PLACE = fmb.JointCoordinate("place", joint="rail")


@dataclass
class Counts:
    """What came out of a campaign."""

    cases: int = 0
    lost: int = 0
    refused: int = 0
    tracebacks: int = 0
    crashes: int = 0
    hangs: int = 0
    notes: list[str] = field(default_factory=list)

    @property
    def bad(self) -> int:
        """Number of what must not be."""
        return self.lost + self.refused + self.tracebacks + self.crashes + self.hangs

    def take(self, end: Ended, what: str, slow: float = np.inf) -> None:
        """Count how a child ended."""
        self.tracebacks += end.traceback
        self.crashes += end.crashed
        self.hangs += end.hung or end.seconds > slow
        if end.traceback or end.crashed or end.hung or end.seconds > slow:
            self.notes.append(f"{what}: code {end.code}, {end.seconds:.1f} s: {end.text[-1500:]}")


def swinging() -> fmb.Model:
    """Return a block on a hinge, elastic: its reduced body is in the file too."""
    return fmb.Model(
        name="swing",
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(),
            fmb.FloatingBody("block", data=block_data(), at=(0.1, 0, 0)),
            fmb.PointMass("stone", mass=2.0, at=(0, 0, 1)),
        ],
        sensors=[fmb.Position("place", marker="stone.center"), fmb.Energy("energy")],
    )


def controlled(law, *more) -> fmb.Model:
    """Return a box and a ball that fall onto a floor by a law of contact, and a cart under a sampled controller."""
    light = {"inertia": (1e-3, 1e-3, 1e-3)}
    wanted = fmb.formula("12 - 400*x - 15*rate(x)", over={"x": PLACE})
    return fmb.Model(
        name="bounce",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0), "rail": (2, 0, 0)}),
            fmb.RigidBody("box", mass=1.0, at=(0, 0, 0.2), rotation=(0.3, 0.2, 0), velocity=(1, 0, 0), **light),
            fmb.RigidBody("ball", mass=0.5, at=(0.5, 0, 0.3), **light),
            fmb.RigidBody("cart", mass=1.0, at=(2.0, 0, 0.05), **light),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.A", shape=fmb.Plane()),
            fmb.Surface("box", marker="box.center", shape=fmb.Cuboid(size=(0.1, 0.1, 0.1)), spacing=0.05),
            fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(0.05), spacing=0.02),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.rail", "cart.center"))],
        forces=[
            fmb.SurfaceContact("touch", surfaces=("floor", ("box", "ball")), law=law),
            fmb.Actuator("hold", joint="rail", effort=fmb.Sampled(wanted, period=0.004, name="control")),
            *more,
        ],
        sensors=[fmb.Position("box", marker="box.center"), fmb.Position("ball", marker="ball.center"), PLACE],
    )


def breaking() -> fmb.Model:
    """Return a reduced part on a hinge that a controller with memory turns; a rod breaks, a spring softens later."""
    angle = fmb.JointCoordinate("angle", joint="hinge")
    error = fmb.Lag(fmb.formula("x - 0.2", over={"x": angle}), time=0.02)
    wanted = fmb.formula("-5*x - 20*i - 0.05*rate(a)", over={"x": error, "i": fmb.Integral(error), "a": angle})
    return fmb.Model(
        name="break",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0), "B": (0.1, 0.3, 0.4)}),
            fmb.FloatingBody("part", data=reduced(), at=(-0.05, -0.03, 0)),
            fmb.PointMass("stone", mass=0.5, at=(0.1, 0.3, 0.1)),
        ],
        joints=[
            fmb.Revolute("hinge", markers=("ground.A", "part.a")),
            fmb.Rod("rod", markers=("ground.B", "stone.center")),
        ],
        forces=[
            fmb.Actuator("turn", joint="hinge", effort=wanted),
            fmb.SpringDamper("spring", markers=("part.b", "stone.center"), stiffness=400.0, damping=1.0, length=0.1),
        ],
        sensors=[angle, fmb.Position("stone", marker="stone.center"), fmb.Reaction("bearing", joint="hinge")],
        events=[
            fmb.Event("breaks", sensor="angle", above=0.3, then=fmb.Release("rod")),
            fmb.Event("softens", at=0.2, then=fmb.Change("spring", stiffness=100.0)),
        ],
    )


SCENES: dict[str, tuple[Callable[[], fmb.Model], fmb.Simulation, float]] = {
    "swing": (swinging, fmb.Simulation(t_end=0.3, samples=SAMPLES, integrator=fmb.GeneralizedAlpha(step=5e-4)), 1e-5),
    "bounce": (
        lambda: controlled(fmb.Rigid(restitution=0.4, friction=0.3)),
        fmb.Simulation(t_end=0.3, samples=SAMPLES, integrator=fmb.MoreauJean(step=5e-4)),
        1e-9,
    ),
    "press": (
        lambda: controlled(
            fmb.ElasticFoundation(modulus=1e7, thickness=0.1, damping=0.1, friction=0.3),
            fmb.Actuator("switch", joint="rail", effort=fmb.Relay(PLACE, limits=(0.01, 0.02), values=(0.0, 1.0))),
        ),
        fmb.Simulation(t_end=0.3, samples=SAMPLES, integrator=fmb.GeneralizedAlpha(step=5e-4)),
        1e-9,
    ),
    "break": (
        breaking,
        fmb.Simulation(t_end=0.3, samples=SAMPLES, integrator=fmb.GeneralizedAlpha(step=2e-4, follow_errors=False)),
        1e-9,
    ),
}
"""Models by name, how they are run, and how far a resumed run may be from one in a piece.

An elastic body; rigid contacts in time steps, and compliant ones, both with a block whose value is held between sample
times; a reduced part under a controller with states, with two events. There errors are not followed: what is kept of a
cut run has no factors, with which the motion beside goes on, and reactions differ by 1e-8 of their size."""

ANEW = {"break": 1e-3}
"""How far a run may be that goes on after SIGKILL, relative to the largest value of each column, if that is more: the
integrator begins anew behind the last sample, and reactions of stiff parts ring from there otherwise."""


class Bench:
    """A folder to work in, with a model, its reference, and forks that know all kernels."""

    def __init__(self, folder: Path, seed: int, cases: int | None, scene: str = "swing"):
        self.folder, self.random, self.cases = folder, random.Random(seed), cases
        self.model, self.run = folder / "swing.toml", folder / "work" / "run"
        self.run.parent.mkdir(mode=0o777)
        os.chmod(self.run.parent, 0o777)
        made, settings, self.close = SCENES[scene]
        self.anew = ANEW.get(scene, 0.0)
        fmb.save_model(made(), self.model, settings)
        fmb.simulate(fmb.load_model(self.model), **settings.keywords())  # compiles, for the forks
        done = ended(begin(["run", str(self.model), "--out", str(folder / "reference")]), limit=1200.0)
        assert done.code == 0, done.text
        self.seconds = ended(begin(["run", str(self.model), "--out", str(folder / "again")])).seconds
        self.table = self.read(folder / "reference")

    @staticmethod
    def read(run: Path) -> np.ndarray:
        """Return the sensor table of a run folder."""
        return np.loadtxt(run / "sensors.csv", delimiter=",", skiprows=1)

    def clear(self) -> None:
        """Remove the run."""
        shutil.rmtree(self.run, ignore_errors=True)

    def start(self, *more: str, before: Callable[[], None] = lambda: None):
        """Begin the run in a child."""
        return begin(["run", str(self.model), "--out", str(self.run), *more], before)

    def chosen(self, count: int) -> list[int]:
        """Return all numbers below `count`, or so many of them as there shall be cases."""
        if self.cases is None or self.cases >= count:
            return list(range(count))
        return sorted(self.random.sample(range(count), self.cases))

    def times(self, count: int) -> range:
        """Return how often something random is tried."""
        return range(count if self.cases is None else min(count, self.cases))

    def judge(self, counts: Counts, promised: int, what: str, killed: bool = False) -> None:
        """Look for all samples that a child had written, then finish its run and compare it with the reference; a child
        that was `killed` has lost what its integrator knew.
        """
        counts.cases += 1
        try:
            found = len(fmb.Solution.load(self.run / "solution.h5", read_model=fmb.read_model_text).t)
        except FlexmbError as error:
            found = 0
            if promised:
                counts.notes.append(f"{what}: {error}")
        if found < promised:
            counts.lost += 1
            counts.notes.append(f"{what}: {found} of {promised} samples")
        verb = ["resume", str(self.run)] if found else ["run", str(self.model), "--out", str(self.run), "--overwrite"]
        again = ended(begin(verb))
        counts.take(again, f"{what}, {verb[0]}")
        complete = again.code == 2 and "has reached" in again.text  # it was ended when all was done
        try:
            table = self.read(self.run)
            apart = np.abs(table - self.table).max(axis=0) if table.shape == self.table.shape else np.inf
            off = np.max(apart)
            near = np.all(apart <= np.maximum(self.close, killed * self.anew * np.abs(self.table).max(axis=0)))
            rows = f"{len(table)} of {len(self.table)} rows"
        except (OSError, ValueError) as error:
            off, rows, near = np.inf, f"no table ({error})", False
        if not (again.code == 0 or complete) or not near:
            counts.refused += 1
            counts.notes.append(f"{what}, {verb[0]}: code {again.code}, {rows}, off by {off:.3g}: {again.text[-500:]}")
