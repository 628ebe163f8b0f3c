"""Random trees of reduced bodies, whole and split, with loops: what `Recursive` takes as links in joint coordinates.

Held trees have an equilibrium: a bushing at the end of every body. In driven ones drives move every freedom of a joint,
and reduced bodies are rigid.

Bodies have three interfaces with turned axes, a frame that follows the whole or an interface, loads that follow them,
and a preload. Their meshes are written down in other axes and far from the origin, as rigid bodies are.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from metamorphic.extras import add_extras
from metamorphic.mechanisms import JOINTS, LENGTH, Builder
from metamorphic.seen import PLAIN, Seen, turn

import flexmb as fmb
from flexmb import fem, reduction

__all__ = ["flexible_tree"]

KINDS = ("rigid", "bar", "bar", "strip", "two", "four")
MATERIAL = fmb.Material(young=2e10, poisson=0.3, density=2700.0)
MIDDLE = np.array([0.5 * LENGTH, 0.02, 0.0])
PARTS = {"two": 2, "four": 4}
DRIVEN = {
    "Fixed": (),
    "Revolute": ("turn",),
    "Driven": (),
    "Screw": ("turn",),
    "Prismatic": ("slide",),
    "Cylindrical": ("turn", "slide"),
    "Planar": ("turn", "slide_x", "slide_y"),
    "Universal": ("turn", "turn_b"),
}
"""Freedoms of joints that take as many drives."""
PRESSURE = 5.0
"""N, what the load of a strip amounts to."""


def _mesh(axes: bytes, wide: bool) -> fem.FEModel:
    """Return a slightly bent bar along x, in the axes and about the origin that belong to the numbers."""
    C, c = np.split(np.frombuffer(axes), [9])
    C, x = C.reshape(3, 3), np.linspace(0.0, LENGTH, 9)
    points = np.column_stack([x, MIDDLE[1] * np.sin(x / LENGTH * np.pi), np.zeros(9)])
    section = fem.Section.rectangle(0.03, 0.006) if wide else fem.Section.rectangle(0.02, 0.01)
    return fem.frame(
        points=(points - c) @ C, section=section, material=MATERIAL, orientation=C.T @ np.array([0.0, 1.0, 0.0])
    )


@cache
def bar(axes: bytes, frame: str) -> fmb.ModalNeutralData:
    """Return a bar with interfaces at its ends and in the middle, whose frame is that of an interface or of all."""
    ends = {"end": [8], "start": [0], "middle": [4]}
    return reduction.reduce(_mesh(axes, False), ends, modes=2, geometric_stiffness=True, frame=frame)


@cache
def strip(axes: bytes) -> fmb.ModalNeutralData:
    """Return a strip under a pressure that turns with it, which a part of that pressure bends already."""
    C = np.frombuffer(axes)[:9].reshape(3, 3)
    air = dict.fromkeys(range(9), tuple(C.T @ (0.0, 0.3, 1.0) / 9.0))
    return reduction.reduce(
        _mesh(axes, True),
        {"start": [0], "end": [8]},
        modes=3,
        stations={"middle": [4]},
        loads={"air": air},
        preload={"air": 0.2 * PRESSURE},
        geometric_stiffness=True,
    )


@cache
def pieces(axes: bytes, number: int) -> tuple[fmb.ModalNeutralData, ...]:
    """Return the parts of a bar."""
    C, c = np.split(np.frombuffer(axes), [9])
    x = C.reshape(3, 3)[0]
    fe = _mesh(axes, False)
    parts = fem.split(fe, at=[LENGTH * k / number - c[0] for k in range(1, number)], normal=x)
    middle = {"middle": tuple(fe.nodes[4])} if number == 2 else {}
    return reduction.split(parts, {"start": "start", "end": "end"}, 1, stations=middle, stress=False)


class FlexibleTrees(Builder):
    """Draws the random numbers of a flexible tree, and writes it down as it is seen."""

    def __init__(self, seed: int, seen: Seen = PLAIN, *, held: bool = False, driven: bool = False, **how):
        super().__init__(seed, seen, **how)
        self.held, self.driven, self.more = held, driven, np.random.default_rng([seed, 5])

    def signal(self, value: float, swing: float, rate: float, size: float):
        """Return a signal as that of a mechanism; what holds a tree stands still."""
        return super().signal(value, 0.0 if self.held else swing, rate, size)

    def data(self, made, *more):
        """Return reduced data in the axes and units in which the mechanism is seen."""
        s = self.seen
        found = made(np.concatenate([np.ravel(s.C), s.c]).tobytes(), *more)
        written = []
        for one in found if isinstance(found, tuple) else (found,):
            one = one.mirrored("xy") if s.mirror else one
            written.append(one.rescaled(length=s.length, mass=s.mass, time=s.time))
        return tuple(written) if isinstance(found, tuple) else written[0]

    def flexible(self, kind: str, name: str, at, A, axes) -> tuple[dict, dict]:
        """Add a body of a kind, or its parts, with its start at a place; return its markers by name and their places.

        axes : {marker: its axes in W}
        """
        s, rng = self.seen, self.rng
        origin, turned = at + A @ s.c, A @ s.C
        placed = {"at": tuple(s.point(origin)), "rotation": s.rotation(turned)}
        own = {key: fmb.Pose(rotation=s.axes_within(turned.T @ B)) for key, B in axes.items()}
        frame, damping = str(rng.choice(["buckens", "start", "end"])), float(rng.choice([0.0, 0.02]))
        groups = [True, True, False, ("inertia", "interface")][int(rng.integers(4))]
        places = {"start": at, "end": at + A @ np.array([LENGTH, 0.0, 0.0]), "middle": at + A @ MIDDLE}
        name = s.name(name)
        if kind in PARTS:
            parts = self.data(pieces, PARTS[kind])
            bodies = fmb.FloatingBody.split(name, parts, damping=damping, rigid=self.driven, **placed)
            first, last = bodies[0].name, bodies[-1].name
            markers = {"start": f"{first}.start", "end": f"{last}.end"}
            bodies = [b.replaced(markers={k: own[k] for k in own if k in b.data.marker_names}) for b in bodies]
            self.bodies += bodies
            self.joints += fmb.Fixed.at_cuts(bodies)
            return markers, places
        data = self.data(strip) if kind == "strip" else self.data(bar, frame)
        self.bodies.append(
            fmb.FloatingBody(
                name,
                data=data,
                damping=damping,
                markers=own,
                geometric_stiffness=groups,
                rigid=self.driven,
                **placed,
            )
        )
        if kind == "strip":
            amount = self.signal(0.5 * PRESSURE, PRESSURE, 30.0, 1.0)  # data in other units count it as before
            self.forces.append(fmb.Pressure(f"{name} wind", load=f"{name}.air", amount=amount))
        return {key: f"{name}.{key}" for key in places}, places

    def grow(self, number: int) -> None:
        """Add a body to the ground, or to a marker of another one, that it carries by any of its markers."""
        rng, s = self.rng, self.seen
        kind, joint = str(rng.choice(self.kinds)), str(rng.choice(JOINTS))
        joint = "Fixed" if self.driven and joint not in DRIVEN else joint
        name = f"body{number}"
        place, B, A, C = rng.normal(size=3) * 0.2, turn(rng), turn(rng), turn(rng)
        first = None
        if self.tips and rng.random() < 0.8:
            first, place, B = self.tips[int(rng.integers(len(self.tips)))]
        begin = str(rng.choice(["start", "start", "end"]))
        own = B @ np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]) if joint == "Universal" else B
        axes = {key: own if key == begin else C for key in ("start", "end")}
        arm = {"start": np.zeros(3), "end": np.array([LENGTH, 0.0, 0.0])}
        if kind == "rigid":
            at = place - 0.3 * A @ arm[begin]
            places = {key: at + 0.3 * A @ arm[key] for key in arm}
            self.rigid(name, at + 0.1 * A[:, 1], A, {key: (places[key], axes[key]) for key in places})
            markers = {key: f"{s.name(name)}.{key}" for key in places}
        else:
            at = place - A @ arm[begin]
            markers, places = self.flexible(kind, name, at, A, axes)
        if first is None:
            first = self.ground_marker(f"m{number}", place, B)
        pair = (first, markers[begin])
        if number > 1 or rng.random() < 0.8 or self.driven:  # now and then the first one floats
            turned = rng.random() >= 0.7
            self.joint(joint, f"joint{number}", pair[::-1] if turned else pair)
            if self.driven:
                self.drive(joint, f"joint{number}", turned)
        far = "end" if begin == "start" else "start"
        self.tips.append((markers[far], places[far], C))
        self._watch(name, markers[far])
        self._load(number, markers[far], places[far])
        if self.held:
            self.hold(number, markers[far], places[far], C)

    def drive(self, kind: str, joint: str, turned: bool) -> None:
        """Let all freedoms of a joint move as they are told, from where it is drawn."""
        s = self.seen
        for freedom in DRIVEN[kind]:
            swing, rate = float(self.more.uniform(-0.4, 0.4)), float(self.more.uniform(5.0, 15.0))
            name = s.name(f"{joint}_{freedom}")
            if freedom.startswith("turn"):
                start = 0.0
                if kind == "Universal":  # from an x-axis to a z-axis, which alone is turned back after a reflection
                    start = (0.5 if freedom == "turn" else -0.5) * (turned == (freedom == "turn")) + s.mirror
                move = {"angle": self.signal(start * np.pi, swing, rate, 1.0)}
            else:
                side = -1.0 if s.mirror and freedom == "slide" else 1.0
                move = {"displacement": self.signal(0.0, side * 0.2 * swing, rate, s.length)}
            self.joints.append(fmb.Drive(name, joint=s.name(joint), freedom=freedom, **move))
            self.sensors.append(fmb.Reaction(f"{name} reaction", joint=name))

    def hold(self, number: int, marker: str, place, axes) -> None:
        """Let a bushing to the ground hold the end of a body."""
        s = self.seen
        at = self.ground_marker(f"hold{number}", place + 0.02 * self.more.normal(size=3), axes)
        along, about = (400.0, 500.0, 600.0), (20.0, 25.0, 30.0)
        stiffness = [*(k * s.force / s.length for k in along), *(k * s.energy for k in about)]
        name = s.name(f"bushing{number}")
        self.forces.append(fmb.Bushing(name, markers=(at, marker), stiffness=stiffness, damping=np.zeros(6)))
        self.sensors.append(fmb.ForceOf(f"{name} force", force=name))

    def _watch(self, name: str, marker: str) -> None:
        self.sensors.append(fmb.Position(self.seen.name(f"{name} place"), marker=marker))
        self.sensors.append(fmb.Velocity(self.seen.name(f"{name} speed"), marker=marker))

    def _load(self, number: int, marker: str, place) -> None:
        rng, s = self.rng, self.seen
        if rng.random() < 0.4:
            at = self.ground_marker(f"spring{number}", place + rng.normal(size=3) * 0.2, np.eye(3))
            self.pull(number, at, marker)
        if rng.random() < 0.4:
            self.load(f"load{number}", marker)
        if rng.random() < 0.4:  # it follows the marker, whose axes are reflected on both sides
            pushes = zip(np.diag(s.S), rng.normal(size=3), strict=True)
            follows = [self.signal(0.3 * float(side), float(side * swing), 25.0, s.force) for side, swing in pushes]
            self.forces.append(fmb.PointLoad(s.name(f"thrust{number}"), marker=marker, force=follows, axes=marker))

    def close(self) -> None:
        """Join the end of a reduced body to the ground, where it is: modes leave the loop no dependent equation.

        Not beside a drive, which would bend what holds it by any amount.
        """
        s, rng = self.seen, self.rng
        rigid = {body.name for body in self.bodies if isinstance(body, fmb.RigidBody)}
        ends = [tip for tip in self.tips if tip[0].partition(".")[0] not in rigid]
        if not ends or any(isinstance(joint, fmb.Drive) for joint in self.joints):
            return
        marker, place, C = ends[int(rng.integers(len(ends)))]
        kind = str(rng.choice(["Spherical", "Rod", "Revolute", "Cylindrical", "Fixed"]))
        name = s.name("closing")
        if kind == "Rod":
            far = self.ground_marker("close", place + 0.3 * turn(rng)[:, 0], np.eye(3))
            self.joints.append(fmb.Rod(name, markers=(far, marker)))
        else:
            at = self.ground_marker("close", place, C)
            self.joints.append(getattr(fmb, kind)(name, markers=(at, marker)))
        self.sensors.append(fmb.Reaction(f"{name} reaction", joint=name))

    def tree(self, count: int, seed: int | None = None) -> fmb.Model:
        """Return a tree of so many bodies, in half of the cases with a loop, with a seed with contacts and the like."""
        for number in range(1, count + 1):
            self.grow(number)
        if self.rng.random() < 0.5 and not self.driven:
            self.close()
        if seed is not None:
            self.tips = [(f" {marker.removeprefix(self.seen.prefix)}", place) for marker, place, _ in self.tips]
            add_extras(self, seed)
        return self.model(0)


def flexible_tree(
    seed: int, seen: Seen = PLAIN, *, kinds=KINDS, extras: bool = False, held: bool = False, driven: bool = False
) -> fmb.Model:
    """Return the random flexible tree of a seed as it is seen; the same for the same seed."""
    count = int(np.random.default_rng(seed).integers(1, 5))
    return FlexibleTrees(seed, seen, kinds=kinds, held=held, driven=driven).tree(count, seed if extras else None)
