"""Equations of motion from energies: what forces leave unexplained of the motion of each body, at samples.

The integrators solve equations whose inertia forces have been derived by hand. Here they come from the kinetic energy
T, the strain energy U and the potential energy V alone, by differences: for the twist (v, w) of a frame

    d/dt dT/dv + w x dT/dv                   + d(U + V) = F
    d/dt dT/dw + w x dT/dw + v x dT/dv       + d(U + V) = N

(Kirchhoff's equations; Lamb, Hydrodynamics, art. 124), and for every flexible coordinate or nodal vector

    d/dt dT/du - dT/dq                       + d(U + V) = Q - damping.

T is a polynomial of at most second degree in the velocities and in the deformation, so the differences below, of sixth
order, are exact but for rounding. Of rigid bodies and point masses T is written down from the description, not
from the rows of the compiled model.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.math.weights import no_matrix
from flexmb.model.model import Model
from flexmb.results import Phase
from flexmb.system import compile as compile_model
from flexmb.system.program import advance, energies, evaluate

__all__ = ["Balance", "unexplained"]

STENCIL = {-3: -1 / 60, -2: 9 / 60, -1: -45 / 60, 1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
"""First derivative by central differences of sixth order."""
ANGLE = 0.02
"""rad and, relative to the size of a body, m: step of the differences of potential energy."""
SOFT = 1e-3
"""Step of the differences along flexible coordinates, relative to the size of a body."""
ROUNDING = 1e-6
"""Of the largest force on a body: forces, and moments at its size, that are less than this are no scale."""
MOST = 60
"""Velocities of a body up to which each is looked at; of larger ones the frame and random directions."""
DIRECTIONS = 24


@dataclass(frozen=True)
class Balance:
    """What nothing explains of the forces on one body.

    Parameters
    ----------
    body : str
    force, moment, other : float
        Largest unexplained force (N), moment (N m, about the origin of the body) and generalised force on flexible
        coordinates (N), each relative to the largest term of its kind on this body; nan if there is none.
    at : float, s
        Time of the worst sample.
    """

    body: str
    force: float
    moment: float
    other: float
    at: float

    @property
    def worst(self) -> float:
        """The largest of the three."""
        return float(np.nanmax([self.force, self.moment, self.other, 0.0]))


class _Single:
    """One body of a model alone in its gravity, compiled, without the stiffening by loads."""

    def __init__(self, model: Model, body):
        fixed = tuple(other for other in model.bodies if not other.n_velocities)
        plain = {"geometric_stiffness": False} if getattr(body, "geometric_stiffness", False) else {}
        self.body = body
        alone = (*fixed, replace(body, **plain) if plain else body)
        self.system = compile_model(
            replace(model, bodies=alone, joints=(), surfaces=(), forces=(), sensors=(), events=())
        )
        self.work = self.system.workspace()
        self.frame = bool(body.has_frame)
        self.nu = self.system.nu
        self.directions = _directions(self.nu, 6 if self.frame else 0)
        self.size = _size(self.system, self.work)

    def state(self, q, u, a=None):
        """Return a state of the body alone."""
        return self.system.state(0.0, np.concatenate([q, self.system.q0[len(q) :]]), u, a)

    def residual(self, q, u, a) -> np.ndarray:
        """Return what the compiled equations say of inertia, elasticity, damping and gravity, (nu,)."""
        no_matrix(self.work.weights)
        evaluate(self.system.program, self.state(q, u, a), self.work)
        return self.work.residual.copy()

    def damping(self, q, u, a) -> np.ndarray:
        """Return the part of the residual that is odd in the velocities, (nu,)."""
        return 0.5 * (self.residual(q, u, a) - self.residual(q, -u, a))

    def kinetic(self, q, u) -> float:
        """Return the kinetic energy, J, of rigid bodies and point masses from their description."""
        body = self.body
        if self.frame and hasattr(body, "inertia") and hasattr(body, "center_of_mass") and self.nu == 6:
            speed = u[:3] + np.cross(u[3:6], body.center_of_mass)
            inertia = np.asarray(body.inertia, float)
            spin = inertia * u[3:6] if inertia.ndim == 1 else inertia @ u[3:6]
            return 0.5 * (body.mass * speed @ speed + u[3:6] @ spin)
        if not self.frame and self.nu == 3 and hasattr(body, "mass"):
            return 0.5 * body.mass * float(u @ u)
        no_matrix(self.work.weights)
        energies(self.system.program, self.state(q, u), self.work)
        return float(self.work.energy[0].kinetic)

    def stored(self, q) -> float:
        """Return strain and potential energy, J."""
        no_matrix(self.work.weights)
        energies(self.system.program, self.state(q, np.zeros(self.nu)), self.work)
        return float(self.work.energy[0].strain + self.work.energy[0].potential)

    def moved(self, q, d, scale: float) -> np.ndarray:
        """Return q [+] scale d."""
        start, out = self.state(q, d).q, np.empty(self.system.nq)
        advance(self.system.program, start, np.ascontiguousarray(d), scale, out)
        return out[: len(q)]

    def momenta(self, q, u) -> np.ndarray:
        """Return dT/du along the directions, (n,); exact, because T is quadratic in the velocities."""
        step = max(float(np.abs(u).max(initial=0.0)), 1e-30)
        return np.array(
            [(self.kinetic(q, u + step * d) - self.kinetic(q, u - step * d)) / (2.0 * step) for d in self.directions]
        )

    def step_along(self, direction) -> float:
        """Return the step of differences along a direction."""
        if self.frame and np.any(direction[:6]):
            return ANGLE if np.any(direction[3:6]) else ANGLE * self.size
        return SOFT * self.size if self.frame or self.nu > 3 else ANGLE * self.size

    def slopes(self, function, q) -> np.ndarray:
        """Return the derivatives of a function of the configuration along the directions, (n,)."""
        found = []
        for d in self.directions:
            h = self.step_along(d)
            found.append(_sum(weight * function(self.moved(q, d, k * h)) for k, weight in STENCIL.items()) / h)
        return np.array(found)

    def terms(self, q, u, a) -> np.ndarray:
        """Return the terms of the equations from energies along the directions, (4, n), whose sum the forces equal."""
        rate = _frequency(q, u, a, self.frame)
        h = 0.1 / rate
        change = (
            _sum(weight * self.momenta(self.moved(q, u, k * h), u + k * h * a) for k, weight in STENCIL.items()) / h
        )
        carried, first = np.zeros(len(change)), 0
        if self.frame:
            p = self.momenta(q, u)[:6]
            v, w, first = u[:3], u[3:6], 6
            carried[:3] = np.cross(w, p[:3])
            carried[3:6] = np.cross(w, p[3:]) + np.cross(v, p[:3])
        if len(change) > first and self.frame:  # of point masses and nodal vectors T does not depend on the places
            carried[first:] = -self.slopes(lambda x: self.kinetic(x, u), q)[first:]
        return np.array([change, carried, self.slopes(self.stored, q), self.directions @ self.damping(q, u, a)])


def _sum(terms: Iterable[Any]) -> Any:
    return sum(terms)


def _directions(nu: int, frame: int) -> np.ndarray:
    """Return the directions along which equations are looked at, (n, nu): the frame's come first."""
    if nu <= MOST:
        return np.eye(nu)
    rng = np.random.default_rng(nu)
    some = rng.choice([-1.0, 1.0], size=(DIRECTIONS, nu)) / np.sqrt(nu)
    some[:, :frame] = 0.0
    return np.vstack([np.eye(frame, nu), some])


def _size(system, work) -> float:
    """Return the size of a body, m: the diagonal of the box of its markers, or one metre if it has one marker only."""
    no_matrix(work.weights)
    evaluate(system.program, system.state(), work)
    places = work.markers["r"][work.markers["nu"] > 0]
    extent = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
    return extent if extent > 0.0 else 1.0


def _frequency(q, u, a, frame: bool) -> float:
    """Return how fast the state changes, 1/s."""
    speed, change = float(np.abs(u).max(initial=0.0)), float(np.abs(a).max(initial=0.0))
    turning = float(np.linalg.norm(u[3:6])) if frame else 0.0
    return max(change / speed if speed > 0.0 else 0.0, turning, 1e-3)


def _applied(system, work, single: _Single, span: slice, state) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces of force elements, and of joints, on one body, (nu_b,) each."""
    no_matrix(work.weights)
    evaluate(system.program, state, work)
    everything = work.residual[span].copy()
    evaluate(system.program, state._replace(lam=np.zeros(system.ng)), work)
    loaded = work.residual[span].copy()
    return loaded, loaded - everything


def unexplained(phase: Phase, system: Any, samples: Iterable[int]) -> tuple[list[Balance], list[str]]:
    """Return the balance of every body that moves, worst first, and the names of those that could not be looked at.

    Parameters
    ----------
    phase : Phase
    system : System
        Its compiled model.
    samples : iterable of int
        Which samples.
    """
    work, found, skipped = system.workspace(), [], []
    samples = list(samples)
    for body in phase.model.bodies:
        if not body.n_velocities:
            continue
        try:
            single = _Single(phase.model, body)
        except FlexmbError as error:  # told to the user; the other bodies are looked at
            skipped.append(f"{body.name} ({error})")
            continue
        found.append(_of_body(phase, system, work, single, samples))
    return sorted(found, key=lambda balance: -balance.worst), skipped


def _of_body(phase: Phase, system, work, single: _Single, samples: list[int]) -> Balance:
    iq, iu = system.body_slices[single.body.name]
    missing, sizes = [], []
    for k in samples:
        state = system.state(phase.t[k], phase.q[k], phase.u[k], phase.a[k], phase.lam[k])
        q, u, a = phase.q[k][iq], phase.u[k][iu], phase.a[k][iu]
        loaded, held = _applied(system, work, single, iu, state)
        forces = single.directions @ (single.residual(q, u, a) - loaded)
        reactions = single.directions @ held
        terms = np.vstack([single.terms(q, u, a), -forces, -reactions])
        missing.append(terms.sum(axis=0))
        sizes.append(np.abs(terms).max(axis=0))
    left, scale = np.abs(missing), np.abs(sizes)
    groups = [slice(0, 3), slice(3, 6), slice(6, None)] if single.frame else [None, None, slice(0, None)]
    if not single.frame and single.nu == 3:
        groups = [slice(0, 3), None, None]
    floors = _floors(scale, groups, single.size)
    shares, worst, at = [], -1.0, float(phase.t[samples[0]])
    for group, floor in zip(groups, floors, strict=True):
        if group is None or not left[:, group].size:
            shares.append(np.nan)
            continue
        largest = max(float(scale[:, group].max()), floor)
        share = left[:, group].max(axis=1) / largest if largest > 0.0 else np.zeros(len(left))
        shares.append(float(share.max()))
        if share.max() > worst:
            worst, at = float(share.max()), float(phase.t[samples[int(share.argmax())]])
    force, moment, other = shares
    return Balance(single.body.name, force, moment, other, at)


def _floors(scale: np.ndarray, groups, size: float) -> list[float]:
    """Return what forces, moments and other forces are compared with at least: where there is none of a kind but
    rounding, the other kinds tell what rounding is.
    """
    levers = (1.0, size, 1.0)
    force = max(
        (
            float(scale[:, group].max()) / lever
            for group, lever in zip(groups, levers)
            if group and scale[:, group].size
        ),
        default=0.0,
    )
    return [ROUNDING * force * lever for lever in levers]
