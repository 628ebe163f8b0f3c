"""A spacecraft of three rigid bodies over ten orbits of the Earth: springs, doubled constraints, an appended panel.

Problem: how accurately do the parts of a spacecraft keep their places relative to each other, over days in orbit?

                        |  |  panel, on a hinge along z                     y
                        |__|                                                |
         .------------.  /                                                  |     springs: F = k x + k3 x^3 + c x',
         |    bus     |o/  \\    rod    .--------.                           o--- x   crossed around the rod
         |            |-----o---------o| module  |
         '------------'-----/    springs'--------'

Procedure (Schutte & Udwadia, Journal of Applied Mechanics 78 (2011) 021018): write down the bodies as if they were
free, each with all its coordinates; add constraints, as they come, dependent ones too; append further bodies by further
constraints. Here the length of the rod is given three times in different words, and the panel is appended to the
complete bus and module by five equations.

The origin of W follows a circular orbit, so coordinates are as small as the spacecraft, and each body gets the
difference of attractions that the fall leaves. The numbers of the paper's spacecraft are not used: these are chosen.
Expected: an independent integration in quaternions with singular mass matrices (tests/examples/test_spacecraft.py).
"""

import time

import numpy as np

import flexmb as fmb

MU, RADIUS = 3.986004418e14, 6.9e6  # m3/s2, m
MEAN_MOTION = float(np.sqrt(MU / RADIUS**3))
ORBIT = 2.0 * np.pi / MEAN_MOTION  # s
TURN = np.array((0.004, -0.006, 0.01))  # rad/s, of the whole at the start
STIFFNESS, CUBIC, DAMPING = 2.0, 400.0, 4.0  # N/m, N/m3, N s/m
ROD = 1.0  # m
#          mass, kg; principal inertia, kg m2; centre of mass at the start, m
BODIES = {
    "bus": (320.0, (90.0, 110.0, 140.0), (0.0, 0.0, 0.0)),
    "module": (80.0, (9.0, 12.0, 15.0), (1.8, 0.0, 0.0)),
    "panel": (30.0, (4.0, 0.5, 4.5), (0.0, 1.2, 0.0)),
}
CORNERS = [(np.cos(a), np.sin(a)) for a in np.radians((90.0, 210.0, 330.0))]
# in the axes of the body, m, from its centre of mass
POINTS = {
    "bus": {
        "rod": (0.5, 0.0, 0.0),
        "hinge": (0.0, 0.5, 0.0),
        "stay": (0.5, 0.5, 0.0),
        **{f"spring {k}": (0.5, 0.45 * y, 0.45 * z) for k, (y, z) in enumerate(CORNERS)},
    },
    "module": {
        "rod": (-0.3, 0.0, 0.0),
        **{f"spring {k}": (-0.3, 0.3 * CORNERS[k - 2][0], 0.3 * CORNERS[k - 2][1]) for k in range(3)},
    },
    "panel": {"hinge": (0.0, -0.7, 0.0), "stay": (0.0, 0.1, 0.0)},
}
# ends, and how much shorter than drawn the spring is without load
SPRINGS = [
    (("bus.spring 0", "module.spring 0"), 0.05),
    (("bus.spring 1", "module.spring 1"), 0.0),
    (("bus.spring 2", "module.spring 2"), -0.02),
    (("bus.stay", "panel.stay"), 0.04),
]


def place(marker):
    """Return where a marker is at the start, m."""
    body, point = marker.split(".")
    return np.add(BODIES[body][2], POINTS[body][point])


def lengths():
    """Return the length of every spring without load, m."""
    return [float(np.linalg.norm(place(b) - place(a))) - shorter for (a, b), shorter in SPRINGS]


def center_of_mass(names):
    """Return the common centre of mass at the start, m."""
    return np.average([BODIES[name][2] for name in names], axis=0, weights=[BODIES[name][0] for name in names])


def free(name, center):
    """Return one body as if it were free, with its attraction and its springs to come."""
    mass, inertia, at = BODIES[name]
    at = np.subtract(at, center)
    markers = {point: fmb.Pose(xyz) for point, xyz in POINTS[name].items()}
    body = fmb.RigidBody(
        name,
        mass=mass,
        inertia=inertia,
        at=at,
        velocity=np.cross(TURN, at),
        angular_velocity=TURN,
        markers=markers,
    )
    return body, fmb.CentralGravity(f"Earth on {name}", body=name, mu=MU)


def rod():
    """Return the length of the rod, three times in different words: as a joint and as two equations."""
    ends = ("bus.rod", "module.rod")
    d = fmb.Distance("d", markers=ends)
    return [
        fmb.Rod("rod", markers=ends),
        fmb.Constraint("the same length", over=[d], equation="d**2 = L**2", parameters={"L": ROD}),
        fmb.Constraint("the same in disguise", over=[d], equation="(d/L)**3 + log(d/L) = 1", parameters={"L": ROD}),
    ]


def appended_panel():
    """Return the five equations that append the panel: a common point, and a common axis z."""
    ends = ("bus.hinge", "panel.hinge")
    at = [fmb.Position(name, marker=marker) for name, marker in zip("ab", ends, strict=True)]
    found = [fmb.Constraint(f"hinge {x}", over=at, equation=f"a[{k}] = b[{k}]") for k, x in enumerate("xyz")]
    for axis in "xy":
        cosine = fmb.AxisCosine("c", markers=ends, axes=(axis, "z"))
        found.append(fmb.Constraint(f"axis {axis}", over=[cosine], equation="c = 0"))
    return found


def springs(names):
    """Return the springs between these bodies."""
    found = []
    for k, ((ends, _), length) in enumerate(zip(SPRINGS, lengths(), strict=True)):
        if all(end.split(".")[0] in names for end in ends):
            law = {"stiffness": STIFFNESS, "cubic": CUBIC, "damping": DAMPING, "length": length}
            found.append(fmb.SpringDamper(f"spring {k}", markers=ends, **law))
    return found


def spacecraft(panel=True):
    """Return the model; without its panel it is complete too."""
    names = list(BODIES) if panel else ["bus", "module"]
    bodies, attraction = zip(*(free(name, center_of_mass(names)) for name in names), strict=True)
    return fmb.Model(
        name="spacecraft",
        bodies=[fmb.Ground(), *bodies],
        origin=fmb.Orbit.circular(RADIUS, mu=MU),
        joints=rod() + (appended_panel() if panel else []),
        forces=[*attraction, *springs(names)],
        sensors=[
            *(fmb.Position(name, marker=f"{name}.center") for name in names),
            *(fmb.Orientation(f"axes of {name}", marker=f"{name}.center") for name in names),
            fmb.Momentum("momentum"),
            fmb.Energy("energy"),
            fmb.Energy("work", kind="work_of_loads"),
            fmb.Energy("dissipated", kind="dissipated"),
            fmb.ConstraintError("open"),
            fmb.ConstraintError("opening", level="velocity"),
        ],
    )


def run(orbits, samples=201, integrator=None, panel=True):
    """Return the motion and the time it took per orbit, s."""
    model = spacecraft(panel)
    began = time.perf_counter()
    motion = fmb.simulate(model, orbits * ORBIT, samples=samples, integrator=integrator)
    return motion, (time.perf_counter() - began) / orbits


def balance(motion):
    """Return the largest error of energy, J, and of angular momentum about the Earth's centre, N m s.

    The energy grows by the work of the Earth, less what the springs take. The share of the orbit itself in the angular
    momentum, sum m (R x V), is left out: it is a million million times larger.
    """
    energy = motion["energy"] - motion["energy"][0] - motion["work"] + motion["dissipated"]
    names = [body.name for body in motion.model.bodies if body.name in BODIES]
    moment = sum(BODIES[name][0] * motion[name] for name in names)
    c, s, none = np.cos(MEAN_MOTION * motion.t), np.sin(MEAN_MOTION * motion.t), 0.0 * motion.t
    R, V = RADIUS * np.stack([c, s, none], 1), RADIUS * MEAN_MOTION * np.stack([-s, c, none], 1)
    total = motion["momentum"][:, 3:] + np.cross(R, motion["momentum"][:, :3]) + np.cross(moment, V)
    return np.abs(energy).max(), np.abs(total - total[0]).max()


def main(orbits=10):
    """Print what holds over the orbits; return the largest opening of a constraint, m."""
    motion, seconds = run(orbits)
    energy, turning = balance(motion)
    apart = np.linalg.norm(motion["module"] - motion["bus"], axis=1)
    print(f"{orbits} orbits of {ORBIT:.0f} s, {seconds:.2f} s of computing for each")
    print(f"module {apart.min():.4f} to {apart.max():.4f} m from the bus")
    print(f"balance of energy within {energy:.1e} J of {motion['energy'][0]:.4f} J")
    print(f"balance of angular momentum within {turning:.1e} N m s")
    print(f"constraints open by {motion['open'].max():.1e} m, opening by {motion['opening'].max():.1e} m/s")
    return motion["open"].max()


if __name__ == "__main__":
    main()
