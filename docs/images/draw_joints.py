"""Draw the joints of the reference page: what builds the pages writes docs/images/joints/<Kind>.png.

Grey is body a, blue body b, red what is permitted (straight arrows: slides; round ones: turns).
The solids at the markers are those of the pictures of models; the arrows follow from what the joint permits.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import PolyCollection

from flexmb import joints
from flexmb.io.joint_glyphs import joint_solids
from flexmb.io.solids import box, sphere, tube
from flexmb.math.rotations import rotation_matrix

FOLDER = Path(__file__).parent / "joints"
GREY, BLUE, RED = (0.62, 0.64, 0.66), (0.30, 0.52, 0.80), (0.84, 0.18, 0.16)
ACROSS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # z of the marker along x of the drawing
UPRIGHT = np.eye(3)
VIEW = rotation_matrix((-1.15, 0, 0)) @ rotation_matrix((0, 0, -0.65))
E = 0.16


class Drawing:
    """Faces and arrows, seen from one side, drawn from the back to the front."""

    def __init__(self):
        self.faces, self.depths, self.colours, self.arrows = [], [], [], []

    def solid(self, surface, colour, matrix=UPRIGHT, at=(0, 0, 0)) -> None:
        """Add a surface, turned by a matrix, then shifted."""
        moved = surface.moved(matrix, at)
        light = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
        for face in [*moved.triangles, *moved.quads]:
            corners = moved.points[face] @ VIEW.T
            normal = np.cross(corners[1] - corners[0], corners[-1] - corners[0])
            size = np.linalg.norm(normal)
            if size == 0.0 or normal[2] < 0.0:
                continue
            shade = 0.55 + 0.45 * max(0.0, float(normal @ light) / size)
            self.faces.append(corners[:, :2])
            self.depths.append(corners[:, 2].mean())
            self.colours.append(tuple(shade * np.array(colour)))

    def line(self, points, both: bool = False) -> None:
        """Add a red arrow along points (n, 3), with a head at the end, or at both ends."""
        self.arrows.append((np.asarray(points) @ VIEW.T, both))

    def turn(self, axis, at=(0, 0, 0), radius: float = 0.42) -> None:
        """Add a round arrow about an axis."""
        x = np.cross(axis, (0.31, 0.2, 0.93) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0))
        x = x / np.linalg.norm(x)
        angle = np.linspace(-2.2, 2.2, 40)[:, None]
        self.line(np.asarray(at) + radius * (np.cos(angle) * x + np.sin(angle) * np.cross(axis, x)))

    def save(self, path: Path) -> None:
        """Write the picture."""
        figure, axis = plt.subplots(figsize=(2.6, 1.9))
        order = np.argsort(self.depths)
        colours = [self.colours[k] for k in order]
        faces = [self.faces[k] for k in order]
        axis.add_collection(PolyCollection(faces, facecolors=colours, edgecolors=colours, linewidths=0.3))
        for points, both in self.arrows:
            axis.plot(points[:, 0], points[:, 1], color=RED, lw=2)
            for way in (points[::-1], points)[: 1 + both]:
                tip, before = way[0], way[min(2, len(way) - 1)]
                style = {"arrowstyle": "-|>", "color": RED, "lw": 2, "mutation_scale": 14}
                axis.annotate("", tip[:2], before[:2], arrowprops=style)
        axis.set(xlim=(-1.15, 1.15), ylim=(-0.84, 0.84))
        axis.set_aspect("equal")
        axis.set_axis_off()
        figure.subplots_adjust(0, 0, 1, 1)
        figure.savefig(path, dpi=80)
        plt.close(figure)


def bar(drawing: Drawing, start, end, colour) -> None:
    """Add the body of a marker: a thin round bar."""
    drawing.solid(tube(start, end, 0.45 * E), colour)


def with_markers(kind: str) -> Drawing:
    """Draw a joint of two markers whose z-axis lies across the drawing (upright for those of a plane)."""
    drawing = Drawing()
    R_a = ACROSS if kind in ("Prismatic", "Cylindrical", "InLine", "ConstantVelocity") else UPRIGHT
    R_b = R_a
    if kind == "Universal":
        R_b = np.column_stack([(0, 0, 1.0), (1.0, 0, 0), (0, 1.0, 0)])
    if kind == "ConstantVelocity":
        R_b = rotation_matrix((0, 0, 0.5)) @ R_a
    for make, R, colour in zip(joint_solids(joints.KINDS[kind]), (R_a, R_b), (GREY, BLUE), strict=True):
        if make is not None:
            drawing.solid(make(E), colour, R)
    if kind == "Planar":
        drawing.solid(box((1.5, 1.1, 0.04)), GREY, at=(0, 0, -0.08))
        bar(drawing, (0, 0, 0.05), (0, 0, 0.6), BLUE)
    elif kind == "PointOnPlane":
        drawing.solid(box((1.5, 1.1, 0.04)), GREY, at=(0, 0, -0.16))
        bar(drawing, (0, 0, 0.05), (0, 0, 0.6), BLUE)
    elif kind in ("Prismatic", "Cylindrical", "InLine"):
        drawing.solid(tube((-0.9, 0, 0), (0.9, 0, 0), 0.5 * E), GREY)
        bar(drawing, (0, 0, 0.1), (0, 0, 0.65), BLUE)
    elif kind == "ConstantVelocity":
        bar(drawing, (-0.9, 0, 0), (0, 0, 0), GREY)
        bar(drawing, (0, 0, 0), 0.9 * R_b[:, 2], BLUE)
    else:
        bar(drawing, (-0.9, 0, 0), (0, 0, 0), GREY)
        bar(drawing, (0, 0, 0), (0.85, 0.3, 0), BLUE)
    freedoms = joints.KINDS[kind].permits
    for freedom in freedoms if isinstance(freedoms, tuple) else ():
        for twist in freedom.twists(R_a, R_b, np.zeros(3)):
            slide, turn = np.linalg.norm(twist[:3]), np.linalg.norm(twist[3:])
            if slide > 0.0:
                way = twist[:3] / slide
                side = np.array([0, 0, -0.3]) if kind not in ("Planar", "PointOnPlane") else np.array([0, 0, 0.0])
                drawing.line(side + np.outer((-0.55, 0.55), way), both=True)
            if turn > 0.0:
                drawing.turn(twist[3:] / turn)
    return drawing


def rod() -> Drawing:
    """A rod that keeps the distance of two balls."""
    drawing = Drawing()
    bar(drawing, (-0.55, 0, 0), (0.55, 0, 0), (0.75, 0.75, 0.75))
    for x, colour in ((-0.55, GREY), (0.55, BLUE)):
        drawing.solid(sphere(0.9 * E), colour, at=(x, 0, 0))
        bar(drawing, (x, 0, 0), (x, 0, -0.55), colour)
    angle = np.linspace(-0.45, 0.45, 20)[:, None]  # the blue ball about the grey one, upright and level
    for side in ((0, 0, 1.0), (0, 1.0, 0)):
        way = np.cos(angle) * (1.1, 0, 0) + 1.1 * np.sin(angle) * side
        drawing.line(way + (-0.55, 0, 0), both=True)
    return drawing


def screw() -> Drawing:
    """A nut on a threaded rod: one freedom, turn and slide together."""
    drawing, turns = Drawing(), 5.5
    bar(drawing, (-0.9, 0, 0), (0.9, 0, 0), GREY)
    angle = np.linspace(0.0, 2 * np.pi * 16, 320)
    thread = np.column_stack([np.linspace(-0.85, 0.85, 320), 0.075 * np.cos(angle), 0.075 * np.sin(angle)])
    for k in range(319):
        drawing.solid(tube(thread[k], thread[k + 1], 0.018), GREY)
    drawing.solid(tube((-0.15, 0, 0), (0.15, 0, 0), 1.2 * E), BLUE)
    bar(drawing, (0, 0, 0.1), (0, 0, 0.65), BLUE)
    angle = np.linspace(0.0, turns, 60)
    drawing.line(np.column_stack([0.12 * angle, -0.34 * np.cos(angle), 0.34 * np.sin(angle)]))
    return drawing


def point_on_curve() -> Drawing:
    """A ball on a bent rail."""
    drawing, s = Drawing(), np.linspace(-0.95, 0.95, 40)
    points = np.column_stack([s, 0.3 * np.sin(2.4 * s), 0.1 * np.cos(3 * s)])
    for k in range(39):
        drawing.solid(tube(points[k], points[k + 1], 0.3 * E), GREY)
    drawing.solid(sphere(1.1 * E), BLUE, at=points[22])
    bar(drawing, points[22], points[22] + (0, 0, 0.55), BLUE)
    drawing.line(points[24:36] + (0, -0.15, -0.15))
    return drawing


def point_on_path() -> Drawing:
    """A ball on a rail through markers, straight as described and bent."""
    drawing, s = Drawing(), np.linspace(-0.95, 0.95, 40)
    points = np.column_stack([s, 0 * s, 0.35 * s**2 - 0.3])
    for k in range(39):
        drawing.solid(tube(points[k], points[k + 1], 0.3 * E), GREY)
    for k in range(3, 40, 11):
        drawing.solid(sphere(0.6 * E), GREY, at=points[k])
        drawing.line([points[k] + (0, 0, 0.1), (points[k, 0], 0, 0.3)], both=True)
    drawing.solid(sphere(1.1 * E), BLUE, at=points[20])
    bar(drawing, points[20], points[20] + (0, 0, 0.55), BLUE)
    drawing.line(points[22:32] + (0, -0.15, -0.15))
    return drawing


def rolling() -> Drawing:
    """A disc on a plane."""
    drawing = Drawing()
    drawing.solid(box((1.7, 1.1, 0.04)), GREY, at=(0, 0, -0.42))
    drawing.solid(tube((0, -0.05, 0), (0, 0.05, 0), 0.4), BLUE)
    drawing.line([(-0.1, -0.45, -0.4), (0.7, -0.45, -0.4)])
    drawing.turn(np.array([0, -1.0, 0]), at=(0, -0.08, 0), radius=0.52)
    return drawing


def wheel(drawing: Drawing, at, radius: float, colour) -> None:
    """Add a toothed wheel about z."""
    at = np.asarray(at, float)
    drawing.solid(tube(at - (0, 0, 0.07), at + (0, 0, 0.07), 0.93 * radius), colour)
    for angle in np.arange(0.0, 2 * np.pi, 2 * np.pi / max(8, round(40 * radius))):
        R = rotation_matrix((0, 0, angle))
        drawing.solid(box((0.12 * radius + 0.03, 0.07, 0.14)), colour, R, at + R @ (0.97 * radius, 0, 0))


def gears(rack: bool) -> Drawing:
    """Two wheels, or a wheel and a rack."""
    drawing = Drawing()
    wheel(drawing, (-0.3, 0, 0), 0.38, GREY)
    drawing.turn(np.array([0, 0, 1.0]), at=(-0.3, 0, 0.1), radius=0.24)
    if rack:
        drawing.solid(box((1.7, 0.12, 0.14)), BLUE, at=(0, -0.52, 0))
        for x in np.arange(-0.8, 0.81, 0.1):
            drawing.solid(box((0.05, 0.08, 0.14)), BLUE, at=(x, -0.43, 0))
        drawing.line([(0.1, -0.75, 0), (0.8, -0.75, 0)])
    else:
        wheel(drawing, (0.4, 0, 0), 0.3, BLUE)
        drawing.turn(np.array([0, 0, -1.0]), at=(0.4, 0, 0.1), radius=0.18)
    return drawing


def gear_pair() -> Drawing:
    """A pinion inside a circular rack."""
    drawing = Drawing()
    outer, inner = 1.0, 0.86
    angles = np.radians(np.linspace(40.0, 140.0, 26))
    for start, end in pairwise(angles):
        middle = 0.5 * (start + end)
        R = rotation_matrix((0, 0, middle))
        drawing.solid(
            box((outer - inner, 1.02 * outer * (end - start), 0.14)),
            BLUE,
            R,
            R @ (0.5 * (outer + inner), 0, 0) - (0, 0.75, 0),
        )
        drawing.solid(box((0.06, 0.04, 0.14)), BLUE, R, R @ (inner - 0.03, 0, 0) - (0, 0.75, 0))
    wheel(drawing, (0, -0.14, 0), 0.2, GREY)
    drawing.turn(np.array([0, 0, 1.0]), at=(0, -0.14, 0.1), radius=0.12)
    drawing.turn(np.array([0, 0, 1.0]), at=(0, -0.75, 0), radius=0.3)
    return drawing


def drive() -> Drawing:
    """A motor and its shaft."""
    drawing = Drawing()
    drawing.solid(tube((0, 0, -0.35), (0, 0, 0.1), 1.7 * E), GREY)
    drawing.solid(tube((0, 0, 0.1), (0, 0, 0.3), 0.7 * E), BLUE)
    bar(drawing, (0, 0, 0.25), (0.85, 0.2, 0.25), BLUE)
    drawing.turn(np.array([0, 0, 1.0]), at=(0, 0, 0.35), radius=0.38)
    return drawing


def constraint() -> Drawing:
    """A ball on a path of one's own, an ellipse in the air."""
    drawing, angle = Drawing(), np.linspace(0.25, 2.0 * np.pi - 0.25, 60)[:, None]
    drawing.solid(box((0.3, 0.3, 0.3)), GREY)
    drawing.line(0.9 * np.cos(angle) * (1.0, 0, 0) + 0.6 * np.sin(angle) * (0, 0.8, 0.6), both=True)
    drawing.solid(sphere(0.9 * E), BLUE, at=(0.9, 0, 0))
    return drawing


# what a drawing shows better than the solids and arrows that follow from the freedoms
OTHERS = {
    "Constraint": constraint,
    "Rod": rod,
    "Screw": screw,
    "PointOnCurve": point_on_curve,
    "PointOnPath": point_on_path,
    "Rolling": rolling,
    "Drive": drive,
    "Coupler": lambda: gears(rack=False),
    "RackAndPinion": lambda: gears(rack=True),
    "GearPair": gear_pair,
}


def draw(folder: Path = FOLDER) -> None:
    """Write the pictures of all kinds."""
    folder.mkdir(exist_ok=True)
    for kind in joints.KINDS:
        drawing = OTHERS[kind]() if kind in OTHERS else with_markers(kind)
        drawing.save(folder / f"{kind}.png")


if __name__ == "__main__":
    draw()
