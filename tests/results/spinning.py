"""A motion in closed form: a rod on a hinge with constant angular acceleration, and a flexible body that follows it.

What the system room would evaluate is written down here by formula, so sensors, files and pictures are tested against
the formula and not against an integrator.
"""

from dataclasses import KW_ONLY, dataclass, replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.floating.floating_body import FloatingBody
from flexmb.bodies.ground import Ground
from flexmb.bodies.rigid import RigidBody
from flexmb.joints.fixed import Fixed
from flexmb.joints.prismatic import Prismatic
from flexmb.joints.revolute import Revolute
from flexmb.model.kinds import Body
from flexmb.model.modal_arrays import InertiaInvariants
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.model import Model
from flexmb.model.pose import Pose
from flexmb.results import Phase

LENGTH, MASS, RATE, GROWTH = 2.0, 3.0, 40.0, 7.0
POINT = (0.3, -0.1, 0.2)  # where the hinge is


def symmetric(a):
    """Return the symmetric part of matrices (..., n, n)."""
    return 0.5 * (a + np.swapaxes(a, -1, -2))


def block_data(stress=True):
    """A hexahedron and a tetrahedron with two modes: stretch along x, bending along y; invariants are arbitrary.

    Only symmetric matrices are a mass matrix: T = 1/2 u^T M u knows no other part.
    """
    nodes = np.array([[x, y, z] for z in (0, 0.2) for x, y in ((0, 0), (1, 0), (1, 0.2), (0, 0.2))] + [[0.5, 0.1, 0.5]])
    n, m = len(nodes), 2
    shapes = np.zeros((n, 3, m))
    shapes[:, 0, 0] = nodes[:, 0]
    shapes[:, 1, 1] = nodes[:, 0] ** 2
    stress_modes = np.random.default_rng(3).normal(size=(n, 6, m)) * 1e9
    rng = np.random.default_rng(5)
    invariants = InertiaInvariants(
        vv=MASS * np.eye(3),
        vw0=np.zeros((3, 3)),
        vw1=rng.random((m, 3, 3)),
        vn=rng.random((3, m)),
        ww0=np.eye(3),
        ww1=symmetric(rng.random((m, 3, 3))),
        ww2=symmetric(rng.random((m, m, 3, 3))),
        wn0=rng.random((3, m)),
        wn1=rng.random((m, 3, m)),
        nn=np.eye(m),
    )
    return ModalNeutralData(
        name="block",
        nodes=nodes,
        cells=(("hexahedron", np.arange(8)[None]), ("tetra", np.array([[4, 5, 6, 8]]))),
        shapes=shapes,
        marker_names=("root", "tip"),
        n_interfaces=2,
        marker_positions=np.array([[0.0, 0, 0], [1.0, 0, 0]]),
        marker_translations=np.array([np.zeros((3, m)), [[1.0, 0], [0, 1.0], [0, 0]]]),
        marker_rotations=np.zeros((2, 3, m)),
        stiffness=np.eye(m),
        damping_ratios=np.zeros(m),
        frequencies=np.ones(m),
        invariants=invariants,
        load_shapes=np.zeros((0, 6 + m)),
        stress_modes=stress_modes if stress else None,
    )


@dataclass(frozen=True, eq=False)
class Block(Body):
    """A body with modes, as far as results need it."""

    name: str
    _: KW_ONLY
    data: Any = None
    modes: Any = None

    drawn: ClassVar[str] = "cells"
    momentum = FloatingBody.momentum

    @property
    def reduced(self):
        return self.data if self.modes is None else self.data.selected(self.modes)

    @property
    def n_vector(self):
        return self.reduced.n_modes

    def damping_matrix(self):
        critical = 2.0 * np.sqrt(np.diag(self.reduced.stiffness) * np.diag(self.reduced.invariants.nn))
        return np.diag(self.reduced.damping_ratios * critical)

    def marker_poses(self):
        return {name: Pose(at) for name, at in zip(self.data.marker_names, self.data.marker_positions)}


def spinning_model(sensors=(), stress=True, name="spinning"):
    """Ground, rod on a hinge about z, block fixed to the rod, slider along z."""
    rod = RigidBody.rod("rod", length=LENGTH, mass=MASS, radius=0.05)
    return Model(
        bodies=[
            Ground(markers={"hinge": POINT}),
            rod,
            Block("block", data=block_data(stress)),
            RigidBody("slider", mass=1.0, inertia=(1.0, 1.0, 1.0)),
        ],
        joints=[
            Revolute("hinge", markers=("ground.hinge", "rod.start")),
            Fixed("weld", markers=("rod.end", "block.root")),
            Prismatic("guide", markers=("ground.origin", "slider.center")),
        ],
        sensors=sensors,
        name=name,
    )


def angle_at(t):
    """Angle, rate and second rate of the rod, rad."""
    return RATE * t + 0.5 * GROWTH * t * t, RATE + GROWTH * t, GROWTH + 0.0 * t


def spinning_phase(model=None, t=None, system=True):
    """Samples of the motion: rod and block at the angle, the block's modes growing, the slider rising with 0.5 m/s."""
    model = spinning_model() if model is None else model
    t = np.linspace(0.0, 1.0, 11) if t is None else np.asarray(t, float)
    nt = len(t)
    theta, rate, second = angle_at(t)
    c, s, zero = np.cos(theta), np.sin(theta), np.zeros(nt)
    along, across = np.stack([c, s, zero], 1), np.stack([-s, c, zero], 1)
    p = np.stack([np.cos(theta / 2), zero, zero, np.sin(theta / 2)], 1)
    eta = np.stack([1e-3 * t, 2e-3 * t * t], 1)
    still = np.tile([1.0, 0, 0, 0], (nt, 1))
    rise = np.stack([zero, zero, 0.5 * t], 1)
    q = np.hstack([np.tile(POINT, (nt, 1)), p, POINT + LENGTH * along, p, eta, rise, still])
    u = np.zeros((nt, 6 + 8 + 6))
    u[:, 5] = rate
    u[:, 7], u[:, 11] = LENGTH * rate, rate
    u[:, 12:14] = np.stack([1e-3 + zero, 4e-3 * t], 1)
    u[:, 16] = 0.5
    a = np.zeros_like(u)
    a[:, 5] = second
    a[:, 7], a[:, 11], a[:, 13] = LENGTH * second, second, 4e-3
    a[:, 6] = 0.0
    works = np.stack([t, 2 * t, 3 * t], 1)
    lam = np.tile(np.arange(16.0), (nt, 1)) * (1.0 + t[:, None])
    return Phase(
        model=model,
        t=t,
        q=q,
        u=u,
        a=a,
        lam=lam,
        works=works,
        system=spinning_system(model, along, across) if system else None,
    )


def spinning_system(model, along=None, across=None):
    """Names to indices, as the system room gives them."""
    slices, iq, iu = {}, 0, 0
    for body in model.bodies:
        nq, nu = 7 * body.has_frame + body.n_vector, body.n_velocities
        slices[body.name] = (slice(iq, iq + nq), slice(iu, iu + nu))
        iq, iu = iq + nq, iu + nu
    return SimpleNamespace(
        model=model,
        marker_index={name: k for k, name in enumerate(model.marker_names())},
        joint_index={j.name: k for k, j in enumerate(model.joints)},
        force_index={"push": 0},
        body_slices=slices,
        branch_names=(),
    )


def observe(system, t, q, u, a, lam, works):
    """The observation in closed form; markers of rigid bodies by their pose, of the block by its modes."""
    model, nt = system.model, len(t)
    nm = len(system.marker_index)
    r, v, w, acc, alpha = (np.zeros((nt, nm, 3)) for _ in range(5))
    R = np.tile(np.eye(3), (nt, nm, 1, 1))
    theta, rate, second = angle_at(t)
    for name, k in system.marker_index.items():
        body, pose = model.marker(name)
        s = np.array(pose.at)
        if body.name == "ground":
            r[:, k] = s
        elif body.name == "slider":
            r[:, k], v[:, k] = np.outer(0.5 * t, [0, 0, 1.0]) + s, (0, 0, 0.5)
        else:
            R[:, k] = np.array([[[np.cos(x), -np.sin(x), 0], [np.sin(x), np.cos(x), 0], [0, 0, 1]] for x in theta])
            local = np.tile(s, (nt, 1))
            if body.name == "block":
                iq, _ = system.body_slices["block"]
                shape = body.data.marker_translations[body.data.marker_names.index(name.split(".")[1])]
                local = local + [LENGTH, 0, 0] + q[:, iq][:, 7:] @ shape.T
            lever = np.einsum("tij,tj->ti", R[:, k], local)
            w[:, k, 2], alpha[:, k, 2] = rate, second
            r[:, k], v[:, k] = POINT + lever, np.cross(w[:, k], lever)
            acc[:, k] = np.cross(alpha[:, k], lever) + np.cross(w[:, k], v[:, k])
    reaction = np.arange(3 * 6.0).reshape(1, 3, 6) * (1.0 + t[:, None, None])
    return SimpleNamespace(
        r=r,
        R=R,
        v=v,
        w=w,
        a=acc,
        alpha=alpha,
        reaction=reaction,
        force=-np.ones((nt, 1, 6)) * t[:, None, None],
        energy=np.stack([t, 10 * t, 100 * t], 1),
        constraint_error=1e-9 * t[:, None] * (1.0, 10.0, 100.0),
    )


def split(phase, k, **changes):
    """The phase as two phases which share sample `k`, the second with changed fields."""

    def part(rows, **values):
        cut = {name: getattr(phase, name)[rows] for name in ("t", "q", "u", "a", "lam", "works")}
        return replace(phase, **{**cut, **values})

    return part(slice(0, k + 1), ended="break"), part(slice(k, None), **changes)
