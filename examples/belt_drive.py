"""A flat belt between two pulleys: tensions of its tight and slack side, and its creep.

Problem: the right pulley drives at 60 rad/s, the left one carries a torque of 10 N m. How much slower does it turn?

          slack, T2  <--
        .-----------------.         R = 0.1 m, belt 10 mm thick, EA = 8 kN, 0.83 kg/m,
       (   o           o   )        drawn with 2.5 % strain, friction 0.3
        '-----------------'
     10 N m   --> tight, T1   60 rad/s

Formula: (T1 - T2) r = torque, with the centre line at r = R + 5 mm; the belt creeps over the driver as its tension
falls and over the driven pulley as it rises, so w2 / w1 = v2 / v1 = (1 + T2 / EA) / (1 + T1 / EA) as long as it sticks
somewhere (Euler; Leamy & Wasfy 2002). Friction that is regularised, and a surface that gives way, add what eq.
(belt-creep) says. Expected: T1 = 247 N, T2 = 151 N; a creep of 1.20 % if the belt could stick to rigid pulleys, 1.28 %
with eq. (belt-creep).
"""

import numpy as np

import flexmb as fmb
from flexmb import fem
from flexmb.results import recover

RADIUS, HALF, DISTANCE = 0.1, 0.005, 0.5  # m: pulleys, half the thickness of the belt, axes
EA, LINE_MASS, STRAIN = 8000.0, 0.83, 0.025  # N, kg/m, -
STIFFNESS, FRICTION, TRANSITION = 2e7, 0.3, 0.02  # N/m2, -, m/s
SPEED, TORQUE = 60.0, 10.0  # rad/s, N m


def outline(n=12):
    """Return points (4 n, 3) of the centre line around both pulleys."""
    arc, span = np.linspace(-0.5 * np.pi, 0.5 * np.pi, n + 1), np.linspace(0.5, -0.5, n + 1)[1:-1] * DISTANCE
    r = RADIUS + HALF
    right = np.stack([0.5 * DISTANCE + r * np.cos(arc), r * np.sin(arc)], axis=1)
    xy = np.concatenate([right, np.stack([span, np.full(n - 1, r)], axis=1)])
    return np.column_stack([np.concatenate([xy, -xy]), np.zeros(4 * n)])


def drive(elements):
    """Return the model; the driver starts in 0.1 s, the torque grows in the next 0.1 s."""
    area, inertia = 8e-4, 1.3e-10
    belt = fmb.AncfCable(
        "belt",
        points=outline(),
        closed=True,
        elements=elements,
        straight=True,
        initial_strain=STRAIN,
        section=fem.Section.values(area, inertia, inertia, 2 * inertia),
        axial_damping=1.0,
        material=fmb.Material(young=EA / area, poisson=0.3, density=LINE_MASS / area),
        stretches={"all": (0.0, 1.0)},
    )
    axes = {"driver": 0.5 * DISTANCE, "driven": -0.5 * DISTANCE}
    pulleys = [
        fmb.RigidBody.cylinder(name, radius=RADIUS, length=0.08, density=800.0, at=(x, 0, 0))
        for name, x in axes.items()
    ]
    return fmb.Model(
        bodies=[fmb.Ground(markers={name: (x, 0, 0) for name, x in axes.items()}), belt, *pulleys],
        gravity=(0, 0, 0),
        joints=[
            *(fmb.Revolute(name, markers=(f"ground.{name}", f"{name}.center")) for name in axes),
            fmb.Drive("motor", joint="driver", angle=fmb.ramp(rate=SPEED, rise=0.1)),
        ],
        forces=[
            *(
                fmb.LineContact(
                    f"grip of {name}",
                    stretch="belt.all",
                    marker=f"{name}.center",
                    radius=RADIUS,
                    offset=HALF,
                    stiffness=STIFFNESS,
                    friction=FRICTION,
                    transition=TRANSITION,
                )
                for name in axes
            ),
            fmb.PointLoad("torque", marker="driven.center", moment=(0, 0, fmb.step(-TORQUE, at=0.1, rise=0.1))),
        ],
        sensors=[
            *(fmb.JointCoordinate(name, joint=name) for name in axes),
            fmb.Energy("lost", kind="dissipated"),
            *(fmb.ForceOf(f"belt on {name}", force=f"grip of {name}") for name in axes),
            fmb.SectionForces("tension", body="belt", at=0.0),
        ],
    )


def run(elements, t_end=0.7):
    """Return the solution."""
    step = fmb.GeneralizedAlpha(rho_inf=0.6, rtol=1e-4, largest=5e-4)
    return fmb.simulate(drive(elements), t_end=t_end, samples=round(100 * t_end) + 1, integrator=step)


def tensions(solution):
    """Return the mean tensions of tight and slack side at the end, N."""
    belt, q = solution.model.body("belt"), solution.series().coordinates("belt")[0][-1:]
    places = (np.arange(belt.elements) + 0.5) / belt.elements
    at, force = belt.line(q[0], places)[0], recover.line_forces(belt, q, places)[0, :, 0]
    free = np.abs(at[:, 0]) < 0.4 * DISTANCE
    return tuple(float(force[free & side].mean()) for side in (at[:, 1] < 0.0, at[:, 1] > 0.0))


def main(elements=120):
    """Return the creep 1 - w2 / w1 over the last tenth of a second."""
    solution = run(elements)
    turned = {name: solution[name][-1] - solution[name][-11] for name in ("driver", "driven")}
    tight, slack = tensions(solution)
    print(f"tight side {tight:.1f} N, slack side {slack:.1f} N, difference {tight - slack:.1f} N")
    return 1.0 - turned["driven"] / turned["driver"]


if __name__ == "__main__":
    print(f"creep {100 * main():.3f} % (1.279 % by eq. belt-creep)")
