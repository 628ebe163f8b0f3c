"""Mechanisms of the reference cases, as models of the package."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import flexmb as fmb


def four_bars(n: int) -> fmb.Model:
    """RB02: n + 1 upright cranks of 1 m and n couplers, all revolute joints in space (redundant)."""
    cranks = [
        fmb.RigidBody.rod(
            f"c{k}",
            length=1.0,
            mass=1.0,
            radius=0.01,
            at=(k, 0, 0),
            rotation=(0, 0, np.pi / 2),
            angular_velocity=(0, 0, -1.0),
        )
        for k in range(n + 1)
    ]
    bars = [
        fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.01, at=(k, 1, 0), velocity=(1, 0, 0))
        for k in range(n)
    ]
    ground = fmb.Ground(markers={f"A{k}": (k, 0, 0) for k in range(n + 1)})
    joints = [fmb.Revolute(f"g{k}", markers=(f"ground.A{k}", f"c{k}.start")) for k in range(n + 1)]
    for k in range(n):
        joints.append(fmb.Revolute(f"l{k}", markers=(f"c{k}.end", f"b{k}.start")))
        joints.append(fmb.Revolute(f"r{k}", markers=(f"b{k}.end", f"c{k + 1}.end")))
    sensors = [fmb.Position("B0", marker="c0.end"), fmb.Energy("energy"), fmb.ConstraintError("error")]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[ground, *cranks, *bars], joints=joints, sensors=sensors)


def four_bar_places(n: int, t: float) -> np.ndarray:
    """Return the origins of the bodies of `four_bars` at a time (2 n + 1, 3): one freedom, J a = g S sin(a)."""
    J, S = (n + 1) * (1 / 3 + 0.01**2 / 4) + n, 9.81 * ((n + 1) / 2 + n)
    motion = solve_ivp(
        lambda t, y: (y[1], S / J * np.sin(y[0])), (0, t), (0.0, 1.0), method="DOP853", rtol=1e-13, atol=1e-13
    )
    a = motion.y[0, -1]
    cranks = [(k, 0.0, 0.0) for k in range(n + 1)]
    return np.array([*cranks, *((k + np.sin(a), np.cos(a), 0.0) for k in range(n))])


def andrews(case: dict) -> fmb.Model:
    """RB03: the seven bodies at their centres of mass, ten revolute joints (nine equations are redundant)."""
    p = case["model"]
    b, T, G, F, D, O, E = case["initial_conditions"]["q0"]
    angle = np.array([b, b + T, G, F + D, D, O + E, E])

    def turned(x, y, a):
        return np.array([x * np.cos(a) - y * np.sin(a), x * np.sin(a) + y * np.cos(a)])

    A, B, C = ((p[f"x{k}"], p[f"y{k}"]) for k in "abc")
    centre = [
        turned(p["ra"], 0, b),
        turned(p["rr"], 0, b) - turned(p["da"], 0, b + T),
        B + turned(p["sb"], -p["sa"], G),
        A + turned(p["zt"], 0, D) + turned(0, p["ea"] - p["e"], F + D),
        A + turned(p["ta"], p["tb"], D),
        A + turned(0, -p["u"], E) + turned(p["zf"] - p["fa"], 0, O + E),
        A + turned(-p["ub"], -p["ua"], E),
    ]
    K, P = turned(p["rr"], 0, b), turned(p["rr"], 0, b) - turned(p["d"], 0, b + T)
    H4, H6 = A + turned(p["zt"], 0, D), A + turned(0, -p["u"], E)
    spring = B + turned(p["sd"], -p["sc"], G)
    places = [
        {"O": (0, 0), "K": K},
        {"K": K, "P": P},
        {"B": B, "P": P, "D": spring},
        {"H4": H4, "P": P},
        {"A": A, "H4": H4},
        {"H6": H6, "P": P},
        {"A": A, "H6": H6},
    ]
    bodies = [fmb.Ground(markers={"O": (0, 0, 0), "A": (*A, 0), "B": (*B, 0), "C": (*C, 0)})]
    for k in range(7):
        markers = {name: (*turned(*(np.array(at) - centre[k]), -angle[k]), 0) for name, at in places[k].items()}
        I = p[f"I{k + 1}"]
        bodies.append(
            fmb.RigidBody(
                f"k{k + 1}",
                mass=p[f"m{k + 1}"],
                inertia=(I / 2, I / 2, I),
                at=(*centre[k], 0),
                rotation=(0, 0, angle[k]),
                markers=markers,
            )
        )
    joints = [
        fmb.Revolute("O", markers=("ground.O", "k1.O")),
        fmb.Revolute("K", markers=("k1.K", "k2.K")),
        fmb.Revolute("B", markers=("ground.B", "k3.B")),
        fmb.Revolute("H4", markers=("k5.H4", "k4.H4")),
        fmb.Revolute("A5", markers=("ground.A", "k5.A")),
        fmb.Revolute("H6", markers=("k7.H6", "k6.H6")),
        fmb.Revolute("A7", markers=("ground.A", "k7.A")),
    ]
    joints += [fmb.Revolute(f"P{k}", markers=("k2.P", f"k{k}.P")) for k in (3, 4, 6)]
    forces = [
        fmb.SpringDamper("spring", markers=("ground.C", "k3.D"), stiffness=p["c0"], length=p["l0"]),
        fmb.PointLoad("motor", marker="k1.center", moment=(0, 0, p["mom"])),
    ]
    order = ("O", "K", "B", "H4", "A5", "H6", "A7")
    sensors = [
        *(fmb.JointCoordinate(f"angle {name}", joint=name) for name in order),
        *(fmb.Reaction(f"force P{k}", joint=f"P{k}") for k in (3, 4, 6)),
    ]
    return fmb.Model(bodies=bodies, joints=joints, forces=forces, sensors=sensors)


def along(axis: str, at) -> fmb.Pose:
    """Return a marker whose z-axis is the named axis of its parent."""
    x, z = {"x": ((0, 1, 0), (1, 0, 0)), "y": ((0, 0, 1), (0, 1, 0)), "z": ((1, 0, 0), (0, 0, 1))}[axis]
    return fmb.Pose.axes(tuple(at), x=x, z=z)


def bricard(case: dict) -> fmb.Model:
    """RB04: five bars and six revolute joints whose axes follow the edges of a cube."""
    points, axes = np.array(case["model"]["points"], float), "yzxyzx"
    bodies = [fmb.Ground(markers={"j0": along("y", points[0]), "j5": along("x", points[5])})]
    for k in range(5):
        centre, edge = 0.5 * (points[k] + points[k + 1]), np.abs(points[k + 1] - points[k])
        inertia = np.where(edge > 0.5, 0.01 / 6.0, 1.01 / 12.0)
        markers = {"start": along(axes[k], points[k] - centre), "end": along(axes[k + 1], points[k + 1] - centre)}
        bodies.append(fmb.RigidBody(f"b{k}", mass=1.0, inertia=inertia, at=centre, markers=markers))
    joints = [fmb.Revolute("j0", markers=("ground.j0", "b0.start"))]
    joints += [fmb.Revolute(f"j{k}", markers=(f"b{k - 1}.end", f"b{k}.start")) for k in range(1, 5)]
    joints += [fmb.Revolute("j5", markers=("b4.end", "ground.j5"))]
    sensors = [fmb.Position("P3", marker="b2.end"), fmb.Energy("energy")]
    return fmb.Model(gravity=case["model"]["gravity"], bodies=bodies, joints=joints, sensors=sensors)


def towing_chain(case: dict) -> fmb.Model:
    """RB13: six links; the moving end hangs on a light cart that is driven along a rail."""
    length, mass = case["model"]["L"], case["model"]["m"]
    angles = np.radians([-60.0] * 3 + [60.0] * 3)
    points = np.zeros((7, 3))
    points[1:, :2] = length * np.cumsum(np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
    links = [
        fmb.RigidBody.rod(f"l{k}", length=length, mass=mass, radius=1e-3, at=points[k], rotation=(0, 0, angles[k]))
        for k in range(6)
    ]
    cart = fmb.RigidBody(
        "cart", mass=1e-3, inertia=(1e-6,) * 3, at=points[6], markers={"rail": along("x", (0, 0, 0)), "pin": (0, 0, 0)}
    )
    names = ["ground.origin"] + [f"l{k}.end" for k in range(6)]
    joints = [fmb.Revolute(f"j{k}", markers=(names[k], f"l{k}.start")) for k in range(6)]
    tow = fmb.expression(f"0.9144 + 0.5*{case['model']['a_end']}*t**2")
    joints += [
        fmb.Revolute("tip", markers=("l5.end", "cart.pin")),
        fmb.Prismatic("rail", markers=("ground.rail", "cart.rail")),
        fmb.Drive("tow", joint="rail", displacement=tow),
    ]
    sensors = [*(fmb.Position(f"p{k}", marker=f"l{k}.end") for k in range(6)), fmb.Reaction("pull", joint="tip")]
    ground = fmb.Ground(markers={"rail": along("x", (0, 0, 0))})
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[ground, *links, cart], joints=joints, sensors=sensors)


def door(case: dict, heights) -> fmb.Model:
    """RC01: a plate on coaxial horizontal hinges at the given places along the axis y."""
    mass, a, b = (case["model"][k] for k in ("m", "width", "height"))
    markers = {f"h{k}": along("y", (0, y, 0)) for k, y in enumerate(heights)}
    plate = fmb.RigidBody(
        "door",
        mass=mass,
        inertia=mass / 12 * np.array([b * b, a * a, a * a + b * b]),
        center_of_mass=(a / 2, 0, 0),
        markers=markers,
    )
    joints = [fmb.Revolute(name, markers=(f"ground.{name}", f"door.{name}")) for name in markers]
    sensors = [
        fmb.JointCoordinate("turn", joint="h0"),
        *(fmb.Reaction(f"force {name}", joint=name) for name in markers),
    ]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(markers=markers), plate], joints=joints, sensors=sensors)


def car_axis(case: dict) -> fmb.Model:
    """DAE1: the base is a driven bar, the left wheel slides on it, the right wheel hangs on a rod;
    springs to the base.
    """
    mass = 10 * 0.01**2 / 2
    spin = (0, 0, 1.0)
    base = fmb.RigidBody(
        "base",
        mass=1.0,
        inertia=(1, 1, 1),
        angular_velocity=spin,
        markers={"pin": (0, 0, 0), "end": (1, 0, 0), "rail": along("y", (0, 0, 0))},
    )
    left = fmb.RigidBody(
        "left",
        mass=mass,
        inertia=(1e-6,) * 3,
        at=(0, 0.5, 0),
        velocity=(-0.5, 0, 0),
        angular_velocity=spin,
        markers={"rail": along("y", (0, 0, 0))},
    )
    right = fmb.PointMass("right", mass=mass, at=(1, 0.5, 0), velocity=(-0.5, 0, 0))
    joints = [
        fmb.Revolute("pin", markers=("ground.origin", "base.pin")),
        fmb.Drive("sway", joint="pin", angle=fmb.expression("asin(0.1*sin(10*t))")),
        fmb.Prismatic("rail", markers=("base.rail", "left.rail")),
        fmb.Rod("axle", markers=("left.center", "right.center"), length=1.0),
    ]
    forces = [
        fmb.SpringDamper("left spring", markers=("ground.origin", "left.center"), stiffness=1.0, length=0.5),
        fmb.SpringDamper("right spring", markers=("base.end", "right.center"), stiffness=1.0, length=0.5),
    ]
    sensors = [
        *(fmb.Position(f"p {b}", marker=f"{b}.center") for b in ("left", "right")),
        *(fmb.Velocity(f"v {b}", marker=f"{b}.center") for b in ("left", "right")),
        fmb.Reaction("rail force", joint="rail"),
        fmb.Reaction("axle force", joint="axle"),
    ]
    return fmb.Model(
        gravity=(0, -1.0, 0), bodies=[fmb.Ground(), base, left, right], joints=joints, forces=forces, sensors=sensors
    )
