"""Analyses of a mechanism as it is seen, with results back in the metres, kilograms and seconds of the plain one."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from metamorphic.seen import PLAIN, Seen

import flexmb as fmb

END = 0.1
"""s: how long a motion is followed."""
SAMPLES = 11
STEP = 1e-3
TIGHT = 1e-8
SLOW = 1e-3
"""m/s, a thousandth of what gravity gives in that time: speeds of a mechanism that is held are rounding."""


def _absolute(s: Seen) -> float | None:
    """Return the absolute tolerance of rates that are small because their unit of time is long; else the usual one.

    1e-10 m of a stiff shape is a force that counts.
    """
    return None if s.time <= 1.0 else 1e-10 * min(1.0, s.length) / s.time


INTEGRATORS = {
    "steps": lambda s: fmb.GeneralizedAlpha(step=STEP * s.time),
    "GeneralizedAlpha": lambda s: fmb.GeneralizedAlpha(rtol=1e-7),
    "adaptive": lambda s: fmb.GeneralizedAlpha(rtol=1e-7),
    "IDA": lambda s: fmb.IDA(rtol=TIGHT, atol=1e-2 * TIGHT * min(1.0, s.length) * min(1.0, 1.0 / s.time)),
    "Explicit": lambda s: fmb.Explicit(rtol=TIGHT),
    "Implicit": lambda s: fmb.Implicit(rtol=1e-6),
    "elastic": lambda s: fmb.GeneralizedAlpha(rtol=1e-7),
    "stiff": lambda s: fmb.Implicit(rtol=1e-7),
    "Recursive": lambda s: fmb.Explicit(rtol=TIGHT, atol=_absolute(s), formulation=fmb.Recursive()),
}
FORMULATIONS = {
    "Augmented": fmb.Augmented,
    "NullSpace": fmb.NullSpace,
    "UdwadiaPhohomsiri": fmb.UdwadiaPhohomsiri,
    "tree": fmb.Recursive,
}
ANALYSES = (*INTEGRATORS, *FORMULATIONS, "statics", "linearize")
OF_DRIVEN = ("kinematics",)
"""What takes driven trees alone."""

WITHOUT_TIME = (*FORMULATIONS, "linearize")
"""What looks at the start as described."""

Results = Mapping[str, np.ndarray]


def _of_sensors(solution: fmb.Solution, seen: Seen) -> dict[str, np.ndarray]:
    found = {}
    for sensor in solution.model.sensors:
        name = sensor.name.removeprefix(seen.prefix)
        values = solution[sensor.name]
        kind = type(sensor).__name__
        if kind == "Position":
            found[name] = seen.place_back(values)
        elif kind == "Velocity":
            found[name] = seen.vector_back(values, seen.length / seen.time)
        elif kind in ("Reaction", "ForceOf"):
            found[f"{name}, force"] = seen.vector_back(values[:, :3], seen.force)
            found[f"{name}, moment"] = seen.moment_back(values[:, 3:])
        elif kind == "Energy":
            found[f"{name} energy"] = (values - values[0]) / seen.energy  # where potential is zero does not matter
    return found


def analysed(model: fmb.Model, how: str, seen: Seen = PLAIN, end: float = END) -> dict[str, np.ndarray]:
    """Return results of an analysis by name, in plain metres, kilograms and seconds."""
    begin = seen.t * seen.time
    times = begin + np.linspace(0.0, end * seen.time, SAMPLES)
    if how == "kinematics":
        return _of_sensors(fmb.kinematics(model, float(times[-1]), t_start=begin, samples=times), seen)
    if how in INTEGRATORS:
        solution = fmb.simulate(
            model, float(times[-1]), t_start=begin, samples=SAMPLES, integrator=INTEGRATORS[how](seen)
        )
        return _of_sensors(solution, seen)
    if how == "statics":
        with warnings.catch_warnings():
            warnings.filterwarnings("error", "(?s).*the equilibrium is unstable", fmb.ValidityWarning)
            solution = fmb.statics(model, t=seen.t * seen.time)
        # a body may turn about its own axis without a force: the place of such a body is no result
        kept = ("force", "energy")
        return {name: values[-1:] for name, values in _of_sensors(solution, seen).items() if name.endswith(kept)}
    if how == "linearize":
        return {"frequencies": np.sort(fmb.linearize(model).frequencies) * seen.time}
    found = fmb.accelerations(model, formulation=FORMULATIONS[how]())
    results = {}
    for name, wrench in found.reactions.items():
        results[f"{name.removeprefix(seen.prefix)}, force"] = seen.vector_back(wrench[:3], seen.force)[None]
        results[f"{name.removeprefix(seen.prefix)}, moment"] = seen.moment_back(wrench[3:])[None]
    for body in model.bodies:
        name, a = body.name.removeprefix(seen.prefix), found[body.name]
        if body.has_frame:  # that of its origin would depend on the choice of its origin
            spin = np.linalg.det(seen.S) * seen.vector_back(a[3:], 1.0 / seen.time**2)
            results[f"{name}, spin"] = spin[None]
        elif body.n_velocities:
            results[f"{name}, acceleration"] = seen.vector_back(a[:3], seen.length / seen.time**2)[None]
    return results


def worst_difference(a: Results, b: Results) -> tuple[float, str]:
    """Return the largest difference of two results, relative to the largest value of its kind, and its name."""
    worst, where = 0.0, "none"
    scales: dict[str, float] = {}
    for name, values in a.items():
        kind = name.rpartition(" ")[2]
        scales[kind] = max(scales.get(kind, 0.0), float(np.abs(values).max(initial=0.0)))
    scales["moment"] = max(scales.get("moment", 0.0), 0.3 * scales.get("force", 0.0))
    scales["acceleration"] = max(scales.get("acceleration", 0.0), 0.3 * scales.get("spin", 0.0), 9.0)
    scales["spin"] = max(scales.get("spin", 0.0), 3.0 * scales["acceleration"])
    scales["energy"] = max(
        scales.get("energy", 0.0), 1e-3
    )  # J, a thousandth of what these weights have over these sizes
    scales["speed"] = max(scales.get("speed", 0.0), SLOW)
    scales["frequencies"] = max(scales.get("frequencies", 0.0), 1.0)  # Hz, about that of gravity over these sizes
    for name in a.keys() | b.keys():
        if name not in a or name not in b or a[name].shape != b[name].shape:
            return np.inf, f"{name}: one of them does not have it"
        apart = float(np.abs(a[name] - b[name]).max(initial=0.0))
        scale = scales[name.rpartition(" ")[2]]
        share = apart / scale if scale > 0.0 else 0.0
        if not np.isfinite(apart):
            return np.inf, f"{name}: not finite"
        if share > worst:
            worst, where = share, name
    return worst, where
