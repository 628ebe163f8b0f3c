"""Random mechanisms, written down in every way of `Seen`: trees of bodies, with springs, loads and drives."""

from __future__ import annotations

from functools import cache

import numpy as np
from metamorphic.extras import add_extras, plate
from metamorphic.seen import PLAIN, Seen, turn
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction

KINDS = ("rigid", "rigid", "rigid", "point", "reduced", "cable", "beam")
JOINTS = ("Spherical", "Revolute", "Universal", "Cylindrical", "Fixed", "Planar", "Prismatic", "Screw", "Driven")
LENGTH = 0.4


@cache
def bar(frame=None) -> fmb.ModalNeutralData:
    """A slender bar, reduced between its ends, soft enough to bend visibly."""
    x = np.linspace(0.0, LENGTH, 7)
    points = np.column_stack([x, 0.02 * np.sin(x / LENGTH * np.pi), np.zeros(7)])
    soft = fmb.Material(young=2e10, poisson=0.3, density=2700.0)
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.01), material=soft)
    where = {} if frame is None else {"frame": frame}
    return reduction.reduce(fe, interfaces={"start": [0], "end": [6]}, modes=3, geometric_stiffness=True, **where)


class Builder:
    """Draws the random numbers of a mechanism in metres, kilograms and seconds, and writes it down as it is seen.

    The numbers drawn do not depend on `seen`.
    """

    def __init__(self, seed: int, seen: Seen = PLAIN, frame=None, kinds=KINDS):
        self.rng, self.seen, self.frame = np.random.default_rng(seed), seen, frame
        self.kinds = kinds
        self.ground: dict[str, fmb.Pose] = {}
        self.bodies: list = []
        self.joints: list = []
        self.forces: list = []
        self.sensors: list = []
        self.tips: list[tuple[str, np.ndarray]] = []  # marker, place in W, m

    def signal(self, value: float, swing: float, rate: float, size: float):
        """Return value + swing sin(rate t), of a quantity with the unit `size`."""
        s = self.seen
        return fmb.expression(f"{value * size!r} + {swing * size!r}*sin({rate / s.time!r}*(t - {s.t * s.time!r}))")

    def ground_marker(self, name: str, place, axes) -> str:
        s = self.seen
        self.ground[name] = fmb.Pose(tuple(s.point(place)), s.rotation(axes))
        return f"ground.{name}"

    def rigid(self, name: str, at, A, markers) -> None:
        """Add a rigid body with its origin and axes, and markers {name: (place in W, axes in W)}."""
        rng, s = self.rng, self.seen
        mass, center = rng.uniform(0.3, 1.0), rng.normal(size=3) * 0.05
        Q = turn(rng)
        box = rng.uniform(0.05, 0.2, size=3) ** 2
        J = Q @ np.diag(mass / 3.0 * (box.sum() - box)) @ Q.T
        origin, axes = at + A @ s.c, A @ s.C
        written = {
            key: fmb.Pose(tuple(s.within(axes.T @ (p - origin))), s.axes_within(axes.T @ B))
            for key, (p, B) in markers.items()
        }
        self.bodies.append(
            fmb.RigidBody(
                s.name(name),
                mass=s.mass * mass,
                inertia=s.inertia(s.C.T @ J @ s.C),
                center_of_mass=tuple(s.within(s.C.T @ (center - s.c))),
                at=tuple(s.point(origin)),
                rotation=s.rotation(axes),
                markers=written,
            )
        )

    def reduced(self, name: str, at, A, axes) -> np.ndarray:
        """Add a reduced bar that begins at a place; return where it ends."""
        s = self.seen
        data = bar(self.frame)
        if s.mirror:
            data = data.mirrored("xy")
        data = data.rescaled(length=s.length, mass=s.mass, time=s.time)
        start = np.zeros(3)
        turned = {"start": fmb.Pose(rotation=s.axes_within(A.T @ axes))}
        self.bodies.append(
            fmb.FloatingBody(
                s.name(name),
                data=data,
                at=tuple(s.point(at - A @ start)),
                rotation=s.rotation(A),
                damping=0.02,
                markers=turned,
            )
        )
        return at + A @ np.array([LENGTH, 0.0, 0.0])

    def line(self, kind: str, name: str, at, A) -> np.ndarray:
        """Add a cable or beam that begins at a place; return where it ends."""
        s = self.seen
        points = np.array([(0.0, 0.0, 0.0), (0.5 * LENGTH, 0.03, 0.0), (LENGTH, 0.0, 0.02)])
        pressure = s.force / s.length**2
        # a cable that is curved without load may bend to either side: straight=True leaves one equilibrium
        own = {"axial_damping": 0.02 * s.force * s.time, "straight": True} if kind == "cable" else {}
        own = own or {"damping": 1e-3 * s.time}
        self.bodies.append(
            {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}[kind](
                s.name(name),
                points=[tuple(s.within(p)) for p in points],
                elements=3,
                section=fem.Section.solid_circle(0.03 * s.length),
                material=fmb.Material(young=2e6 * pressure, poisson=0.3, density=900.0 * s.mass / s.length**3),
                at=tuple(s.point(at)),
                rotation=s.rotation(A),
                **own,
            )
        )
        return at + A @ points[-1]

    def joint(self, kind: str, name: str, markers) -> None:
        s = self.seen
        slide = -1.0 if s.mirror else 1.0
        name = s.name(name)
        if kind == "Driven":
            self.joints.append(fmb.Revolute(name, markers=markers))
            angle = self.signal(0.0, 0.4, 12.0, 1.0)
            self.joints.append(fmb.Drive(f"{name}_drive", joint=name, angle=angle))
        elif kind == "Screw":
            self.joints.append(fmb.Screw(name, markers=markers, pitch=slide * 0.1 * s.length))
        else:
            self.joints.append(getattr(fmb, kind)(name, markers=markers))
        if kind in ("Revolute", "Cylindrical"):
            spring = fmb.TorsionSpring(
                f"{name}_spring", joint=name, stiffness=0.5 * s.energy, damping=0.01 * s.energy * s.time, free_angle=0.2
            )
            self.forces.append(spring)
        self.sensors.append(fmb.Reaction(f"{name} reaction", joint=name))

    def spring(self, name: str, markers) -> None:
        s = self.seen
        name = s.name(name)
        stiff, viscous = s.force / s.length, s.force * s.time / s.length
        kind = self.rng.choice(["SpringDamper", "Bushing", "SpringDamper"])
        if kind == "SpringDamper":
            part = fmb.SpringDamper(
                name,
                markers=markers,
                stiffness=60.0 * stiff,
                damping=0.5 * viscous,
                length=0.3 * s.length,
                preload=self.signal(0.5, 1.0, 15.0, s.force),
            )
        else:
            along, about = (60.0, 40.0, 80.0), (0.3, 0.2, 0.4)
            part = fmb.Bushing(
                name,
                markers=markers,
                stiffness=[*(k * stiff for k in along), *(k * s.energy for k in about)],
                damping=[*(0.5 * viscous,) * 3, *(0.005 * s.energy * s.time,) * 3],
            )
        self.forces.append(part)
        self.sensors.append(fmb.ForceOf(f"{name} force", force=name))

    def load(self, name: str, marker: str) -> None:
        s = self.seen
        force = s.vector(self.rng.normal(size=3), 1.0)
        self.forces.append(
            fmb.PointLoad(
                s.name(name),
                marker=marker,
                force=[self.signal(0.0, float(f), 20.0, s.force) for f in force],
            )
        )

    def grow(self, number: int) -> None:
        """Add a body to the ground, or to the end of another one."""
        rng, s = self.rng, self.seen
        kind = str(rng.choice(self.kinds))
        name = f"body{number}"
        place, axes, A = rng.normal(size=3) * 0.2, turn(rng), turn(rng)
        own = axes
        if self.tips and rng.random() < 0.75:
            parent, place = self.tips[int(rng.integers(len(self.tips)))]
            oriented = not parent.startswith(("ground", "point", "line"))
        else:
            parent, oriented = "ground", True
        joint = str(rng.choice(JOINTS)) if oriented and kind in ("rigid", "reduced") else "Spherical"
        if joint == "Universal":  # its z-axes are perpendicular
            own = axes @ np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
        if kind == "point":
            joint = "Rod"
            at = place + 0.3 * A[:, 0]
            mass = rng.uniform(0.2, 0.5)
            self.bodies.append(fmb.PointMass(s.name(name), mass=s.mass * mass, at=tuple(s.point(at))))
            second, end, tip = f"{s.name(name)}.center", at, f"point {name}.center"
        elif kind == "rigid":
            at, end = place - 0.1 * A[:, 0], place + 0.25 * A[:, 1]
            self.rigid(name, at, A, {"start": (place, own), "end": (end, np.eye(3))})
            second, tip = f"{s.name(name)}.start", f"{name}.end"
        elif kind == "reduced":
            end = self.reduced(name, place, A, own)
            second, tip = f"{s.name(name)}.start", f"line {name}.end"
        else:
            end = plate(self, name, place, A) if kind == "plate" else self.line(kind, name, place, A)
            second, tip = f"{s.name(name)}.start", f"line {name}.end"
        first = self.first_marker(parent, number, place, axes)
        if kind == "point":
            self.joints.append(fmb.Rod(s.name(f"joint{number}"), markers=(first, second)))
        else:
            self.joint(joint, f"joint{number}", (first, second))
        self.tips.append((tip, end))
        watched = second if kind == "point" else f"{s.name(name)}.end"
        self.sensors.append(fmb.Position(s.name(f"{name} place"), marker=watched))
        self.sensors.append(fmb.Velocity(s.name(f"{name} speed"), marker=watched))
        if rng.random() < 0.6:
            far = self.ground_marker(f"spring{number}", end + rng.normal(size=3) * 0.2, np.eye(3))
            self.spring(f"spring{number}", (far, watched)) if kind == "rigid" else self.pull(number, far, watched)
        if rng.random() < 0.4:
            self.load(f"load{number}", watched)

    def pull(self, number: int, far: str, watched: str) -> None:
        s = self.seen
        stiff, viscous = 60.0 * s.force / s.length, 0.5 * s.force * s.time / s.length
        self.forces.append(
            fmb.SpringDamper(
                s.name(f"spring{number}"),
                markers=(far, watched),
                stiffness=stiff,
                damping=viscous,
                length=0.1 * s.length,
            )
        )

    def first_marker(self, parent: str, number: int, place, axes) -> str:
        """Return the marker on the ground, or on the end of a body, to which the next one is joined."""
        s = self.seen
        if parent == "ground":
            return self.ground_marker(f"m{number}", place, axes)
        kind, _, marker = parent.rpartition(" ")
        body, _, end = marker.partition(".")
        if kind:
            return f"{s.name(body)}.{end}"
        k = next(i for i, b in enumerate(self.bodies) if b.name == s.name(body))
        old = self.bodies[k]
        A = np.asarray(Rotation.from_matrix(_matrix(old.rotation)).as_matrix())
        r = (s.point(place) - np.asarray(old.at)) @ A
        markers = {**old.markers, f"m{number}": fmb.Pose(tuple(r), A.T @ s.rotation(axes))}
        self.bodies[k] = old.replaced(markers=markers)
        return f"{s.name(body)}.m{number}"

    def model(self, count: int, seed: int | None = None) -> fmb.Model:
        """Return a mechanism of so many bodies; with a seed, what else is drawn from it is added."""
        s = self.seen
        gravity = np.array([1.0, -2.0, -9.0])
        for number in range(1, count + 1):
            self.grow(number)
        if seed is not None:
            add_extras(self, seed)
        bodies = [fmb.Ground(markers=self.ground), *self.bodies]
        sensors = [*self.sensors, fmb.Energy(s.name("kinetic"), kind="kinetic"), fmb.Energy(s.name("total"))]
        return fmb.Model(
            bodies=s.shuffled(bodies),
            joints=s.shuffled(self.joints),
            forces=s.shuffled(self.forces),
            sensors=s.shuffled(sensors),
            gravity=tuple(s.vector(gravity, s.length / s.time**2)),
        )


def _matrix(rotation) -> np.ndarray:
    return np.asarray(rotation, float)


def mechanism(
    seed: int, seen: Seen = PLAIN, *, count: int | None = None, frame=None, kinds=KINDS, extras: bool = False
) -> fmb.Model:
    """Return the random mechanism of a seed as it is seen; the same mechanism for the same seed."""
    rng = np.random.default_rng(seed)
    builder = Builder(seed, seen, frame, kinds)
    return builder.model(int(rng.integers(1, 4)) if count is None else count, seed if extras else None)
