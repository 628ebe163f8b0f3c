"""`Airload`: the lift of a strip of a wing that lags behind its motion, by two states of its wake."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.rows import store_three_signals
from flexmb.math.kernel import inner_kernel
from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot, matvec, matvec_t
from flexmb.model.described import finite_array, is_number
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["Airload"]

LAGS = ((0.165, 0.0455), (0.335, 0.3))
"""Jones's approximation of Wagner's function: parts that lag, and their rates over half chords travelled."""
BACKWARDS = -1e-6
"""Speed of a stream from behind, m/s, at which the run ends: rounding of a wing at rest is smaller."""
ROW = np.dtype(
    [
        ("marker", np.int64),
        ("pair", np.int64),  # of the marker and the marker of the states
        ("states", np.int64),
        ("wind", np.int64, 3),  # signals, m/s, in W
        ("half", float),  # m, half chord
        ("front", float),  # m, of the quarter point of the chord from the marker along its x-axis
        ("rear", float),  # m, of the three-quarter point
        ("lift", float),  # kg/m: slope, density, half chord and span
        ("air", float),  # kg, that moves along
        ("parts", float, 2),
        ("rates", float, 2),
    ],
    align=True,
)


@inner_kernel
def _load(row, w, turn, lagged, f, A):
    """Write force along x and z, moment about y and the rates of the lags to f (5,), eq. (airload).

    In the axes of the marker. A (5, 5) are the derivatives by the stream w_x and w_z, the rate of pitch and the lags.
    """
    f[:] = 0.0
    A[:] = 0.0
    speed = w[0]
    if speed < BACKWARDS:
        f[:] = np.nan  # a stream from behind: the run ends with a message
        return
    wash = w[2] + row.rear * turn
    late = (1.0 - row.parts[0] - row.parts[1]) * wash
    for k in range(2):
        late += row.parts[k] * lagged[k]
    lead = late - 0.5 * row.half * turn  # at the leading edge, whose suction it makes
    by = np.zeros(5)  # of the late wash
    by[1] = 1.0 - row.parts[0] - row.parts[1]
    by[2] = by[1] * row.rear
    by[3], by[4] = row.parts[0], row.parts[1]
    lift, moved = row.lift * speed * late, row.air * speed * turn
    f[0] = -row.lift * lead * lead
    f[1] = lift + moved
    f[2] = -row.front * lift - row.rear * moved
    for i in range(5):
        A[0, i] = -2.0 * row.lift * lead * (by[i] - (0.5 * row.half if i == 2 else 0.0))
        of_lift, of_moved = row.lift * speed * by[i], (row.air * speed if i == 2 else 0.0)
        if i == 0:
            of_lift, of_moved = row.lift * late, row.air * turn
        A[1, i] = of_lift + of_moved
        A[2, i] = -row.front * of_lift - row.rear * of_moved
    for k in range(2):
        fast = row.rates[k] / row.half
        f[3 + k] = fast * speed * (wash - lagged[k])
        A[3 + k, 0] = fast * (wash - lagged[k])
        A[3 + k, 1] = fast * speed
        A[3 + k, 2] = fast * speed * row.rear
        A[3 + k, 3 + k] = -fast * speed


@inner_kernel
def _add_tangent(pair, R, wind, f, F, M, A):
    """Add the tangent: columns of turns (the stream turns in the axes of the marker), of twists, and of lags."""
    e, t, local = np.empty(3), np.empty(3), np.empty(3)
    force, moment = np.empty(3), np.empty(3)
    for j in range(3):
        e[:] = 0.0
        e[j] = 1.0
        for kind in range(3):  # turned, moved along, turning
            inputs = np.zeros(3)
            if kind == 0:
                cross(wind, e, t)
                matvec_t(R, t, local)
                inputs[0], inputs[1] = local[0], local[2]
            else:
                matvec_t(R, e, local)
                if kind == 1:
                    inputs[0], inputs[1] = -local[0], -local[2]
                else:
                    inputs[2] = local[1]
            out = np.zeros(5)
            for i in range(5):
                for m in range(3):
                    out[i] += A[i, m] * inputs[m]
            local[0], local[1], local[2] = out[0], 0.0, out[1]
            matvec(R, local, force)
            local[0], local[1], local[2] = 0.0, out[2], 0.0
            matvec(R, local, moment)
            if kind == 0:
                cross(e, F, t)
                for i in range(3):
                    force[i] += t[i]
                cross(e, M, t)
                for i in range(3):
                    moment[i] += t[i]
            matrix, column = (pair.K, 3 + j) if kind == 0 else (pair.D, 3 * (kind - 1) + j)
            for i in range(3):
                matrix[i, column] -= force[i]
                matrix[3 + i, column] -= moment[i]
            for k in range(2):
                matrix[6 + k, column] -= out[3 + k]
    for k in range(2):
        for i in range(3):
            pair.D[i, 6 + k] -= R[i, 0] * A[0, 3 + k] + R[i, 2] * A[1, 3 + k]
            pair.D[3 + i, 6 + k] -= R[i, 1] * A[2, 3 + k]
        pair.D[6 + k, 6 + k] -= A[3 + k, 3 + k]


@row_kernel
def apply(raw, data, state, work):
    """L = 2 pi rho b V w_e + pi rho b^2 V theta', w_e = (1 - A1 - A2) w + A1 x1 + A2 x2, eq. (airload)."""
    rows = raw.view(ROW)
    wind, relative, w, turning = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    lagged, f, A = np.empty(2), np.empty(5), np.empty((5, 5))
    local, F, M = np.zeros(3), np.empty(3), np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for i in range(3):
            wind[i] = state.signals[row.wind[i], 0]
            relative[i] = wind[i] - marker.v[i]
        matvec_t(marker.R, relative, w)
        matvec_t(marker.R, marker.w, turning)
        for k in range(2):
            lagged[k] = state_of(work, row.states, k)
        _load(row, w, turning[1], lagged, f, A)
        local[0], local[1], local[2] = f[0], 0.0, f[1]
        matvec(marker.R, local, F)
        for i in range(3):
            M[i] = marker.R[i, 1] * f[2]
            marker.wrench[i] += F[i]
            marker.wrench[3 + i] += M[i]
        for k in range(2):
            add_rate(work, row.states, k, f[3 + k])
        work.energy[0].load_power += dot(F, marker.v) + dot(M, marker.w)
        if work.weights[0].wanted == 1:
            _add_tangent(work.pairs[row.pair], marker.R, wind, f, F, M, A)


LARGEST = 1e30
"""m, as the coordinates of meshes."""


@dataclass(frozen=True, eq=False)
class Airload(Force):
    """Lift a strip of a wing in a stream, with the lag of its wake, eq. (airload).

    The strip is thin and flat, its flow plane and incompressible: Theodorsen's lift and moment with Jones's two terms
    for Wagner's function, and the suction at the leading edge, so that a steady lift is at right angles to the stream.
    Two lagged washes are the states "wake 1" and "wake 2", m/s. There is no stall, no drag of friction, and nothing
    between neighbouring strips: for a wing of finite span give a smaller `slope`. A stream from behind ends the run.

    The air that moves along with the strip has mass, which belongs to the body: `added_mass` at the middle of the
    chord, which acts across the chord only, and `added_inertia` about the span there. Add both to the body.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" on the chord: its x-axis points to the trailing edge, its z-axis to the upper side.
    chord : float, m
    span : float, m
        Of the strip, along the y-axis.
    place : float, -
        Of the marker on the chord: 0 at the leading edge, 1 at the trailing edge.
    density : float, kg/m3
    wind : three signals, m/s
        Velocity of the air in W; the motion of the strip adds to the stream.
    slope : float, -
        Of the steady lift over the angle; 2 pi of a thin section by default.
    wakes : (float, float), m/s
        States at the start: 0 for a stream that begins at the start (Wagner). Statics find those of a steady stream.

    Source: Theodorsen 1935, NACA report 496; Jones 1940, NACA report 681; Garrick 1936, NACA report 567 (suction).
    """

    name: str
    _: KW_ONLY
    marker: str
    chord: float
    span: float
    place: float = 0.25
    density: float = 1.225
    wind: Any = (0.0, 0.0, 0.0)
    slope: float = 2.0 * np.pi
    wakes: tuple[float, float] = (0.0, 0.0)

    table: ClassVar[Table] = Table("Airload", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("chord", "span", "density", "slope")
        if max(self.chord, self.span) > LARGEST:
            raise ModelError(
                self.title,
                found=f"chord = {self.chord!r} m, span = {self.span!r} m",
                expected=f"at most {LARGEST:.0e} m",
                remedy="Give lengths in m",
            )
        if not is_number(self.place) or not 0.0 <= self.place <= 1.0:
            raise ModelError(
                self.title,
                found=f"place = {self.place!r}",
                expected="a number from 0 (leading edge) to 1 (trailing edge)",
                remedy="Leave place out for a marker at a quarter of the chord",
            )
        store_three_signals(self, "wind")
        wakes = finite_array(self.wakes)
        if wakes.shape != (2,):
            raise ModelError(
                self.title,
                found=f"wakes = {self.wakes!r}",
                expected="two finite numbers, m/s",
                remedy="Leave wakes out for a stream that begins at the start",
            )
        object.__setattr__(self, "wakes", tuple(wakes.tolist()))

    @property
    def added_mass(self) -> float:
        """Return the mass of the air that moves along, kg: a cylinder of air around the strip."""
        return float(np.pi * self.density * (0.5 * self.chord) ** 2 * self.span)

    @property
    def added_inertia(self) -> float:
        """Return its moment of inertia about the span at the middle of the chord, kg m2."""
        return self.added_mass * (0.5 * self.chord) ** 2 / 8.0

    def check(self, model) -> None:
        """Raise ModelError if the marker does not exist."""
        model.marker(self.marker, self.title)

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        states = compiler.state_marker(self.title, dict(zip(("wake 1", "wake 2"), self.wakes, strict=True)))
        half = 0.5 * self.chord
        return {
            "marker": marker,
            "pair": compiler.pair(marker, states),
            "states": states,
            "wind": [compiler.signal(component) for component in self.wind],
            "half": half,
            "front": (0.25 - self.place) * self.chord,
            "rear": (0.75 - self.place) * self.chord,
            "lift": self.slope * self.density * half * self.span,
            "air": self.added_mass,
            "parts": [part for part, _ in LAGS],
            "rates": [rate for _, rate in LAGS],
        }
