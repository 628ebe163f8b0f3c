"""`SpringDamper`: a spring, linear or with a cubic part, and a damper along the line between two markers."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.rows import add_central_block, apply_central_force
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot, norm
from flexmb.model.kinds import Force
from flexmb.model.signal import Constant, as_signal
from flexmb.model.table import Table

__all__ = ["SpringDamper"]

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("stiffness", float),  # N/m
        ("cubic", float),  # N/m3
        ("damping", float),  # N s/m
        ("length", float),  # m, unstretched
        ("preload", np.int64),  # signal, N
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = k x + k3 x^3 + c l' + F0(t), x = l - l0, positive in tension; l = |d|, l' = e . d'."""
    rows = raw.view(ROW)
    d = np.empty(3)
    rate = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        a = work.markers[row.a]
        b = work.markers[row.b]
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
            rate[i] = b.v[i] - a.v[i]
        length = max(norm(d), 1e-12 * (row.length + 1e-12))
        for i in range(3):
            d[i] /= length
        speed = dot(d, rate)
        preload = state.signals[row.preload, 0]
        x = length - row.length
        force = (row.stiffness + row.cubic * x**2) * x + row.damping * speed + preload
        apply_central_force(a, b, d, force)
        work.energy[0].potential += (0.5 * row.stiffness + 0.25 * row.cubic * x**2) * x**2
        work.energy[0].load_power -= preload * speed
        work.energy[0].dissipation += row.damping * speed**2
        if work.weights[0].wanted == 1:
            pair = work.pairs[row.pair]
            add_central_block(pair.K, row.stiffness + 3.0 * row.cubic * x**2, force / length, d)
            add_central_block(pair.D, row.damping, 0.0, d)


@dataclass(frozen=True, eq=False)
class SpringDamper(Force):
    """Pull two markers together with F = stiffness x + cubic x^3 + damping l' + preload(t), x = l - length.

    Parameters
    ----------
    name : str
    markers : (str, str)
    stiffness : float, N/m
    damping : float, N s/m
    cubic : float, N/m3
        Makes the spring stiffer in both senses.
    length : float, m, optional
        Unstretched length; by default the distance of the markers as described.
    preload : signal, N
        Additional tension.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    stiffness: float
    damping: float = 0.0
    cubic: float = 0.0
    length: float | None = None
    preload: Any = 0.0

    table: ClassVar[Table] = Table("SpringDamper", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("stiffness", "damping", "cubic", zero=True)
        if self.length is not None:
            self.require_positive("length", zero=True)
        object.__setattr__(self, "preload", as_signal(self.preload, self.title, "preload"))
        self.require_marker_pair()

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def undirected(self, place):
        """Return what has no direction where the two markers meet; a spring without length needs none."""
        a, b = (place(marker) for marker in self.markers)
        scale = max(1.0, float(np.abs(a).max()), float(np.abs(b).max()))
        if np.linalg.norm(b - a) > 1e-12 * scale:
            return ""
        preloaded = not (isinstance(self.preload, Constant) and self.preload.value == 0.0)
        given = {"damping": self.damping, "preload": preloaded, "length": self.length}
        return " and ".join(name for name, value in given.items() if value)

    def record(self, compiler):
        """Return the row; the default length is the distance as described."""
        a, b = (compiler.marker(name) for name in self.markers)
        length = self.length
        if length is None:
            length = float(np.linalg.norm(compiler.position(b) - compiler.position(a)))
        elif length == 0.0 and not self.stiffness and not self.cubic:
            raise ModelError(
                self.title,
                found="length = 0 m and no stiffness",
                expected="a line to act along",
                remedy="Use Bushing for a force without a direction",
            )
        preload = compiler.signal(self.preload)
        return {"a": a, "b": b, "pair": compiler.pair(a, b), "length": length, "preload": preload}
