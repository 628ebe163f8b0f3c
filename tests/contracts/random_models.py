"""Small random models for the contracts: every registered kind between bodies of every kind, at random states."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from contracts.every_kind import required

import flexmb as fmb
from flexmb import bodies, fem, forces, joints, reduction
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.pose import Pose
from flexmb.system import assemble, compile
from flexmb.system.program import advance

PAIRS = (
    "ground-rigid",
    "rigid-rigid",
    "floating-ground",
    "rigid-floating",
    "floating-floating",
    "rigid-point",
    "rigid-cable",
    "rigid-beam",
    "rigid-plate",
)
"""Which bodies carry marker a and marker b."""

STENCIL = {-3: -1 / 60, -2: 9 / 60, -1: -45 / 60, 1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
"""First derivative by central differences of sixth order."""
SECOND = {-3: 2 / 180, -2: -27 / 180, -1: 270 / 180, 0: -490 / 180, 1: 270 / 180, 2: -27 / 180, 3: 2 / 180}
"""Second derivative, sixth order."""
FOURTH_ORDER = (
    {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12},
    {-2: -1 / 12, -1: 16 / 12, 0: -30 / 12, 1: 16 / 12, 2: -1 / 12},
)
"""Both by fourth order from the same points: what differs is an upper bound of the sixth order's own error."""

MARKER = {
    "ground": "ground.m",
    "rigid": "{}.m",
    "floating": "{}.tip",
    "point": "{}.center",
    "cable": "{}.m",
    "beam": "{}.m",
    "plate": "{}.m",
}
BESIDE = {"n1": (0.9, 0.1, 0.2), "n2": (1.7, -0.2, 0.3), "n3": (2.6, 0.1, -0.1)}
"""Further markers of ground and rigid bodies, for paths."""
ENDS = ("{}.end", "{}.start")
PATHS = {
    "floating": ("{}.mid", "{}.root"),
    "cable": ENDS,
    "beam": ENDS,
    "plate": ("{}.corner_11", "{}.corner_01"),
}
"""Through which markers a path goes on from the body's marker."""
FORCE_FIELDS = {
    "SpringDamper": {
        "stiffness": 300.0,
        "damping": 7.0,
        "cubic": 900.0,
        "length": 0.4,
        "preload": fmb.expression("5*sin(3*t)"),
    },
    "PointLoad": {
        "force": (3.0, fmb.expression("2 + t**2"), -1.0),
        "moment": (0.3, -0.2, fmb.expression("t")),
    },
    "TorsionSpring": {"stiffness": 30.0, "damping": 2.0, "free_angle": 0.4},
    "Motor": {"target": fmb.expression("sin(3*t)"), "stiffness": 40.0, "damping": 3.0, "freedom": "slide"},
    "Actuator": {
        "effort": fmb.table([-9, 0, 4, 9], [-3, 1, 7, 2], of="j") * fmb.expression("2 + sin(3*t)"),
        "freedom": "slide",
        "limits": (-40.0, 90.0),
    },
    "JointFriction": {
        "moving": 0.2,
        "standing": 0.3,
        "stribeck": 3.0,
        "transition": 4.0,
        "preload": 5.0,
        "radius": 0.3,
    },
    "DcMotor": {
        "voltage": fmb.expression("5*sin(3*t)"),
        "resistance": 2.0,
        "inductance": 0.5,
        "constant": 3.0,
        "ratio": -4.0,
        "freedom": "slide",
    },
    "HydraulicCylinder": {
        "valve": fmb.expression("0.5 + 0.2*sin(3*t)"),
        "areas": (3.0, 2.0),
        "stroke": 40.0,
        "retracted": -20.0,
        "dead_volume": 20.0,
        "supply": 5.0,
        "tank": 0.5,
        "rated_flow": 2.0,
        "rated_drop": 3.0,
        "bulk": 100.0,
        "leakage": 0.2,
        "transition": 2.0,
    },
    "MaxwellDamper": {"branches": ((300.0, 0.5), (200.0, 2.0)), "stiffness": 100.0, "length": 0.4},
    "LuGre": {
        "stiffness": 30.0,
        "damping": 3.0,
        "viscous": 0.5,
        "moving": 20.0,
        "standing": 30.0,
        "stribeck": 2.0,
        "freedom": "slide",
    },
    "Contact": {
        "radius": 4.0,
        "against": "sphere",
        "other_radius": 5.0,
        "stiffness": 3.0,
        "damping": 0.01,
        "friction": 0.3,
        "transition": 3.0,
    },
    "SurfaceContact": {
        "law": fmb.Hertz(stiffness=3.0, damping=0.01, friction=0.3, transition=3.0),
        "surfaces": ("first", "second"),
    },
    "CamFollower": {
        "profile": fmb.Disc(radius=5.0),
        "roller": 4.0,
        "stiffness": 3.0,
        "exponent": 1.5,
        "damping": 0.01,
        "friction": 0.3,
        "transition": 3.0,
    },
    "UserForce": {"function": lambda t, d, v, R, w: (-30.0 * d - 2.0 * v, -4.0 * (R[:, 0] - R[0]) - 0.3 * w)},
    # the contact laws at overlaps where they are smooth
    "BiStop": {
        "length": 0.01,
        "travel": (-0.01, 0.0),
        "stiffness": 300.0,
        "exponent": 1.5,
        "damping": 3.0,
        "depth": 9.0,
    },
    "OneSidedSpring": {"length": 9.0, "backlash": 0.1, "stiffness": 30.0, "damping": 3.0, "depth": 20.0},
    "Bushing": {
        "stiffness": np.diag((300.0, 200.0, 100.0, 30.0, 20.0, 10.0)) + 5.0,
        "damping": (3.0, 2.0, 1.0, 0.3, 0.2, 0.1),
    },
}
"""Fields of forces beyond name and markers, where values by the names of required fields would not do."""
OF_NO_PAIR = (
    "Airload",
    "Pressure",
    "LineLoad",
    "LineContact",
    "Gears",
    "Muscle",
    "CentralGravity",
    "OblateGravity",
    "SolarPressure",
    "ThinDrag",
    "ThirdBody",
    "SkinContact",
)
FORCES = [name for name in forces.KINDS if name not in OF_NO_PAIR]


@cache
def beam() -> fmb.ModalNeutralData:
    """A slender steel frame in space, reduced, with geometric stiffness: soft enough to bend visibly."""
    points = np.column_stack([np.linspace(0.0, 1.0, 6), [0.0, 0.02, 0.03, 0.03, 0.02, 0.0], np.zeros(6)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.01), material=fmb.MATERIALS["steel"])
    return reduction.reduce(
        fe,
        interfaces={"root": [0], "tip": [5]},
        modes=3,
        stations={"mid": (0.4, 0.03, 0.0)},
        geometric_stiffness=True,
    )


def _pose(rng) -> Pose:
    return Pose(tuple(rng.normal(size=3) * 0.3), rng.normal(size=3))


def body(kind: str, name: str, rng, spread: float = 0.3):
    """Return a body of a kind with random properties, pose and twist, and its marker's name."""
    moving = {"at": rng.normal(size=3) * spread, "velocity": rng.normal(size=3)}
    turning = {"rotation": rng.normal(size=3), "angular_velocity": rng.normal(size=3)}
    marker = MARKER[kind].format(name)
    if kind == "ground":
        return fmb.Ground(markers={"m": _pose(rng), **BESIDE}), marker
    if kind == "point":
        return fmb.PointMass(name, mass=rng.uniform(1, 2), **moving), marker
    if kind == "floating":
        return fmb.FloatingBody(name, data=beam(), damping=0.02, **moving, **turning), marker
    if kind in ("cable", "beam"):
        return line(kind, name, rng, **moving, **turning), marker
    if kind == "plate":
        return plate(name, rng, **moving, **turning), marker
    A = rng.normal(size=(3, 3))
    J = A @ A.T + np.eye(3)
    inertia = 0.1 * (np.trace(J) * np.eye(3) - J)
    return fmb.RigidBody(
        name,
        mass=rng.uniform(1, 2),
        inertia=inertia,
        center_of_mass=rng.normal(size=3) * 0.2,
        markers={"m": _pose(rng), **BESIDE},
        **moving,
        **turning,
    ), marker


def line(kind: str, name: str, rng, **fields) -> fmb.AncfCable | fmb.AncfBeam:
    """Return a soft, bent, damped cable or beam of two elements with a turned marker inside the second."""
    soft = fmb.Material(young=2e3, poisson=0.3, density=80.0)
    damping = {"axial_damping": 0.5} if kind == "cable" else {"damping": 0.01}
    return {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}[kind](
        name,
        points=((0, 0, 0), (2, 0.4, 0), (4, 0, 0.5)),
        tangents=((1, 0.6, -0.1), (1, -0.7, 0.4)),
        elements=2,
        section=fem.Section.solid_circle(0.2),
        material=soft,
        initial_strain=0.02,
        straight=True,
        markers={"m": (0.7, rng.normal(size=3))},
        **damping,
        **fields,
    )


def plate(name: str, rng, **fields) -> fmb.AncfPlate:
    """Return a soft, bent, damped thin plate of two elements with a turned marker inside the second."""
    points = [[(x, y, 0.2 * x * x + 0.1 * x * y) for y in (0.0, 0.8)] for x in (0.0, 1.0, 2.0)]
    return fmb.AncfPlate(
        name,
        points=points,
        thickness=0.05,
        material=fmb.Material(young=8e3, poisson=0.3, density=300.0),
        initial_strain=0.02,
        damping=0.01,
        markers={"m": ((0.7, 0.4), rng.normal(size=3))},
        **fields,
    )


def pair(kinds: str, rng):
    """Return two bodies (and the ground) and the names of their markers."""
    a, b = kinds.split("-")
    (body_a, marker_a), (body_b, marker_b) = body(a, "a", rng), body(b, "b", rng)
    ground = () if "ground" in (a, b) else (fmb.Ground(markers={"m": _pose(rng)}),)
    return (*ground, body_a, body_b), (marker_a, marker_b)


def joint_parts(kind: str, markers, rng, of: str = "rigid") -> tuple:
    """Return the joints that make one joint of a kind between two markers (a drive needs a joint to drive).

    `of` is the kind of the first marker's body.
    """
    if kind == "Drive":
        turn = fmb.expression("0.3 + 0.7*t + 0.2*t**2")
        return joints.Cylindrical("j", markers=markers), joints.Drive("drive", joint="j", angle=turn)
    if kind == "Rod":
        return (joints.Rod("j", markers=markers, length=0.7),)
    if kind == "Screw":
        return (joints.Screw("j", markers=markers, pitch=0.3),)
    if kind == "PointOnCurve":
        curve = [(0.5 * x, 0.2 * np.sin(x), 0.1 * x * x) for x in (-6.0, -2.0, 2.0, 6.0)]
        return (joints.PointOnCurve("j", markers=markers, curve=curve),)
    if kind == "PointOnPath":
        carrier = markers[0].split(".")[0]
        further = PATHS.get(of, tuple(f"{{}}.{name}" for name in BESIDE))
        return (joints.PointOnPath("j", markers=markers, through=tuple(m.format(carrier) for m in further)),)
    if kind == "Rolling":
        return (joints.Rolling("j", markers=markers, radius=0.4),)
    if kind == "Constraint":
        over = [
            fmb.Distance("d", markers=markers),
            fmb.Distance("s", markers=markers, along="z"),
            fmb.AxisCosine("c", markers=markers, axes=("x", "x")),
            fmb.JointCoordinate("phi", joint="j", freedom="turn"),
        ]
        equation = "d + 0.2*c*d + 0.1*sin(phi)*s = 0.7"
        return joints.Cylindrical("j", markers=markers), joints.Constraint("own", over=over, equation=equation)
    if kind == "GearPair":
        return (joints.GearPair("j", markers=markers, radii=(0.7, 0.2), inside=True),)
    if kind in ("Coupler", "RackAndPinion"):
        fields = {"ratio": 0.4, "freedoms": ("slide", "turn")} if kind == "Coupler" else {"radius": 0.2}
        return joints.Cylindrical("j", markers=markers), joints.KINDS[kind]("c", joints=("j", "j"), **fields)
    own = joints.KINDS[kind]
    return (own("j", markers=markers, **required(own, ("name", "markers"))),)


def slide_drive(markers) -> tuple:
    """Return a cylindrical joint with a driven slide."""
    slide = fmb.expression("0.1 - 0.4*t + 0.3*t**2")
    return joints.Cylindrical("j", markers=markers), joints.Drive("drive", joint="j", displacement=slide)


def force_parts(kind: str, markers, rng) -> tuple:
    """Return the force of a kind between two markers, or on the second one in the axes of the first."""
    own = forces.KINDS[kind].__dataclass_fields__
    names = {"joint": "j"} if "joint" in own else {"marker": markers[1], "axes": markers[0]}
    names = {"markers": markers} if "markers" in own else {k: v for k, v in names.items() if k in own}
    fields = FORCE_FIELDS[kind] if kind in FORCE_FIELDS else required(forces.KINDS[kind], ("name", *names))
    return (forces.KINDS[kind]("f", **names, **fields),)


def drawn(members, markers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where the second marker is from the first in its axes, m, and the axes of both, (3, 3), as described."""
    system = compile(fmb.Model(bodies=members))
    a, b = (system.tables["markers"][system.marker_index[m]] for m in markers)
    return a["R"].T @ (b["r"] - a["r"]), a["R"], b["R"]


def is_drawable(kind: str, members, markers) -> bool:
    """Tell whether a part of a kind can be between these markers: not where its equations have no answer.

    The rotation vector of a bushing jumps at half a turn; a wheel is drawn over its plane and does not lie flat.
    """
    if kind == "Bushing":
        _, R_a, R_b = drawn(members, markers)
        return np.arccos(np.clip(0.5 * (np.trace(R_a.T @ R_b) - 1.0), -1.0, 1.0)) <= 2.5
    if kind == "Rolling":
        d, R_a, R_b = drawn(members, markers)
        return d[2] > 0.0 and abs(R_a[:, 2] @ R_b[:, 2]) < 0.9
    return True


def connected(kind: str, kinds: str, rng) -> fmb.Model:
    """Return a random model in which a joint or force of `kind` connects bodies of `kinds`; gravity acts."""
    members, markers = pair(kinds, rng)
    while not is_drawable(kind, members, markers):
        members, markers = pair(kinds, rng)
    parts = {"joints": ()} | (
        {"joints": joint_parts(kind, markers, rng, kinds.split("-")[0])} if kind in joints.KINDS else {}
    )
    if kind in forces.KINDS:
        parts["forces"] = force_parts(kind, markers, rng)
        if getattr(parts["forces"][0], "joint", None):
            parts["joints"] = (joints.Cylindrical("j", markers=markers),)
    if kind == "SurfaceContact":
        balls = zip(("first", "second"), markers, (5.0, 4.0))
        parts["surfaces"] = [fmb.Surface(name, marker=m, shape=fmb.Sphere(r)) for name, m, r in balls]
    if kind == "slide":
        parts["joints"] = slide_drive(markers)
    return fmb.Model(bodies=members, gravity=tuple(rng.normal(size=3) * 9.0), **parts)


def single(kind: str, rng) -> fmb.Model:
    """Return one free body of a registered kind under gravity."""
    name = {
        bodies.RigidBody: "rigid",
        bodies.PointMass: "point",
        bodies.FloatingBody: "floating",
        bodies.AncfCable: "cable",
        bodies.AncfBeam: "beam",
        bodies.AncfPlate: "plate",
    }.get(bodies.KINDS[kind])
    own = bodies.KINDS[kind]
    part = own("b", **required(own, ("name",))) if name is None else body(name, "b", rng)[0]
    return fmb.Model(bodies=(fmb.Ground(), part), gravity=tuple(rng.normal(size=3) * 9.0))


def put_together(model: fmb.Model, t: float = 0.0) -> fmb.Model:
    """Return the model with its rigid and reduced bodies described where assembly puts them at a time t, s.

    Bodies move in the metric of their masses. Cables, beams and plates would be deformed by more than their lengths, so
    rigid bodies go to them: they have next to no mass here.
    """
    light, deforms = model, any(body.n_velocities and not body.has_frame for body in model.bodies)
    for body in model.bodies:
        if deforms and isinstance(body, fmb.RigidBody):
            light = light.changed(body.name, mass=1e-8 * body.mass, inertia=1e-8 * body.inertia)
    system, state = assemble(light, t=t)
    placed = []
    for body in model.bodies:
        if body.n_velocities and body.has_frame:
            q, R = state.q[system.body_slices[body.name][0]], np.empty((3, 3))
            euler_to_matrix(q[3:7], R)
            body = body.replaced(at=tuple(q[:3]), rotation=R)
        placed.append(body)
    return replace(model, bodies=placed)


def units(system, strain: float = 1e-3) -> np.ndarray:
    """Return the size of a moderate increment of every velocity: 1 for motion at large, `strain` for deformation."""
    size = np.ones(system.nu)
    for _, iu, count, flexible in system.program.vectors:
        if flexible:
            size[iu : iu + count] = strain
    return size


def randomise(system, state, rng, strain: float = 1e-3):
    """Return the state with random flexible coordinates, velocities, accelerations and multipliers."""
    size = units(system)
    q, u, a = state.q.copy(), size * rng.normal(size=system.nu), size * rng.normal(size=system.nu)
    for iq, _, count, flexible in system.program.vectors:
        if flexible:
            q[iq : iq + count] = strain * rng.normal(size=count)
    return system.state(0.37, q, u, a, 3.0 * rng.normal(size=system.ng))


def random_state(model, rng, strain: float = 1e-3):
    """Return the compiled (not assembled) system at a random state."""
    system = compile(model)
    return system, randomise(system, system.state(), rng, strain)


def moved(system, state, d, h: float, **changes):
    """Return the state at q [+] h d with the other changes."""
    q = np.empty(system.nq)
    advance(system.program, state.q, np.asarray(d, float), h, q)
    values = {"t": state.t, "u": state.u, "a": state.a, "lam": state.lam} | changes
    return system.state(q=q, **values)


def derivative(f, h: float, stencil=STENCIL):
    """Return the derivative of f(x) at 0 by central differences of sixth order.

    The step is halved where the function bends too much for it (a screw far from its axis, wheels near the centre):
    until sixth and fourth order agree to 1e-8, or, where rounding forbids that, to where they agree best.
    """
    order, lower = (2, FOURTH_ORDER[1]) if stencil is SECOND else (1, FOURTH_ORDER[0])
    best, least = None, None
    for _ in range(5):
        values = {k: f(k * h) for k in stencil}
        found = sum(weight * values[k] for k, weight in stencil.items()) / h**order
        error = np.abs(found - sum(weight * values[k] for k, weight in lower.items()) / h**order)
        best = found if best is None else np.where(error < least, found, best)
        least = error if least is None else np.minimum(error, least)
        if np.all(least <= 1e-8 * (1.0 + np.abs(best))):
            break
        h *= 0.5
    return best
