"""An arm whose hand follows errors of its own: control in the coordinates of the task.

Problem: bring the hand of an arm of six axes to a place 0.2 m aside and 0.1 m higher, its axes turned by 20 degrees, so
that position and orientation approach their goals like critically damped oscillators, whatever the arm's inertia.

Formula: tau = J^T F + b, F = (J M^-1 J^T)^-1 (a - J' v), a = s^2 e - 2 s J v (Khatib 1987, operational space); e has
the way to the goal and the rotation vector to its axes.
Expected: e'' + 2 s e' + s^2 e = 0 for the place, from rest: e = e_0 (1 + s t) exp(-s t), but for the half millisecond
by which torques that are held between samples lag behind.
"""

import numpy as np
from scipy.spatial.transform import Rotation

import flexmb as fmb

HAND, SPEED, SAMPLE = "link_6.tool", 10.0, 1e-3
JOINTS = [f"joint_{k}" for k in range(1, 7)]
RIGHT = np.pi / 2
#        a (m)  d (m)  alpha   mass  centre of mass (m)    inertia (kg m2)
TABLE = [
    (0.0, 0.0, RIGHT, 10.0, (0, -0.1, 0), (0.2, 0.1, 0.2)),
    (0.45, 0.0, 0.0, 15.0, (-0.2, 0, 0.1), (0.1, 0.4, 0.4)),
    (0.02, 0.15, -RIGHT, 5.0, (0, 0, 0.1), (0.1, 0.1, 0.05)),
    (0.0, 0.45, RIGHT, 1.0, (0, 0.02, 0), (2e-3, 1e-3, 2e-3)),
    (0.0, 0.0, -RIGHT, 0.5, (0, 0, 0), (5e-4, 5e-4, 5e-4)),
    (0.0, 0.1, 0.0, 0.2, (0, 0, -0.05), (2e-4, 2e-4, 2e-4)),
]
START = np.radians([0, 45, 180, 0, 45, 0])


def arm():
    """Return the model, with a motor at every joint whose torque (N m) is an input."""
    links = [
        fmb.StandardLink(a=a, d=d, alpha=alpha, mass=m, center_of_mass=c, inertia=J) for a, d, alpha, m, c, J in TABLE
    ]
    motors = [fmb.Actuator(f"motor_{name}", joint=name, effort=fmb.input(name)) for name in JOINTS]
    return fmb.serial_arm(links, gravity=(0, 0, -9.81)).with_parts(forces=motors)


def torques(tree, q, v, goal, axes):
    """Return the torques (6,), N m, at angles q and rates v, for a goal (3,), m, with axes (3, 3)."""
    r, R = tree.pose(HAND, q)
    J = tree.jacobian(HAND, q)
    error = np.concatenate([goal - r, Rotation.from_matrix(axes @ R.T).as_rotvec()])
    wanted = SPEED**2 * error - 2.0 * SPEED * (J @ v)
    mobility = J @ np.array([tree.mass_solution(q, row) for row in J]).T
    force = np.linalg.solve(mobility, wanted - tree.marker_acceleration(HAND, q, v))
    return J.T @ force + tree.bias(q, v)


def main(t_end=0.5):
    """Return the times (s) and the way that is left (m), computed and by the formula."""
    model = arm()
    tree = fmb.JointTree(model)
    start, R = tree.pose(HAND, START)
    goal = start + (-0.05, 0.2, 0.1)
    axes = Rotation.from_rotvec([0.0, 0.0, np.radians(20.0)]).as_matrix() @ R
    left = []
    with fmb.stepper(model, integrator=fmb.Explicit(), t_end=t_end, start=tree.absolute(START), keep=False) as run:
        while run.t < t_end - 0.5 * SAMPLE:
            here = tree.relative(run.state)
            left.append((run.t, np.linalg.norm(goal - tree.pose(HAND, here.q)[0])))
            run.set(dict(zip(JOINTS, torques(tree, here.q, here.v, goal, axes), strict=True)))
            run.advance(by=SAMPLE)
    t, computed = np.array(left).T
    expected = computed[0] * (1.0 + SPEED * t) * np.exp(-SPEED * t)
    for k in range(0, len(t), 100):
        print(f"t = {t[k]:.1f} s: {1e3 * computed[k]:7.2f} mm left, formula {1e3 * expected[k]:7.2f} mm")
    return t, computed, expected


if __name__ == "__main__":
    main()
