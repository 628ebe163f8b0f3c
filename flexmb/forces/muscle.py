"""`Muscle`: a Hill muscle with activation, fibre, pennation and tendon, along a way over bones."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.rows import add_to_pairs
from flexmb.errors import ModelError
from flexmb.forces.muscle_curves import active_force, contraction, passive_force, shortening, tendon_force
from flexmb.forces.path_fields import check_path, described_length, path_record
from flexmb.forces.wrapped_path import PATH, add_path_curvature, path_length, pull, write_kinks
from flexmb.math.kernel import inner_kernel
from flexmb.math.states import add_rate, state_of
from flexmb.math.switches import switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number
from flexmb.model.kinds import Force
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["Muscle"]

ROW = np.dtype(
    [
        ("path", PATH),
        ("states", np.int64),  # activation, fibre length in m
        ("excitation", np.int64),  # signal
        ("channel", np.int64),  # by which the rate of the activation changes with the excitation, or -1
        ("cylinders", np.int64),
        ("strength", float),  # N
        ("fibre", float),  # m
        ("tendon", float),  # m
        ("height", float),  # m, across the line of the tendon
        ("speed", float),  # 1/s
        ("damping", float),
        ("tendon_strain", float),
        ("passive_strain", float),
        ("lengthening", float),
        ("rise", float),  # s
        ("fall", float),  # s
    ],
    align=True,
)


@inner_kernel
def _activate(row, given, a):
    """Return the rate of the activation and its derivatives by excitation and activation, eq. (activation)."""
    u = min(max(given, 0.0), 1.0)
    scale = 0.5 + 1.5 * a
    if u > a:
        rate, by_u = (u - a) / (row.rise * scale), 1.0 / (row.rise * scale)
        return rate, (by_u if u == given else 0.0), -by_u - 1.5 * rate / scale
    rate, by_u = (u - a) * scale / row.fall, scale / row.fall
    return rate, (by_u if u == given else 0.0), -by_u + 1.5 * (u - a) / row.fall


@inner_kernel
def _contract(row, length, a, fibre, energy, slopes):
    """Return the tension of the tendon, N, and the rate of the fibre's length, m/s, eq. (muscle).

    Writes the derivatives of the tension by the lengths of way and fibre, and of the rate by the length of the
    way, the activation and the length of the fibre, to `slopes` (5,).
    """
    along = (fibre * fibre - row.height * row.height) ** 0.5
    lean = fibre / along  # 1 / cos of the pennation
    pull_t, stiffness, stored_t = tendon_force((length - along) / row.tendon - 1.0, row.tendon_strain)
    passive, by_x, stored_p = passive_force(fibre / row.fibre, row.passive_strain)
    bell, bell_slope = active_force(fibre / row.fibre)
    weak = 0.25 + 0.75 * a  # the greatest speed falls with the activation
    active, damping = a * bell, row.damping * weak
    z = contraction(pull_t * lean - passive, active, damping, row.lengthening)
    factor, slope = shortening(z, row.lengthening)
    fastest = row.fibre * row.speed
    rate = fastest * weak * z
    energy.potential += row.strength * (row.tendon * stored_t + row.fibre * stored_p)
    energy.load_power -= row.strength * active * factor * rate
    energy.dissipation += row.strength * damping * z * rate
    softness = 1.0 / (active * slope + damping)
    by_length = stiffness / row.tendon  # of the force of the tendon, over its strength
    lean_slope = -row.height * row.height / along**3
    by_fibre = -by_length * lean * lean + pull_t * lean_slope - by_x / row.fibre
    slopes[0] = row.strength * by_length
    slopes[1] = -row.strength * by_length * lean
    slopes[2] = fastest * weak * softness * by_length * lean
    slopes[3] = fastest * (0.75 * z - weak * softness * (factor * bell + 0.75 * row.damping * z))
    slopes[4] = fastest * weak * softness * (by_fibre - factor * a * bell_slope / row.fibre)
    return row.strength * pull_t, rate


@row_kernel
def apply(raw, data, state, work):
    """T = F0 f_T(L, l), a' = (u - a) / tau(u, a), l' = v(T, a, l), eq. (muscle)."""
    rows = raw.view(ROW)
    slopes = np.empty(5)
    for m in range(rows.shape[0]):
        row = rows[m]
        n = row.path.n
        G = np.empty((n, 6))
        length = path_length(row.path, state, work, G)
        a, fibre = state_of(work, row.states, 0), state_of(work, row.states, 1)
        rate, by_u, by_a = _activate(row, state.signals[row.excitation, 0], a)
        tension, stretching = _contract(row, length, a, fibre, work.energy[0], slopes)
        add_rate(work, row.states, 0, rate)
        add_rate(work, row.states, 1, stretching)
        pull(row.path, work, G, tension)
        if work.weights[0].wanted == 0:
            continue
        size = 6 * n + 6
        K, D = np.zeros((size, size)), np.zeros((size, size))
        add_path_curvature(row.path, state, work, tension, K)
        for i in range(6 * n):
            g = G[i // 6, i % 6]
            for j in range(6 * n):
                K[i, j] += slopes[0] * g * G[j // 6, j % 6]
            D[i, 6 * n + 1] = slopes[1] * g
            K[6 * n + 1, i] = -slopes[2] * g
        D[6 * n, 6 * n] = -by_a
        D[6 * n + 1, 6 * n] = -slopes[3]
        D[6 * n + 1, 6 * n + 1] = -slopes[4]
        add_to_pairs(work, data, row.path.pairs, n + 1, K, D)
        if row.channel >= 0:
            work.channels[row.channel, 0] = by_u


@switch_kernel
def switch(raw, data, state, work, out):
    """Where the way begins to touch its cylinders."""
    rows = raw.view(ROW)
    first = 0
    for m in range(rows.shape[0]):
        first = write_kinks(rows[m].path, state, work, out, first)


@dataclass(frozen=True, eq=False)
class Muscle(Force):
    """Pull along a way over bones with a muscle: activation, fibre, pennation and tendon, eq. (muscle).

    The way goes straight from marker to marker, and around the z-axes of markers with a radius: cylinders without
    friction, with the geodesic in closed form, eq. (wrapped-path). A positive radius is passed counter-clockwise seen
    against the z-axis, a negative one clockwise; where the straight line does not touch a cylinder, the way leaves it.
    Cylinders may follow each other, with axes of any directions, eq. (cylinders-in-a-row).
    The way is followed over full turns. A marker within a cylinder, or a way that would have to go through one, ends
    the run.

    The excitation, held between 0 and 1, drives the activation a; the fibre pulls with the active force that its length
    and speed allow, and with the passive one; it lies at an angle to the tendon, which is elastic, so that its length
    is a state: "activation" and "fibre length" (m). Statics give the equilibrium at rest. Work of the active force
    counts as work of a load; tendon and passive fibre store energy.

    Parameters
    ----------
    name : str
    through : sequence of str
        Markers "body.marker" of the way in their order, from origin to insertion; 2 to 12.
    radii : sequence of float, m, optional
        For each marker 0, or the radius of a cylinder about its z-axis with the sense of the way.
    excitation : signal, -
        It may follow what is measured: a reflex, a controller.
    strength : float, N
        Greatest isometric force, at the optimal length of the fibre.
    fibre : float, m
        Optimal length of the fibre.
    tendon : float, m
        Length of the tendon when it begins to pull.
    pennation : float, rad
        Angle between fibre and tendon at the optimal length; the height of the fibre across the tendon remains.
    speed : float, 1/s
        Greatest speed of shortening, in optimal lengths.
    damping : float, -
        Of the fibre: force over `strength` at the greatest speed. 0 is Thelen's muscle as published, whose run ends
        where no speed of the fibre makes the force of the tendon.
    tendon_strain : float, -
        Of the tendon at the greatest isometric force.
    passive_strain : float, -
        Of the fibre where its passive force is as large.
    lengthening : float, -
        Limit of the active force of a fibre that lengthens fast, over the isometric one.
    rise, fall : float, s
        Times of activation and deactivation.
    activation : float, -, optional
        At the start; by default the excitation at t = 0.
    fibre_length : float, m, optional
        At the start; by default in equilibrium with the tendon at rest.

    Source: Thelen 2003, J. Biomech. Eng. 125, eq. 1 to 7; Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135
    (damping); Garner & Pandy 2000, Comput. Methods Biomech. Biomed. Eng. 3 (ways over cylinders).
    """

    name: str
    _: KW_ONLY
    through: Any
    radii: Any = None
    excitation: Any
    strength: float
    fibre: float
    tendon: float
    pennation: float = 0.0
    speed: float = 10.0
    damping: float = 0.1
    tendon_strain: float = 0.04
    passive_strain: float = 0.6
    lengthening: float = 1.4
    rise: float = 0.015
    fall: float = 0.05
    activation: float | None = None
    fibre_length: float | None = None

    table: ClassVar[Table] = Table("Muscle", ROW, {"apply": apply, "switch": switch}, switches="cylinders")

    def __post_init__(self):
        super().__post_init__()
        check_path(self)
        for_all = ("strength", "fibre", "tendon", "speed", "tendon_strain", "passive_strain", "rise", "fall")
        self.require_positive(*for_all)
        self.require_positive("pennation", "damping", zero=True)
        object.__setattr__(self, "excitation", as_signal(self.excitation, self.title, "excitation"))
        self._require("lengthening", self.lengthening, "a number above 1", 1.0, np.inf)
        self._require("pennation", self.pennation, "an angle below 1.4 rad", -1.0, 1.4)
        if self.activation is not None:
            self._require("activation", self.activation, "a number from 0 to 1", -1e-300, 1.0 + 1e-15)
        if self.fibre_length is not None:
            self._require("fibre_length", self.fibre_length, f"more than {self.height:.4g} m", self.height, np.inf)

    def _require(self, field: str, value: Any, expected: str, above: float, below: float) -> None:
        """Raise ModelError unless a field is a number between two others."""
        if not is_number(value) or not above < value < below:
            raise ModelError(
                self.title,
                found=f"{field} = {value!r}",
                expected=expected,
                remedy=f"Correct {field}, or leave it out",
            )

    @property
    def height(self) -> float:
        """Return the height of the fibre across the line of the tendon, m."""
        return float(self.fibre * np.sin(self.pennation))

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.through:
            model.marker(marker, self.title)

    def measure(self, model) -> str:
        """Return the last marker."""
        return self.through[-1]

    def record(self, compiler):
        """Return the row; by default the fibre is in equilibrium as described."""
        start = self.activation
        if start is None:
            known = 0.0 if self.excitation.follows else float(self.excitation.sample(0.0)[0])
            start = min(max(known, 0.0), 1.0)
        fibre = self.fibre_length
        if fibre is None:
            fibre = self.resting_fibre(described_length(self, compiler), start)
        sizes = {"activation": 1.0, "fibre length": self.fibre}
        states = compiler.state_marker(self.title, {"activation": start, "fibre length": fibre}, sizes)
        number, (channel,) = compiler.follow(self.excitation, states)
        path = path_record(self, compiler, states)
        return {
            "path": path,
            "states": states,
            "excitation": number,
            "channel": channel,
            "cylinders": path["cylinders"],
        }

    def resting_fibre(self, length: float, activation: float) -> float:
        """Return the length of the fibre, m, at rest with the tendon, for a length of the way, m, and an activation.

        Raises
        ------
        ModelError
            The way is so short that the tendon is slack.
        """

        from scipy.optimize import brentq

        def missing(along: float) -> float:
            fibre = float(np.hypot(along, self.height))
            x = fibre / self.fibre
            tendon = tendon_force((length - along) / self.tendon - 1.0, self.tendon_strain)[0]
            return tendon * fibre / along - activation * active_force(x)[0] - passive_force(x, self.passive_strain)[0]

        shortest, longest = 1e-3 * self.fibre, length - self.tendon
        if longest <= shortest or missing(shortest) <= 0.0:
            raise ModelError(
                self.title,
                found=f"a way of {length:.6g} m for a tendon of {self.tendon:.6g} m and a fibre of {self.fibre:.6g} m",
                expected="a way on which the tendon is taut at some length of the fibre",
                remedy="Shorten the tendon, or describe the bodies farther apart",
            )
        along = brentq(missing, shortest, longest, xtol=1e-15 * self.fibre, rtol=1e-14)
        return float(np.hypot(along, self.height))
