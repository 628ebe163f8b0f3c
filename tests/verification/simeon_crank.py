"""The flexible slider-crank of Simeon (1996): rod with two sine modes across and one quadratic bar element along.

The shape functions on 0 <= s = x / L <= 1 are sin(pi s), sin(2 pi s) across, 4 s (1 - s) and s (2 s - 1) along; the
body frame goes through both pins. Only given integrals enter, so the body is ordinary modal neutral data.
"""

import numpy as np

import flexmb as fmb
from flexmb.constraints import InPlane
from flexmb.model.kinds import Joint
from flexmb.model.modal_arrays import InertiaInvariants
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.results import Instant

CRANK, ROD, OMEGA = 0.15, 0.3, 150.0
MASS, INERTIA, SLIDER = 0.151104, 0.0045339259, 0.075552
YOUNG, SIDE = 2e11, 0.008


class OnLine(Joint):
    """Hold marker b at y = 0 of marker a; the rod keeps the slider in the plane."""

    forbids = (InPlane("y"),)


def rod_data(bar_mass):
    """Return the rod; `bar_mass` (2, 2) is its longitudinal mass block relative to the mass."""
    pi = np.pi
    modes = np.zeros((4, 4))
    modes[:2, :2] = 0.5 * np.eye(2)
    modes[2:, 2:] = bar_mass
    across, along = np.array([2 / pi, 0, 0, 0]), np.array([0, 0, 2 / 3, 1 / 6])  # int N ds
    levers = np.array([1 / pi, -1 / (2 * pi), 0, 0]), np.array([0, 0, 1 / 3, 1 / 6])  # int s N ds, across and along
    spin = np.zeros((4, 4))  # int (along of j times across of k) ds
    spin[2, 0], spin[3, 0], spin[3, 1] = 16 / pi**3, 1 / pi - 8 / pi**3, -1 / (2 * pi)
    vn, wn0, wn1 = np.zeros((3, 4)), np.zeros((3, 4)), np.zeros((4, 3, 4))
    vn[0], vn[1] = along, across
    wn0[2] = ROD * levers[0]
    wn1[:, 2, :] = spin - spin.T
    ww0, ww1, ww2 = np.zeros((3, 3)), np.zeros((4, 3, 3)), np.zeros((4, 4, 3, 3))
    ww0[2, 2] = INERTIA / MASS
    ww0[1, 1] = ww0[2, 2]
    ww0[0, 0] = 1e-3 * ww0[2, 2]  # about its own axis, which does not turn
    ww1[:, 2, 2] = 2 * ROD * levers[1]
    ww2[:, :, 2, 2] = modes
    vw0, vw1 = _minus_skew([ROD / 2, 0, 0]), np.array([_minus_skew([along[j], across[j], 0]) for j in range(4)])
    invariants = InertiaInvariants(
        vv=MASS * np.eye(3),
        vw0=MASS * vw0,
        vw1=MASS * vw1,
        vn=MASS * vn,
        ww0=MASS * ww0,
        ww1=MASS * ww1,
        ww2=MASS * ww2,
        wn0=MASS * wn0,
        wn1=MASS * wn1,
        nn=MASS * modes,
    )
    area = SIDE**2
    bending = YOUNG * SIDE**4 / 12 / ROD**3 * pi**4 / 2
    stiffness = np.diag([bending, 16 * bending, 0.0, 0.0])
    stiffness[2:, 2:] = YOUNG * area / ROD * np.array([[16, -8], [-8, 7]]) / 3
    ends = np.zeros((2, 3, 4))
    ends[1, 0, 3] = 1.0  # the bar's end node is the slider's pin
    shapes = np.zeros((3, 3, 4))
    shapes[1, 1, 0] = shapes[1, 0, 2] = shapes[2, 0, 3] = 1.0
    return ModalNeutralData(
        name="rod",
        nodes=np.array([[0, 0, 0], [ROD / 2, 0, 0], [ROD, 0, 0]]),
        cells=(("line", np.array([[0, 1], [1, 2]])),),
        shapes=shapes,
        marker_names=("crank", "slider"),
        n_interfaces=2,
        marker_positions=np.array([[0.0, 0, 0], [ROD, 0, 0]]),
        marker_translations=ends,
        marker_rotations=np.zeros((2, 3, 4)),
        stiffness=stiffness,
        damping_ratios=np.zeros(4),
        frequencies=np.zeros(4),
        invariants=invariants,
        load_shapes=np.zeros((0, 10)),
    )


def _minus_skew(c):
    return -np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])


def slider_crank(rod, others=(), ends=None, joints=(), **options):
    """Return the mechanism: crank driven at 150 rad/s, rod (with other parts of it), slider on y = 0."""
    crank_end, slider_end = ends or (f"{rod.name}.crank", f"{rod.name}.slider")
    crank = fmb.RigidBody("crank", mass=0.36, inertia=(1e-3, 2.727e-3, 2.727e-3), markers={"pin": (CRANK, 0, 0)})
    slider = fmb.PointMass("slider", mass=SLIDER, at=(CRANK + ROD, 0, 0))
    return fmb.Model(
        bodies=[fmb.Ground(), crank, rod, *others, slider],
        joints=[
            fmb.Revolute("O", markers=("ground.origin", "crank.center")),
            fmb.Revolute("A", markers=("crank.pin", crank_end)),
            fmb.Spherical("B", markers=(slider_end, "slider.center")),
            OnLine("guide", markers=("ground.origin", "slider.center")),
            fmb.Drive("motor", joint="O", angle=fmb.expression("rate * t", rate=OMEGA)),
            *joints,
        ],
        **options,
    )


def start(case):
    """Return the tabulated initial state: angles of crank and rod, slider, q1 to q4, and their rates."""
    position, velocity = (np.array(case["initial_conditions"][key]) for key in ("pos", "vel"))
    rest = [1.0, 0, 0, 0]
    q = [0, 0, 0, *rest, CRANK, 0, 0, *rest, *position[3:], position[2], 0, 0]
    u = [0, 0, 0, 0, 0, OMEGA, 0, CRANK * OMEGA, 0, 0, 0, velocity[1], *velocity[3:], velocity[2], 0, 0]
    return Instant(t=0.0, q=np.array(q), u=np.array(u), a=np.zeros(0), lam=np.zeros(0), works=np.zeros(3))


def rod_angle(solution):
    """Return the angle of the rod's frame, rad."""
    q = solution.phases[0].q[:, 7:14]
    return 2.0 * np.arctan2(q[:, 6], q[:, 3])
