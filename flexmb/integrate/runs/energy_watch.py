"""Watching the energy of a run: what kinetic, elastic and potential energy gain beyond the work of loads and drives,
less what is dissipated, the integration has made.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.math.energies import stored_energies
from flexmb.math.kernel import entry_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type
from flexmb.math.tables import FLOATS, WORK, State
from flexmb.math.weights import no_matrix, weigh_mass
from flexmb.system.mobility import mass_diagonal
from flexmb.system.program import energies, evaluate

__all__ = ["SHARE", "EnergyWatch", "energies_of_samples"]

SHARE = 0.02
"""Energy that no law explains, relative to the largest that moves in the phase, from which on a run warns."""
NOTED = 0.05
"""The same from which on a run says that its samples are too few to judge."""
STANDING = 1e-4
"""Part of the potential and elastic energy that is there all the time which counts as one that moves: where a heavy
mechanism hardly moves, a displacement within tolerance is all the energy that there is."""
REST = 1e-7
"""Lengths, or rad, in the time of the phase: slower motion is none, and its energy is compared with nothing."""
SHORT = 1e-100
"""s, below which its square is no number."""
SEEN = 10
"""Steps from sample to sample up to which the samples show what moves: a swing takes more."""
FOLLOWED, MOSTLY = 0.01, 0.8
"""Energy of what accelerations at two samples miss of the change of velocities, over what moves: six samples a period;
and the share of such intervals from which on samples show what moves, however many steps are between them."""
OTHERS = "Implicit", "IDA", "Explicit"
"""What is right where the others' steps are too long."""


@entry_kernel(PROGRAM, WORK, array_type(FLOATS), *[array_type(FLOATS, 2)] * 6)
def energies_of_samples(program, work, t, q, u, a, lam, signals, energy):
    """Write kinetic, elastic and potential energy of every sample to `energy` (nt, 3)."""
    no_matrix(work.weights)
    for k in range(len(t)):
        energies(program, State(t[k], q[k], u[k], a[k], lam[k], signals), work)
        found = stored_energies(work.energy)
        for i in range(3):  # one by one: a row at once takes 2 s to compile, for the text of its error
            energy[k, i] = found[i]


class EnergyWatch:
    """The balance of one phase, sample by sample.

    Parameters
    ----------
    system : System
    work : Work
        Scratch.

    What is left unexplained is known at every sample, however few there are: works are summed up in the steps. What it
    is compared with is the largest energy that the samples show, which says little where a motion goes to and fro
    between them.
    """

    def __init__(self, system, work):
        self.system, self.work = system, work
        self.start: np.ndarray | None = None
        self.left, self.moving, self.standing = 0.0, 0.0, 0.0
        self.samples, self.reach = 0, 0.0
        self.jumped = False  # an impulse of a prescribed motion has changed the energy since the latest sample
        self.began, self.rest = 0.0, np.inf
        self.reached, self.fastest = 0.0, 0.0  # s; lengths of the model, or rad, by s
        self.between = 0.0  # J, kinetic energy at the ends of steps, where it is known
        self.worst = (0.0, 0.0)  # energy, time
        self.blame: dict[str, float] = {}
        self._part: tuple[Any, Any, float] = (0.0, 0.0, 0.0)  # touched, power and change since blame was laid
        self._inertia: np.ndarray | None = None
        self._latest: dict[str, np.ndarray] | None = None
        self._missed: list[np.ndarray] = []

    def look(self, rows: dict[str, np.ndarray], switching: Any) -> None:
        """Take a block of samples; `switching` tells what touched since the block before.

        How long blocks are depends on the clock: who is to blame is told of all between two calls of `lay_blame`.
        """
        if not len(rows["t"]):
            return
        system = self.system
        energy = np.zeros((len(rows["t"]), 3))
        arrays = [np.ascontiguousarray(rows[name], float) for name in ("t", "q", "u", "a", "lam")]
        energies_of_samples(system.program, self.work, *arrays, np.zeros((max(1, system.n_signals), 3)), energy)
        given = rows["works"] @ (1.0, 1.0, -1.0)
        now = np.column_stack([energy, rows["works"], energy.sum(axis=1) - given])
        if not np.all(np.isfinite(now)):
            return
        if self.start is None:
            self.start, self.began = now[0], float(rows["t"][0])
        moved = np.column_stack([now[:, :1], np.abs(now - self.start)[:, 1:6]])
        self.moving = max(self.moving, float(moved.max()))
        self.standing = max(self.standing, float(np.abs(energy[:, 1:]).sum(axis=1).max()))
        self.samples += len(now)
        self.reach = max(self.reach, float((np.abs(rows["a"]) @ self._levers(rows)).max()))
        self.rest = self._rest(rows)
        self._missed.append(self._misses(rows))
        self.reached = float(rows["t"][-1])
        self.fastest = max(self.fastest, float((np.abs(rows["u"]) * self._speeds()).max(initial=0.0)))
        if self.jumped:
            self.start[6] += now[0, 6] - self.start[6] - self.left
            self.jumped = False
        left = now[:, 6] - self.start[6]
        k = int(np.argmax(np.abs(left)))
        if abs(left[k]) > abs(self.worst[0]):
            self.worst = float(left[k]), float(rows["t"][k])
        touched, power, change = self._part
        if switching is not None and len(switching.touched):
            touched = touched + switching.touched
            switching.touched[:] = 0.0
        power = power + self._inertias(rows) * np.abs(rows["a"] * rows["u"]).sum(axis=0)
        change += float(np.abs(np.diff(np.concatenate([[self.left], left]))).sum())
        self._part = touched, power, change
        self.left = float(left[-1])

    def hear(self, integrator: Any, variables: Any) -> None:
        """Hear from an integrator, if it tells, what its steps have moved between the samples."""
        if hasattr(integrator, "kinetic"):
            self.between = max(self.between, integrator.kinetic(variables))

    def tell(self, integrator: Any, variables: Any, steps: int, validity: Any) -> None:
        """Warn and note what the balance shows of a phase that has come so far in a number of steps."""
        self.hear(integrator, variables)
        validity.tell([*self.sentences(steps, integrator), *self.made_by_impacts(variables)])
        validity.note(self.notes(steps))

    def lay_blame(self) -> None:
        """Lay the energy that was left since the last call on the contact or friction that did most since then, else on
        the body whose inertia did.
        """
        touched, power, change = self._part
        self._part = 0.0, 0.0, 0.0
        if not change > 0.0:
            return
        if np.any(touched > 0.0):
            owner = self.system.switch_owners[int(np.argmax(touched))]
        else:
            spans = {body.title: self.system.body_slices[body.name][1] for body in self.system.model.bodies}
            owner = max(spans, key=lambda title: float(power[spans[title]].sum()))
        self.blame[owner] = self.blame.get(owner, 0.0) + change

    def _inertias(self, rows: dict[str, np.ndarray]) -> np.ndarray:
        """Return the diagonal of the mass matrix (nu,) at the first sample."""
        if self._inertia is None:
            weigh_mass(self.work.weights)
            evaluate(self.system.program, self.system.state(rows["t"][0], rows["q"][0], rows["u"][0]), self.work)
            diagonal = np.abs(mass_diagonal(self.system, self.work))
            self._inertia = np.where(self.system.is_state, 0.0, diagonal)
        return self._inertia

    def _misses(self, rows: dict[str, np.ndarray]) -> np.ndarray:
        """Return for every interval of samples the kinetic energy (J) of the change of velocities that the mean of both
        accelerations does not explain: little where samples follow the motion.
        """
        t, u, a = (
            rows[name] if self._latest is None else np.concatenate([self._latest[name], rows[name]]) for name in "tua"
        )
        self._latest = {name: rows[name][-1:] for name in "tua"}
        missed = np.diff(u, axis=0) - 0.5 * np.diff(t)[:, None] * (a[1:] + a[:-1])
        return 0.5 * missed**2 @ self._inertias(rows)

    def _levers(self, rows: dict[str, np.ndarray]) -> np.ndarray:
        """Return what makes accelerations an energy (nu,): the work of inertia forces over the length of the model,
        or a radian.
        """
        return self._inertias(rows) / self._units()

    def _rest(self, rows: dict[str, np.ndarray]) -> float:
        """Return the kinetic energy (J) of a motion that counts as none; it is not known for a moment."""
        span = float(rows["t"][-1]) - self.began
        if span <= SHORT:
            return np.inf
        return 0.5 * (REST / span) ** 2 * float(np.sum(self._levers(rows) / self._units()))

    def _units(self) -> np.ndarray:
        """Return one over the length of the model for every velocity (nu,), 1 for rotations."""
        return np.where(self.system.units > 0.0, self.system.units, 1.0)

    def _speeds(self) -> np.ndarray:
        """Return what makes velocities lengths of the model by s (nu,); states are none."""
        return np.where(self.system.is_state, 0.0, self._units())

    def _still(self, steps: int) -> bool:
        """Has nothing moved? What a reaction of 1000 N does on the rounding, or the error, of a place that it holds is
        no energy to judge by, and there is no other.
        """
        way = self.fastest * (self.reached - self.began)
        return way < REST and not self._sparse(steps)

    def _share(self, steps: int) -> float:
        """Return the part of the energy that moves which no law explains; where few samples show it, at the least."""
        if self._still(steps):
            return 0.0
        moves = self._moves()
        unseen = self._sparse(steps) and not self.between
        return abs(self.worst[0]) / (max(moves, self.reach) if unseen else moves)

    def _moves(self) -> float:
        return max(self.moving, self.between, STANDING * self.standing, self.rest)  # of all that has moved: see SHARE

    def _sparse(self, steps: int) -> bool:
        if steps <= SEEN * self.samples:
            return False
        missed = np.concatenate([np.zeros(0), *self._missed])
        return not len(missed) or bool(np.mean(missed <= FOLLOWED * self._moves()) < MOSTLY)

    def notes(self, steps: int) -> list[str]:
        """Return why no judgement is possible, if none is: too much for what samples show, not for what may move."""
        if abs(self.worst[0]) <= NOTED * self._moves() or self._still(steps) or self.sentences(steps):
            return []
        return [
            f"the balance of energy was looked at in {self.samples} samples of {steps} steps, too few to know how much "
            "energy moves between them: less than a gross error is not noticed. More samples make it sharp"
        ]

    def made_by_impacts(self, variables: Any) -> list[str]:
        """Return the warning about energy that laws of impacts have made, if an integrator's variables tell of much."""
        made = getattr(variables, "made_by_impacts", np.zeros(1))
        total, moves = float(made.sum()), self._moves()
        if not total > SHARE * moves:
            return []
        force = self.system.model.forces[int(np.argmax(made))]
        other = "" if force.law.rule == "Poisson" else "Rigid(..., rule='Poisson'), or "
        return [
            f"{force.title}: impacts with friction have made {total:.3g} J, {100.0 * total / moves:.2g} % of the "
            f"largest energy that moves; expected: less than {100.0 * SHARE:g} %. {force.law.rule}'s law of "
            "restitution gives back more than there was where friction turns the slip round: use "
            f"{other}a smaller restitution."
        ]

    def sentences(self, steps: int, integrator: Any = None) -> list[str]:
        """Return the warning about the phase after a number of steps of an integrator: one sentence, or none."""
        self.lay_blame()
        left, t = self.worst
        share = self._share(steps)
        if not share > SHARE:
            return []
        owner = max(self.blame, key=lambda title: self.blame[title])
        percent = f"{100.0 * share:.2g}" if share < 0.995 else f"{100.0 * share:.0f}" if share < 100 else "over 10 000"
        made = "added" if left > 0.0 else "removed"
        others = " or ".join(name for name in OTHERS if name != type(integrator).__name__)
        return [
            f"{owner}: until t = {t:.4g} s the integration has {made} {abs(left):.3g} J that no law explains, "
            f"{percent} % of the largest energy that moves, most of it there; expected: less than "
            f"{100.0 * SHARE:g} %. Give the integrator a smaller rtol or step, or use {others} to compare."
        ]
