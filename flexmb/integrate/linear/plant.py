"""`Plant`: the linear model between named inputs (signals) and outputs (columns of sensors).

With drives the motion follows the signal s, its velocities s' and its accelerations s'':

    x' = A x + B0 s + B1 s' + B2 s'',   y = C x + D0 s + D1 s' + D2 s''

The state x + (B1 + A B2) s + B2 s' in place of x leaves no rates in the first equation,

    x' = A x + (B0 + A B1 + A A B2) s,   y = C x + (D0 + C B1 + C A B2) s + (D1 + C B2) s' + D2 s''

The rates that are left in y are those with which the output really follows: the velocity of what is driven by a
displacement. Source: Kailath, Linear Systems, 1980, sec. 2.1 (realisations of equations with rates of the input).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError, ValidityWarning
from flexmb.integrate.linear.port_slopes import signal_slopes, state_slopes
from flexmb.integrate.linear.ports import input_ports, output_ports
from flexmb.integrate.linear.spectrum import state_matrix
from flexmb.told import tell

__all__ = ["Plant", "plant_of"]

FASTER, NOTHING, DOUBTFUL = 1.1, 1e-9, 30.0
"""A frequency beyond the fastest pole, the share of the response that is rounding there, and error bounds that are."""
BESIDE = 1e4
"""Ratio of the fastest pole to one that may be lost beside it."""
LOST = 0.01
"""Share of the size of a pole by which the rounding of A may move it without a warning."""
AT_REST = 1e-12
"""Speed in lengths of the model, relative to its fastest pole, that is rounding."""
ACCURATE = 1e-5
"""Error of differences, relative to the largest of an output, and of accelerations beside the exact A, that is told."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plant:
    """x' = A x + B s, y = C x + D s + D1 s' + D2 s'': changes s of signals, and changes y of sensors, from the state.

    Parameters
    ----------
    A, B, C, D : (n, n), (n, m), (p, n), (p, m)
        A follows from the exact tangents; B, C, D from differences of fourth order.
    D1, D2 : (p, m)
        Zero unless an output follows a drive with its rates.
    inputs, outputs : tuple of str
        "part.field" or "part.field.x"; "sensor" or "sensor column".
    units : tuple of str
        Of the outputs.
    poles : (n,), 1/s
        Eigenvalues of A, taken from the `Linearization`, before forces are divided by masses: slow motions of
        heavy parts on stiff meshes are lost in the rounding of A.
    accuracy : (p,)
        Largest error that the differences may have, relative to the largest derivative of each output.
    name : str
        Of the model.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    D1: np.ndarray
    D2: np.ndarray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    poles: np.ndarray
    accuracy: np.ndarray
    name: str = ""

    def __repr__(self):
        return f"Plant({len(self.A)} states; {', '.join(self.inputs)} -> {', '.join(self.outputs)})"

    @property
    def proper(self) -> bool:
        """Does no output follow the rates of an input?"""
        return not (np.any(self.D1) or np.any(self.D2))

    @cached_property
    def lost(self) -> np.ndarray:
        """(n,), 1/s: how far every pole is from the nearest eigenvalue of A, which rounds slow poles to the fastest."""
        if not len(self.A):
            return np.zeros(0)
        found, sizes = np.linalg.eigvals(self.A), np.abs(self.poles)
        far = np.array([np.abs(found - pole).min() for pole in self.poles])
        return np.where(sizes < sizes.max() / BESIDE, far, 0.0)  # equal poles in chains lose digits in eigenvalues only

    def frequency_response(self, frequencies) -> np.ndarray:
        """Return the complex amplitudes of the outputs per unit of the inputs.

        Parameters
        ----------
        frequencies : (nf,), Hz

        Returns
        -------
        (nf, p, m), complex
            C (i w - A)^-1 B + D + i w D1 - w^2 D2.

        Raises
        ------
        ModelError
            A frequency is no finite number, or one at which the plant without damping answers without bound.
        """
        f = np.atleast_1d(np.asarray(frequencies, float))
        if f.ndim != 1 or not np.all(np.isfinite(f)):
            raise ModelError(
                "Plant", found=f"frequencies = {frequencies!r}", expected="finite numbers, Hz", remedy="Correct them"
            )
        sizes = np.abs(self.poles)
        gone = (self.lost > LOST * sizes) & (sizes > NOTHING * sizes.max(initial=0.0))
        if np.any(gone):
            tell(
                f"Plant of model '{self.name}': its pole of {sizes[gone].min():.3g} 1/s is rounded away beside its "
                f"fastest of {sizes.max():.3g} 1/s, and its response there is doubtful; expected: poles of like size. "
                "Use rigid joints in the place of the stiffest springs"
            )
        unit, found = np.eye(len(self.A)), np.zeros((len(f), len(self.outputs), len(self.inputs)), complex)
        for k, w in enumerate(2.0 * np.pi * f):
            try:
                states = np.linalg.solve(1j * w * unit - self.A, self.B)
            except np.linalg.LinAlgError:
                raise ModelError(
                    "Plant",
                    found=f"no bound of the response at {f[k]:.6g} Hz",
                    expected="a frequency at which no undamped or free motion has its pole",
                    remedy="Leave this frequency out, or add damping",
                ) from None
            found[k] = self.C @ states + self.D + 1j * w * self.D1 - w * w * self.D2
        return found

    def to_scipy(self) -> Any:
        """Return a `scipy.signal.StateSpace`; ModelError if an output follows the rates of an input."""
        from scipy.signal import StateSpace

        self.require_proper()
        return StateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """Return a `control.StateSpace` with the names (python-control: ``pip install control``)."""
        self.require_proper()
        try:
            import control
        except ImportError:
            raise FlexmbError(
                "Plant",
                found="python-control is not installed",
                expected="the package control",
                remedy="Run pip install 'flexmb[control]', or use to_scipy()",
            ) from None
        plain = [[_signal_name(name) for name in names] for names in (self.inputs, self.outputs)]
        return control.ss(self.A, self.B, self.C, self.D, inputs=plain[0], outputs=plain[1])

    def require_proper(self) -> None:
        """Raise ModelError with the names if an output follows the rates of an input."""
        rates = np.argwhere((self.D1 != 0.0) | (self.D2 != 0.0))
        if len(rates):
            output, source = self.outputs[rates[0, 0]], self.inputs[rates[0, 1]]
            raise ModelError(
                "Plant",
                found=f"output '{output}' follows the rates of the input '{source}', which no state space can say",
                expected="outputs that follow the inputs themselves",
                remedy="Leave this output or input out; frequency_response() and D1, D2 know the rates",
            )

    def with_proper_outputs(self) -> Plant:
        """Return the plant of the outputs that follow no rates of an input; ModelError if there is none."""
        kept = np.flatnonzero(~np.any((self.D1 != 0.0) | (self.D2 != 0.0), axis=1))
        if not len(kept):
            self.require_proper()
        rows = {name: getattr(self, name)[kept] for name in ("C", "D", "D1", "D2", "accuracy")}
        outputs, units = (tuple(names[k] for k in kept) for names in (self.outputs, self.units))
        return replace(self, outputs=outputs, units=units, **rows)


def _signal_name(name: str) -> str:
    """Return a name without the dots, which python-control takes for the name of a system before its signal."""
    return name.replace(".", "_")


def plant_of(system, state, linear, inputs, outputs) -> Plant:
    """Return the plant of a `Linearization` about a state at rest."""
    sources, targets = input_ports(system.model, inputs), output_ports(system.model, outputs)
    for what, ports, part in (("input", sources, "a signal"), ("output", targets, "a sensor")):
        if not ports:
            raise ModelError(
                "linearize", found=f"no {what}", expected=f"{part} of the model at least", remedy=f"Name or add {part}"
            )
    fastest = float(np.abs(linear.eigenvalues).max(initial=0.0))
    # drives at their crest move by rounding
    if np.any((np.abs(state.u) * system.units > AT_REST * fastest)[~system.is_state]):
        raise ModelError(
            "linearize",
            found="inputs or outputs about a state that moves",
            expected="a state at rest: outputs in fixed axes change with time where bodies move",
            remedy="Give the result of fmb.statics(model), or leave inputs and outputs out",
        )
    nz, n = linear.Q.shape
    velocities = linear.velocities
    A = state_matrix(linear)
    own = state_slopes(system, state, linear.basis, velocities, targets)
    inverse = np.linalg.pinv(velocities)
    _compare(system.model.name, linear, inverse @ own.a)
    p, m = len(targets), len(sources)
    B, D, doubt = np.zeros((3, nz + n, m)), np.zeros((3, p, m)), np.zeros((3, p, m))
    error, size = own.error.max(axis=1, initial=0.0), np.abs(own.y).max(axis=1, initial=0.0)
    for k, source in enumerate(sources):
        _, slopes = signal_slopes(system, state, source, targets)
        B[:, nz:, k], D[:, :, k] = (inverse @ slopes.a).T, slopes.y.T
        doubt[:, :, k] = slopes.error.T
        doubt[1, :, k] += own.error @ np.abs(B[2, :, k])
        error = np.maximum(error, slopes.error.max(axis=1))
        size = np.maximum(size, np.abs(slopes.y).max(axis=1))
    accuracy = np.divide(error, size, out=np.zeros(p), where=size > 0.0)
    for target, share in zip(targets, accuracy, strict=True):
        if share > ACCURATE:
            _warn(system.model.name, f"the slopes of '{target.name}' are accurate to {share:.1e} only")
    C = own.y
    direct = D[0] + C @ (B[1] + A @ B[2])
    entering = B[0] + A @ (B[1] + A @ B[2])
    D1, D2 = _rates(A, entering, C, direct, [D[1] + C @ B[2], D[2]], doubt)
    return Plant(
        A=A,
        B=entering,
        C=C,
        D=direct,
        D1=D1,
        D2=D2,
        inputs=tuple(port.name for port in sources),
        outputs=tuple(port.name for port in targets),
        units=tuple(port.unit for port in targets),
        poles=_all(linear.eigenvalues, len(A)),
        accuracy=accuracy,
        name=system.model.name,
    )


def _all(eigenvalues: np.ndarray, n: int) -> np.ndarray:
    """Return all n poles from one of each pair: the others are conjugates, and the speeds of motions that continue."""
    pairs = eigenvalues[eigenvalues.imag != 0.0]
    known = np.concatenate([eigenvalues, pairs.conj()])
    return np.concatenate([np.zeros(n - len(known)), known])


def _rates(A, B, C, D, found, doubt) -> list[np.ndarray]:
    """Return the terms (p, m) of first and second rates, zero where they are rounding.

    That is where they are not larger than their doubt, or beyond the fastest pole still nothing beside the response.
    """
    w = FASTER * float(np.abs(np.linalg.eigvals(A)).max(initial=0.0)) or 1.0
    size = np.abs(C @ np.linalg.solve(1j * w * np.eye(len(A)) - A, B) + D)
    size = size + w * np.abs(found[0]) + w * w * np.abs(found[1])
    return [
        np.where((np.abs(x) > DOUBTFUL * doubt[k]) & (w**k * np.abs(x) > NOTHING * size), x, 0.0)
        for k, x in enumerate(found, start=1)
    ]


def _compare(name: str, linear, found: np.ndarray) -> None:
    """Warn if the accelerations (n, nz + n) of small changes differ from the exact tangents."""
    nz, n = linear.Q.shape
    exact = state_matrix(linear)[nz:]
    stiff = np.abs(exact[:, :nz]).max(initial=0.0)
    sizes = (stiff, max(np.abs(exact[:, nz:]).max(initial=0.0), np.sqrt(stiff)))
    for part, size in zip((slice(0, nz), slice(nz, nz + n)), sizes, strict=True):
        miss = np.abs(found[:, part] - exact[:, part]).max(initial=0.0)
        if miss > ACCURATE * size and size > 0.0:
            _warn(name, f"accelerations of small changes differ from the tangents by {miss / size:.1e}")


def _warn(name: str, what: str) -> None:
    warnings.warn(
        f"Model '{name}', linearize: {what}. Expected: {ACCURATE:g}. The state is near a kink (a contact, a stop, "
        "friction at rest) or no equilibrium: start from fmb.statics(model), and compare with a short simulation",
        ValidityWarning,
        stacklevel=4,
    )
