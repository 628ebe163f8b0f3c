"""`HydraulicCylinder`: a double-acting cylinder with compressible oil behind a valve, its two pressures as states.

`EnclosedOil` is what it is behind a shut valve in statics, where its pressures follow its extension.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, fields
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.forces.with_states import add_state_tangent, state_pairs
from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["EnclosedOil", "HydraulicCylinder"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("states", np.int64),
        ("pairs", np.int64, 2),  # of the markers with the marker of the states
        ("valve", np.int64),  # signal, -1 to 1
        ("channel", np.int64),  # by which the rates of the pressures change with the valve, or -1
        ("area", float, 2),  # m^2, with the sign in which the volume grows with x
        ("volume", float, 2),  # m^3, at x = 0
        ("ports", float, 2),  # Pa: tank, supply
        ("flow", float),  # m^3/s per sqrt(Pa), of an edge wide open
        ("transition", float),  # Pa
        ("leakage", float),  # m^3/(s Pa)
        ("bulk", float),  # Pa
    ],
    align=True,
)

SHUT_ROW = np.dtype(
    [
        *((name, ROW.fields[name][0]) for name in ROW.names),  # type: ignore[index, union-attr]
        ("oil", float, 2),  # m^3, of the oil of each chamber at the pressure 0
    ],
    align=True,
)

FAST = 1e9
"""1/s, with which pressures follow: only the zero of their rates has a meaning, and a search moves parts slower."""


@row_kernel
def apply(raw, data, state, work):
    """F = A_a p_a - A_b p_b, V p' = E (Q - V'), eq. (cylinder)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, speed = measure(row.x, state, work, gradient)
        given = state.signals[row.valve, 0]
        valve = min(max(given, -1.0), 1.0)
        leak = row.leakage * (state_of(work, row.states, 0) - state_of(work, row.states, 1))
        force = 0.0
        for k in range(2):
            p, area = state_of(work, row.states, k), row.area[k]
            volume = row.volume[k] + area * x
            if volume <= 0.0:
                volume = np.nan  # beyond its end: the run ends with a message
            side = 1 if (valve >= 0.0) == (k == 0) else 0
            drop = row.ports[side] - p
            # the root of the drop, linear near zero
            root = np.sqrt(np.sqrt(drop * drop + row.transition * row.transition))
            opened = row.flow * drop / root
            flow, growth = abs(valve) * opened, area * speed
            rate = row.bulk / volume * (flow + (2 * k - 1) * leak - growth)
            add_rate(work, row.states, k, rate)
            force += area * p
            dense = 0.5 * p * p / row.bulk
            work.energy[0].potential += dense * volume
            work.energy[0].load_power += row.ports[side] * flow + dense * growth
            work.energy[0].dissipation += drop * flow + (1 - 2 * k) * leak * p
            if work.weights[0].wanted == 1:
                softer = row.bulk / volume
                slope = abs(valve) * row.flow * (1.0 - 0.5 * drop * drop / root**4) / root
                by_own = -softer * (slope + row.leakage)
                add_state_tangent(row.pairs, work, gradient, k, area, -rate * area / volume, -softer * area, by_own)
                work.pairs[row.pairs[0]].D[6 + k, 7 - k] -= softer * row.leakage
                if row.channel >= 0 and valve == given:
                    work.channels[row.channel, k] = softer * opened * (1.0 if valve >= 0.0 else -1.0)
        act(row.x, work, gradient, force)
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, force, 0.0, 0.0)


@row_kernel
def apply_shut(raw, data, state, work):
    """F = A_a p_a - A_b p_b, p = E ln(V_oil/V), eq. (enclosed-oil); a leakage makes one chamber of two."""
    rows = raw.view(SHUT_ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, _ = measure(row.x, state, work, gradient)
        force = 0.0
        for k in range(2):
            p, area, oil = state_of(work, row.states, k), row.area[k], row.oil[k]
            own = volume = row.volume[k] + area * x
            growth = area
            if row.leakage > 0.0:
                oil += row.oil[1 - k]
                volume += row.volume[1 - k] + row.area[1 - k] * x
                growth += row.area[1 - k]
            if own <= 0.0 or volume <= 0.0:
                volume = np.nan  # beyond its end: the search goes back
            add_rate(work, row.states, k, FAST * (row.bulk * np.log(oil / volume) - p))
            force += area * p
            work.energy[0].potential += 0.5 * p * p / row.bulk * own
            if work.weights[0].wanted == 1:
                add_state_tangent(row.pairs, work, gradient, k, area, -FAST * row.bulk * growth / volume, 0.0, -FAST)
        act(row.x, work, gradient, force)
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, force, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class HydraulicCylinder(OnCoordinate):
    """Push with a cylinder of two chambers with compressible oil behind a valve of four ways, eq. (cylinder).

    The valve is a signal from -1 to 1, held within: a positive one joins chamber a, which extends the cylinder, to the
    supply and chamber b to the tank, a negative one the other way round. An edge that is open by a share s lets
    s rated_flow sqrt(drop/rated_drop) through. The pressures count from that of the surroundings and are the states
    "pressure a" and "pressure b".

    The oil does not cavitate here: look whether pressures fall below -1e5 Pa. There are no ends of the stroke (use
    `BiStop`); where a chamber has no volume any more, the run ends. In statics an open valve sets the
    pressures. Behind one that is shut, a signal of time that is zero, the oil is a spring: where the search begins it
    has the pressures of the start, and from there p = p_0 + E ln(V_0/V), eq. (enclosed-oil). With a leakage both
    pressures are one.

    Parameters
    ----------
    name : str
    markers : (str, str), optional
        Ends of the cylinder.
    joint : str, optional
        Instead of markers: a joint that slides. It extends in the positive sense.
    valve : signal, -
        Opening. It may follow what is measured: a sensor, a formula, a controller.
    areas : (float, float), m^2
        Of the piston in chamber a, and of the ring in chamber b.
    stroke : float, m
    retracted : float, m, optional
        Distance of the markers, or slide of the joint, when it is retracted; by default as described.
    dead_volume : float, m^3
        Of oil in each chamber when the piston is at its end: pipes and fittings.
    supply : float, Pa
    tank : float, Pa
    rated_flow : float, m^3/s
        Through one edge of the valve wide open, at the rated drop.
    rated_drop : float, Pa
        Pressure drop of one edge.
    bulk : float, Pa
        Bulk modulus of the oil with its pipes.
    leakage : float, m^3/(s Pa)
        From chamber to chamber.
    transition : float, Pa
        Drop below which the flow is linear in it.
    pressures : (float, float), Pa
        At the start.
    freedom : str, optional
        "slide", "slide_x" or "slide_y" of the joint; by default its first.

    Source: Merritt 1967, Hydraulic control systems, sections 3-4 (orifices) and 6-5 (continuity).
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str] | None = None
    joint: str | None = None
    valve: Any
    areas: tuple[float, float]
    stroke: float
    retracted: float | None = None
    dead_volume: float
    supply: float
    tank: float = 0.0
    rated_flow: float
    rated_drop: float = 3.5e6
    bulk: float = 1.4e9
    leakage: float = 0.0
    transition: float = 1e4
    pressures: tuple[float, float] = (0.0, 0.0)
    freedom: str | None = None

    motion: ClassVar[str] = "slide"
    without_value: ClassVar[str] = (
        "The piston goes beyond its end, where a chamber has no volume: the pressures do not hold the loads. Let "
        "statics find the pressures behind the shut valve (without hold_states), open the valve, correct pressures and "
        "loads, or add a BiStop at the end of the stroke"
    )
    table: ClassVar[Table] = Table("HydraulicCylinder", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_place()
        self.require_positive("stroke", "dead_volume", "supply", "rated_flow", "rated_drop", "bulk", "transition")
        self.require_positive("leakage", zero=True)
        for field, least in (("areas", 0.0), ("pressures", -np.inf)):
            value = getattr(self, field)
            pair = tuple(value) if isinstance(value, list | tuple) else ()
            if len(pair) != 2 or not all(is_number(one) and one > least for one in pair):
                raise ModelError(
                    self.title,
                    found=f"{field} = {value!r}",
                    expected="two numbers, of chamber a and of chamber b" + (", positive" if least == 0.0 else ", Pa"),
                    remedy="Write areas=(2e-3, 1.2e-3)" if least == 0.0 else "Leave pressures out for 0 Pa",
                )
            object.__setattr__(self, field, (float(pair[0]), float(pair[1])))
        if not is_number(self.tank) or self.tank >= self.supply:
            raise ModelError(
                self.title,
                found=f"tank = {self.tank!r}",
                expected=f"a number below supply = {self.supply} Pa",
                remedy="Leave tank out for 0 Pa",
            )
        if self.retracted is not None and not is_number(self.retracted):
            raise ModelError(
                self.title,
                found=f"retracted = {self.retracted!r}",
                expected="a finite number, m",
                remedy="Leave retracted out: it is then retracted as described",
            )
        object.__setattr__(self, "valve", as_signal(self.valve, self.title, "valve"))

    def in_statics(self, system, start, markers):
        """Return the enclosed oil, if the valve is a signal of time and shut."""
        if self.valve.follows or self.valve.sample(start.t)[0] != 0.0:
            return self
        coordinate, names = self.place(system.model)
        a, b = (markers[system.marker_index[name]] for name in names)
        way = b["r"] - a["r"]
        x = np.linalg.norm(way) if coordinate.kind == "distance" else a["R"][:, "xyz".index(coordinate.axis)] @ way
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        pressures = tuple(map(float, start.u[system.state_slices[self.title][1]][:2]))
        return EnclosedOil(**own | {"pressures": pressures, "extension": float(x)})

    def record(self, compiler):
        """Return the row; ModelError if the piston is out of its cylinder as described."""
        x = self.coordinate_row(compiler, counts=False)
        described = self.described(compiler)
        begins = described if self.retracted is None else self.retracted
        if not -1e-9 * self.stroke <= described - begins <= (1.0 + 1e-9) * self.stroke:
            raise ModelError(
                self.title,
                found=f"extended by {described - begins:.4g} m as described",
                expected=f"0 to its stroke of {self.stroke:.4g} m",
                remedy="Correct retracted, or the places of its ends",
            )
        names = ("pressure a", "pressure b")
        starts = dict(zip(names, self.pressures, strict=True))
        states = compiler.state_marker(self.title, starts, dict.fromkeys(names, self.supply))
        number, (channel,) = compiler.follow(self.valve, states)
        a, b = self.areas
        return {
            "x": x,
            "states": states,
            "pairs": state_pairs(compiler, x, states),
            "valve": number,
            "channel": channel,
            "area": (a, -b),
            "volume": (self.dead_volume - a * begins, self.dead_volume + b * (begins + self.stroke)),
            "ports": (self.tank, self.supply),
            "flow": self.rated_flow / self.rated_drop**0.5,
        }


@dataclass(frozen=True, eq=False)
class EnclosedOil(HydraulicCylinder):
    """A cylinder whose oil is shut in: the pressures are those to which the oil is pressed together.

    Parameters
    ----------
    extension : float, m
        Coordinate of the cylinder where its oil has the given `pressures`.
    """

    _: KW_ONLY
    extension: float

    table: ClassVar[Table] = Table("EnclosedOil", SHUT_ROW, {"apply": apply_shut})

    def record(self, compiler):
        """Return the row of the cylinder, with the oil of each chamber."""
        row = super().record(compiler)
        volume = np.array(row["volume"]) + np.array(row["area"]) * self.extension
        return row | {"oil": tuple(volume * np.exp(np.array(self.pressures) / self.bulk))}
