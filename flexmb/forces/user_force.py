"""`UserForce`: a force computed by a Python function, for prototyping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.math.callbacks import Repeats, call_back, callback
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_product, euler_to_matrix, exp_euler, matrix_to_euler
from flexmb.math.switches import CROSSING, FORMULA, UNITLESS, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.foreign import imported
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["UserForce"]

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("address", np.int64),
        ("length", float),
        ("switch", np.int64),  # address of the function of the switches, or 0
        ("switches", np.int64),  # how many they are
    ],
    align=True,
)
STEP = 1e-6
"""Of the differences: rad, rad/s, and relative to the distance of the markers."""
INPUTS = 19
"""Numbers given to the function: t, d (3), d' (3), w (3), R (3, 3)."""


@inner_kernel
def _ask(address, t, motion, Q, inputs, f):
    """Write the force and moment of the function at a relative motion to `f` (6,)."""
    inputs[0] = t
    inputs[1:10] = motion
    for i in range(3):
        for j in range(3):
            inputs[10 + 3 * i + j] = Q[i, j]
    call_back(address, inputs.ctypes.data, f.ctypes.data)


@row_kernel
def apply(raw, data, state, work):
    """Force and moment of the function, on b at its marker and back on a; the tangent by central differences."""
    rows = raw.view(ROW)
    motion, other = np.empty(9), np.empty(9)
    Q, turned = np.empty((3, 3)), np.empty((3, 3))
    inputs = np.empty(INPUTS)
    f, plus, minus = np.zeros(6), np.zeros(6), np.zeros(6)
    K, C = np.empty((6, 6)), np.empty((6, 6))
    p, dp, product = np.empty(4), np.empty(4), np.empty(4)
    phi = np.zeros(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        a, b = work.markers[row.a], work.markers[row.b]
        relative_motion(a, b, motion, Q)
        _ask(row.address, state.t, motion, Q, inputs, f)
        act_relative(a, b, f)
        for i in range(6):
            work.energy[0].load_power += f[i] * motion[3 + i]
        if work.weights[0].wanted == 0:
            continue
        matrix_to_euler(Q, p)
        far = max(row.length, (motion[0] ** 2 + motion[1] ** 2 + motion[2] ** 2) ** 0.5)
        for j in range(12):
            step = STEP * far if j < 3 or 6 <= j < 9 else STEP  # per second, of velocities
            for side in range(2):
                h = step if side == 0 else -step
                other[:] = motion
                turned[:] = Q
                if j < 3:
                    other[j] += h
                elif j < 6:
                    phi[:] = 0.0
                    phi[j - 3] = h
                    exp_euler(phi, dp)
                    euler_product(dp, p, product)
                    euler_to_matrix(product, turned)
                else:
                    other[j - 3] += h
                _ask(row.address, state.t, other, turned, inputs, plus if side == 0 else minus)
            for i in range(6):
                change = (minus[i] - plus[i]) / (2.0 * step)
                if j < 6:
                    K[i, j] = change
                else:
                    C[i, j - 6] = change
        add_relative_tangent(work.pairs[row.pair], a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The numbers of the user that pass zero where the force jumps or has a kink, and their rates."""
    rows = raw.view(ROW)
    motion, Q, inputs = np.empty(9), np.empty((3, 3)), np.empty(INPUTS)
    first = 0
    for n in range(rows.shape[0]):
        row = rows[n]
        if row.switches == 0:
            continue
        found = np.empty(2 * row.switches)
        relative_motion(work.markers[row.a], work.markers[row.b], motion, Q)
        _ask(row.switch, state.t, motion, Q, inputs, found)
        for k in range(row.switches):
            place = out[first + k]
            place[:] = 0.0
            place[0], place[1], place[4], place[9] = CROSSING, found[2 * k], found[2 * k + 1], 1.0
            place[FORMULA] = UNITLESS
        first += row.switches


class _Switches:
    """The C function that asks a Python function for its switches, and for their rates by differences along the motion;
    what accelerations do to them is not known.
    """

    def __init__(self, function: Callable[..., Any], count: int):
        self.function, self.count, self.failure = function, count, ""
        self.pointer, self.address = callback(self._run)

    def _at(self, t: float, d, v, R, w) -> np.ndarray:
        found = np.ravel(np.asarray(self.function(t, d, v, R, w), float))
        if found.shape != (self.count,):
            raise ValueError(f"{found.size} switches, at the start {self.count}")
        return found

    def _run(self, inputs, outputs) -> None:
        x, out = np.ctypeslib.as_array(inputs, (INPUTS,)), np.ctypeslib.as_array(outputs, (2 * self.count,))
        try:
            x = x.copy()  # the function may keep its arguments
            t, d, v, R, w = x[0], x[1:4], x[4:7], x[10:19].reshape(3, 3), x[7:10]
            h = STEP / max(1.0, float(np.abs(x[4:10]).max()))
            turning = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]]) @ R
            ends = [self._at(t + s, d + s * v, v, R + s * turning, w) for s in (-h, h)]
            out[0::2], out[1::2] = self._at(t, d, v, R, w), (ends[1] - ends[0]) / (2.0 * h)
        except Exception as error:  # whatever a user's function raises: it cannot pass through compiled code
            self.failure = self.failure or f"switches: {type(error).__name__}: {error} at t = {x[0]:.6g} s"
            out[:] = np.nan


class _Callback:
    """The C function that calls a Python function; what goes wrong there is kept, because no exception can pass."""

    def __init__(self, function: Callable[..., Any]):
        self.function, self.failure, self.repeats = function, "", Repeats()
        self.pointer, self.address = callback(self._run)

    def _answer(self, x: np.ndarray) -> np.ndarray:
        x, answer = x.copy(), np.empty(6)  # the function may keep its arguments
        force, moment = self.function(x[0], x[1:4], x[4:7], x[10:19].reshape(3, 3), x[7:10])
        answer[:3], answer[3:] = force, moment
        return answer

    def _run(self, inputs, outputs) -> None:
        x = np.ctypeslib.as_array(inputs, (INPUTS,))
        out = np.ctypeslib.as_array(outputs, (6,))
        try:
            out[:] = self._answer(x)
            self.repeats.require(out, lambda: self._answer(x))
            if not np.all(np.isfinite(out)):
                self.failure = self.failure or f"it returned {np.array2string(out, precision=4)} at t = {x[0]:.6g} s"
        except Exception as error:  # whatever a user's function raises: it cannot pass through compiled code
            self.failure = self.failure or f"{type(error).__name__}: {error} at t = {x[0]:.6g} s"
            out[:] = np.nan


@dataclass(frozen=True, eq=False)
class UserForce(Force):
    """Apply what a Python function returns, between two markers: for trying out a law before it gets a kernel.

    The compiled step loop calls back into Python: once for every residual and 25 times for every iteration matrix (its
    tangent is by differences). Each call takes some 10 us, a hundred times longer than a force with a kernel. The work
    of the force counts as work of loads.

    Parameters
    ----------
    name : str
    markers : (str, str)
        The force acts on marker b and, opposite, on marker a.
    function : callable, or "module:function" in model files, which is imported only if the file is trusted
        ``function(t, d, v, R, w) -> (force, moment)``, N and N m, on the body of b at its marker, all in the axes of a:
        time, displacement d (3,), m, and velocity v (3,), m/s, of b relative to a, its axes R (3, 3) and its
        angular velocity w (3,), rad/s. It must depend on its arguments only: one call of 32 is made twice, and another
        answer ends the run.
    switches : callable, or "module:function", optional
        ``switches(t, d, v, R, w) -> number or list of numbers``, with the same arguments, each of which changes its
        sign where the force jumps or has a kink: ``lambda t, d, v, R, w: d[2] - 0.1``. Adaptive steps end there, as at
        contacts. It is located to `rtol` times the largest that it has been, whatever its unit.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    function: Any
    switches: Any = None

    holds_turns: ClassVar[bool] = True
    imports: ClassVar[tuple[str, ...]] = ("function", "switches")
    """Fields whose text names code."""
    unseen: ClassVar[str] = (
        "steps do not end where a Python function jumps or has a kink, and may pass over what is short; give the "
        "integrator a `largest` step below what matters, or the force `switches` that pass zero at its corners"
    )
    table: ClassVar[Table] = Table("UserForce", ROW, {"apply": apply, "switch": switch}, switches="switches")

    def __post_init__(self):
        super().__post_init__()
        self.require_marker_pair()
        named = isinstance(self.function, str) and self.function.count(":") == 1
        if not callable(self.function) and not named:
            raise ModelError(
                self.title,
                found=f"function = {self.function!r}",
                expected="a function (t, d, v, R, w) -> (force, moment), or 'module:function'",
                remedy="Write function=lambda t, d, v, R, w: (-100.0 * d, (0, 0, 0))",
            )
        if self.switches is not None:
            named = isinstance(self.switches, str) and self.switches.count(":") == 1
            if not callable(self.switches) and not named:
                raise ModelError(
                    self.title,
                    found=f"switches = {self.switches!r}",
                    expected="a function (t, d, v, R, w) -> number or list of numbers, or 'module:function'",
                    remedy="Write switches=lambda t, d, v, R, w: d[2] - 0.1",
                )
            object.__setattr__(self, "unseen", "")
        object.__setattr__(self, "_callbacks", [])

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def complaint(self) -> str:
        """Return what went wrong in the function, if anything did."""
        return next((c.failure for c in self._callbacks if c.failure), "")  # type: ignore[attr-defined]

    def record(self, compiler):
        """Return the row with the address of the function."""
        function = imported(self.function, self.title)
        self._callbacks.append(_Callback(function))
        a, b = (compiler.marker(name) for name in self.markers)
        length = float(np.linalg.norm(compiler.position(b) - compiler.position(a)))
        address = self._callbacks[-1].address
        found = self._switches(compiler.position(b) - compiler.position(a))
        if found is not None:
            self._callbacks.append(found)
        return {
            "a": a,
            "b": b,
            "pair": compiler.pair(a, b),
            "address": address,
            "length": length or 1.0,
            "switch": 0 if found is None else found.address,
            "switches": 0 if found is None else found.count,
        }

    def _switches(self, d: np.ndarray) -> _Switches | None:
        """Return the C function of the switches; how many there are is asked at a displacement d (3,), at rest."""
        if self.switches is None:
            return None
        function = imported(self.switches, self.title, "switches")
        try:
            count = np.ravel(
                np.asarray(function(0.0, np.array(d, float), np.zeros(3), np.eye(3), np.zeros(3)), float)
            ).size
        except Exception as error:  # whatever a user's function raises
            raise ModelError(
                self.title,
                found=f"its function of switches fails: {type(error).__name__}: {error}",
                expected="a number or a list of numbers",
                remedy="Try it with t = 0, d (3,), v = 0, R = identity (3, 3), w = 0",
            ) from error
        return _Switches(function, count)
