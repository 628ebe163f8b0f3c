"""`MaxwellDamper`: springs and dampers in a row, several side by side: a rubber mount, a viscoelastic strut."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.forces.with_states import add_state_tangent, state_pairs
from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number, whole
from flexmb.model.table import Table

__all__ = ["MaxwellDamper"]

MOST = 6
"""Branches of a damper: the states of one marker."""

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("states", np.int64),
        ("pairs", np.int64, 2),  # of the markers with the marker of the states
        ("stiffness", float),  # N/m or N m/rad
        ("free", float),  # m or rad
        ("n", np.int64),  # branches
        ("branches", float, (MOST, 2)),  # stiffness and relaxation time, s
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = -k e - sum k_j (e - z_j), z_j' = (e - z_j) / tau_j, e = x - x_0, eq. (maxwell)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, _ = measure(row.x, state, work, gradient)
        e = x - row.free
        force, stiffness = -row.stiffness * e, row.stiffness
        work.energy[0].potential += 0.5 * row.stiffness * e * e
        for j in range(row.n):
            k, time = row.branches[j, 0], row.branches[j, 1]
            stretch = e - state_of(work, row.states, j)
            force -= k * stretch
            stiffness += k
            add_rate(work, row.states, j, stretch / time)
            work.energy[0].potential += 0.5 * k * stretch * stretch
            work.energy[0].dissipation += k * stretch * stretch / time
            if work.weights[0].wanted == 1:
                add_state_tangent(row.pairs, work, gradient, j, k, 1.0 / time, 0.0, -1.0 / time)
        act(row.x, work, gradient, force)
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, force, stiffness, 0.0)


@dataclass(frozen=True, eq=False)
class MaxwellDamper(OnCoordinate):
    """Pull back with a spring and with springs that relax, each in a row with a damper (Prony series), eq. (maxwell).

    After a sudden elongation e the force is ``(stiffness + sum k_j exp(-t/tau_j)) e``; at the angular frequency w the
    dynamic stiffness is ``stiffness + sum k_j i w tau_j / (1 + i w tau_j)``. The dampers have ``c_j = k_j tau_j``. The
    elongations of the dampers are the states "damper 1", "damper 2", ...

    Parameters
    ----------
    name : str
    markers : (str, str), optional
    joint : str, optional
        Instead of markers: the joint on whose freedom the force acts.
    branches : sequence of (float, float), N/m and s
        Stiffness k_j, N/m (N m/rad), and relaxation time tau_j, s; up to six.
    stiffness : float, N/m (N m/rad)
        Of the spring beside the branches, which remains in the long run.
    length : float, m or rad, optional
        Where the spring is slack; by default x as described.
    elongations : sequence of float, m or rad, optional
        Of the dampers at the start; 0 by default: all branches pull as springs at the start.
    along : "line", "x", "y" or "z"
        Line between the markers, or an axis of the first marker.
    freedom : str, optional
        "slide", "turn", "slide_x", "slide_y" or "turn_b" of the joint; by default its first turn, else its slide.

    Source: Ferry 1980, Viscoelastic properties of polymers, chapter 1 (generalised Maxwell model).
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str] | None = None
    joint: str | None = None
    branches: tuple[tuple[float, float], ...]
    stiffness: float = 0.0
    length: float | None = None
    elongations: tuple[float, ...] | None = None
    along: str = "line"
    freedom: str | None = None

    table: ClassVar[Table] = Table("MaxwellDamper", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_place()
        self.require_positive("stiffness", zero=True)
        object.__setattr__(self, "branches", self._checked_branches())
        if self.length is not None and not is_number(self.length):
            raise ModelError(
                self.title,
                found=f"length = {self.length!r}",
                expected="a finite number, m or rad",
                remedy="Leave length out: the spring is then slack as described",
            )
        if self.elongations is not None:
            given = tuple(self.elongations) if isinstance(self.elongations, list | tuple) else ()
            if len(given) != len(self.branches) or not all(is_number(z) for z in given):
                raise ModelError(
                    self.title,
                    found=f"elongations = {self.elongations!r}",
                    expected=f"one finite number for each branch, {len(self.branches)}",
                    remedy="Leave elongations out for 0",
                )
            object.__setattr__(self, "elongations", tuple(float(z) for z in given))

    @classmethod
    def power_law(
        cls, name: str, *, modulus: float, order: float, band: tuple[float, float], count: int = MOST, **fields
    ) -> MaxwellDamper:
        """Return a damper whose dynamic stiffness is nearly ``modulus (i w)^order`` over a band: a spring-pot.

        Rubber and tissue relax so, with an order of 0.1 to 0.5, which a derivative of that order describes. The
        relaxation times are spread evenly over the logarithm of the band, the stiffnesses are the positive ones of
        least relative error.

        Parameters
        ----------
        name : str
        modulus : float, N s^order/m
        order : float
            Above 0 (a spring) and below 1 (a damper).
        band : (float, float), Hz
            Lowest and highest frequency.
        count : int
            Number of branches.
        fields
            Other fields of the damper: markers, joint, length, ...

        Raises
        ------
        ModelError
            The numbers are wrong, or so many branches miss the law by more than 5 % somewhere in the band.

        Source: Bagley & Torvik 1983, A theoretical basis for the application of fractional calculus to viscoelasticity.
        """
        title, count = f"Force '{name}'", whole(count)
        numbers = [modulus, order, *band] if isinstance(band, list | tuple) and len(band) == 2 else [0.0]
        right = all(is_number(x) and x > 0.0 for x in numbers) and count in range(1, MOST + 1)
        if not right or not order < 1.0 or not band[0] < band[1]:
            raise ModelError(
                title,
                found=f"modulus = {modulus!r}, order = {order!r}, band = {band!r}, count = {count!r}",
                expected=f"positive numbers, an order below 1, the lower frequency first, 1 to {MOST} branches",
                remedy="Write modulus=2e4, order=0.3, band=(0.1, 100.0)",
            )
        branches, miss = _prony(modulus, order, 2.0 * np.pi * np.array(band), count)
        if miss > 0.05:
            raise ModelError(
                title,
                found=f"{count} branches that miss the power law by {100.0 * miss:.2g} % between {band[0]:g} and "
                f"{band[1]:g} Hz",
                expected="at most 5 %",
                remedy="Give a narrower band, or more branches",
            )
        return cls(name, branches=branches, **fields)

    def _checked_branches(self) -> tuple[tuple[float, float], ...]:
        """Return the branches as numbers; ModelError if they are not pairs of positive ones."""
        try:
            numbers = np.array(self.branches, float)
        except (TypeError, ValueError, OverflowError):
            numbers = np.empty(0)
        good = numbers.ndim == 2 and numbers.shape[1:] == (2,) and np.all((numbers > 0.0) & np.isfinite(numbers))
        if not good or not 1 <= len(numbers) <= MOST:
            raise ModelError(
                self.title,
                found=f"branches = {self.branches!r}",
                expected=f"1 to {MOST} pairs (stiffness, relaxation time in s), positive",
                remedy="Write branches=[(2e5, 0.01), (5e4, 1.0)]; use two dampers for more",
            )
        return tuple((float(k), float(time)) for k, time in numbers)

    def record(self, compiler):
        """Return the row."""
        x = self.coordinate_row(compiler)
        described = self.described(compiler)
        free = described if self.length is None else self.length
        starts = self.elongations or (0.0,) * len(self.branches)
        names = [f"damper {j + 1}" for j in range(len(self.branches))]
        sizes = dict.fromkeys(names, abs(described) or 1.0)
        states = compiler.state_marker(self.title, dict(zip(names, starts, strict=True)), sizes)
        branches = np.ones((MOST, 2))
        branches[: len(self.branches)] = self.branches
        return {
            "x": x,
            "states": states,
            "pairs": state_pairs(compiler, x, states),
            "free": free,
            "n": len(self.branches),
            "branches": branches,
        }


def _prony(modulus: float, order: float, band: np.ndarray, count: int) -> tuple[tuple[tuple[float, float], ...], float]:
    """Return branches (stiffness, time) near ``modulus (i w)^order`` in a band, rad/s, and their largest miss."""
    from scipy.optimize import minimize_scalar, nnls

    w = np.geomspace(band[0], band[1], 60 * count)
    wanted = modulus * (1j * w) ** order

    def fit(reach: float):
        # times beyond the band make up for all that a sum of few terms leaves out at its ends
        times = 1.0 / np.geomspace(band[0] / reach, band[1] * reach, count)
        parts = (1j * w[:, None] * times) / (1.0 + 1j * w[:, None] * times) / wanted[:, None]
        rows = np.vstack([parts.real, parts.imag])
        stiffness, _ = nnls(rows, np.concatenate([np.ones(len(w)), np.zeros(len(w))]))
        return times, stiffness, float(np.abs(parts @ stiffness - 1.0).max())

    best = minimize_scalar(lambda x: fit(np.exp(x))[2], bounds=(0.0, 5.0), method="bounded").x
    times, stiffness, miss = fit(np.exp(best))
    used = stiffness > 0.0
    return tuple(zip(stiffness[used].tolist(), times[used].tolist(), strict=True)), miss
