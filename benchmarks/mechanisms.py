"""Work and precision of rigid mechanisms: error against run time, this package's integrators and Exudyn's in one run.

    python benchmarks/mechanisms.py                       # all cases, some four minutes
    python benchmarks/mechanisms.py --quick               # small cases only
    python benchmarks/mechanisms.py --cases chain         # those whose name contains a word
    python benchmarks/mechanisms.py --json out.json --plot out.png

Cases: the Andrews mechanism, Bricard's mechanism, N four-bar linkages in a row, and a chain of N links on ball joints
that falls from a helix. The error is the largest distance of a body from its place in the reference at the end: the
closed equation of one freedom for the four-bars, else DOP853 at tolerances of 1e-11. The time is CPU time of the
integration on one thread, the median of some runs, without preparation of the model and without compilation. The peer
gets planar bodies for planar mechanisms, joints without redundant equations, and the fastest of its linear solvers,
Newton variants and nodes.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 (one thread: set before it is loaded)

import flexmb as fmb  # noqa: E402
from flexmb.system import assemble  # noqa: E402

TESTS = Path(__file__).parents[1] / "tests"
sys.path.insert(0, str(TESTS))

from verification import mechanisms  # noqa: E402 (the models are those of the verification cases)


def case_data(name: str) -> dict:
    """Return a reference case."""
    return json.loads((TESTS / "data" / "validation" / f"{name}.json").read_text("utf-8"))


def chain(n: int) -> fmb.Model:
    """Return a chain of n round links of 0.1 m and 0.1 kg on ball joints, on a helix, at rest."""
    k = np.arange(n)
    x = np.stack([np.ones(n), 0.3 * np.sin(0.5 * k), 0.3 * np.cos(0.5 * k)], axis=1)
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    R, ends = np.stack([x, y, np.cross(x, y)], axis=2), 0.1 * np.cumsum(x, axis=0)
    links = [
        fmb.RigidBody(
            f"l{i}",
            mass=0.1,
            inertia=(5e-6, 8.6e-5, 8.6e-5),
            at=ends[i] - 0.05 * x[i],
            rotation=R[i],
            markers={"start": (-0.05, 0, 0), "end": (0.05, 0, 0)},
        )
        for i in range(n)
    ]
    names = ["ground.origin"] + [f"l{i}.end" for i in range(n)]
    joints = [fmb.Spherical(f"j{i}", markers=(names[i], f"l{i}.start")) for i in range(n)]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *links], joints=joints)


@dataclass
class Case:
    """A mechanism, how long it moves, the steps of both programs and the tolerances of ours."""

    name: str
    model: fmb.Model
    t_end: float
    steps: tuple[int, ...]
    tolerances: tuple[float, ...]
    reference: Any = None
    planar: bool = False
    free: Any = None
    repeats: int = 5
    explicit: tuple[float, ...] = ()
    """Tolerances of the explicit method in coordinates of the bodies, where they are not those of the others."""
    joints: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9)
    """Tolerances of the explicit method in joint coordinates."""
    ida: bool = True
    """Is `IDA` run? With 400 four-bars it takes several minutes."""


def cases(quick: bool) -> list[Case]:
    """Return the cases."""
    tolerances = (1e-3, 1e-5, 1e-7, 1e-9)
    fine = (250, 1000, 4000)
    made = [
        Case("Andrews", mechanisms.andrews(case_data("RB03")), 0.03, (500, 2000, 8000), tolerances, planar=True),
        Case("Bricard", mechanisms.bricard(case_data("RB04")), 5.0, fine, tolerances, free={"j5": [1, 1, 1, 1, 0, 0]}),
    ]
    for n in (10, 40) if quick else (10, 40, 400):
        made.append(
            Case(
                f"four-bars {n}",
                mechanisms.four_bars(n),
                1.5,
                (60, 250, 1000) if n > 10 else (60, 250, 1000, 4000),
                tolerances,
                mechanisms.four_bar_places(n, 1.5),
                planar=True,
                repeats=1 if n > 40 else 3,
                explicit=(1e-3, 1e-5) if n > 10 else (),
                ida=n < 400,
            )
        )  # tighter ones step onto the singular position
    for n in (10, 100) if quick else (10, 100, 1000):
        made.append(
            Case(
                f"chain {n}",
                chain(n),
                0.5,
                (100, 400, 1600) if n < 1000 else (400, 1000),
                (1e-3, 1e-5, 1e-7),
                repeats=3 if n < 1000 else 1,
            )
        )
    return made


class Ours:
    """A case in this package, assembled once."""

    def __init__(self, case: Case):
        self.t_end, self.repeats = case.t_end, case.repeats
        self.system, self.start = assemble(replace(case.model, sensors=()))
        self.work = self.system.workspace()

    def run(self, integrator, repeats: int | None = None):
        """Return the places of all bodies (n, 3), the median of seconds, and the statistics; None if it fails."""
        times, spent = np.array([0.0, self.t_end]), []
        for _ in range(self.repeats if repeats is None else repeats):
            start = self.start._replace(**{name: getattr(self.start, name).copy() for name in ("q", "u", "a", "lam")})
            variables = integrator.start(self.system, start, self.work, self.t_end)
            began = time.process_time()
            outcome = integrator.run(self.system, self.work, variables, times, 0, 2)
            spent.append(time.process_time() - began)
            if outcome.failure:
                return None
        first = self.system.program.frames[:, 0]
        places = outcome.rows["q"][-1][first[:, None] + np.arange(3)]
        return places, float(np.median(spent)), integrator.statistics(variables)


def our_curves(case: Case, ours: Ours, reference: np.ndarray) -> dict[str, list[dict]]:
    """Return the points of every integrator."""
    alpha = "generalized-alpha"
    settings = {
        f"{alpha}, fixed": [fmb.GeneralizedAlpha(step=case.t_end / n) for n in case.steps],
        f"{alpha}, adaptive": [fmb.GeneralizedAlpha(rtol=tol) for tol in case.tolerances],
        "IDA": [fmb.IDA(rtol=tol, atol=0.1 * tol) for tol in case.tolerances if case.ida],
        "DOP853": [fmb.Explicit(rtol=tol, atol=0.1 * tol) for tol in case.explicit or case.tolerances],
        "DOP853, joint coordinates": [
            fmb.Explicit(rtol=tol, atol=0.1 * tol, formulation=fmb.Recursive()) for tol in case.joints
        ],
    }
    curves: dict[str, list[dict]] = {}
    for name, integrators in settings.items():
        points = curves[name] = []
        for integrator in integrators:
            result = ours.run(integrator)
            if result is None:  # a step that is too large to converge
                continue
            points.append({"error": float(np.abs(result[0] - reference).max()), "seconds": result[1], **result[2]})
    return curves


def peer_curve(case: Case, reference: np.ndarray) -> list[dict]:
    """Return the points of Exudyn with the fastest of its settings."""
    from exudyn_model import Peer

    kinds = ["RotationEulerParameters"] if case.planar else ["RotationEulerParameters", "RotationRotationVector"]
    peers = {node: Peer(case.model, case.planar, case.free, node) for node in kinds}
    size = len(case.model.bodies)  # dense matrices, and new ones in every iteration, only pay in small models
    options = [
        (node, modified, dense)
        for node in kinds
        for modified in ((True, False) if size < 500 else (True,))
        for dense in ((False,) if size > 60 else (False, True))
    ]
    share = 0.1 if size > 500 else 1.0
    probe = {
        option: peers[option[0]].run(share * case.t_end, int(share * case.steps[0]), *option[1:]) for option in options
    }
    working = {option: seconds for option, seconds in probe.items() if np.isfinite(seconds)}
    if not working:
        return []
    node, modified, dense = min(working, key=working.__getitem__)
    points = []
    for steps in case.steps:
        spent = [peers[node].run(case.t_end, steps, modified, dense) for _ in range(case.repeats)]
        if np.isfinite(spent[0]):
            error = float(np.abs(peers[node].positions() - reference).max())
            points.append(
                {
                    "error": error,
                    "seconds": float(np.median(spent)),
                    "steps": steps,
                    "node": node,
                    "modified Newton": modified,
                    "dense": dense,
                }
            )
    return points


def seconds_at(points: list[dict], error: float) -> float:
    """Return the least time for an error: that of a point that is better, or interpolated;
    infinite if none reaches it.
    """
    pairs = sorted((p["error"], p["seconds"]) for p in points if p["error"] > 0.0)
    if not pairs or pairs[0][0] > error:
        return float("inf")
    x, y = np.log(np.array(pairs)).T
    return float(min(np.exp(np.interp(np.log(error), x, y)), *(s for e, s in pairs if e <= error), np.inf))


def of_order_two(points: list[dict], error: float) -> float:
    """Return the time of a method of second order for an error that is smaller than those of its points."""
    best = min(points, key=lambda p: p["error"])
    return best["seconds"] * np.sqrt(best["error"] / error)


def ratios(curves: dict[str, list[dict]], peer: list[dict]) -> dict[str, float]:
    """Return peer's time over ours at the same error (decades), with the best of our integrators.

    Below the errors of the peer's runs its times follow from its order (marked by ~), three decades at most.
    """
    found: dict[str, float] = {}
    if not peer:
        return found
    errors = [p["error"] for p in peer]
    for exponent in range(-3, -12, -1):
        wanted = 10.0**exponent
        mine = min(seconds_at(points, wanted) for points in curves.values())
        inside = wanted >= min(errors)
        if np.isfinite(mine) and 1e-3 * min(errors) <= wanted <= max(errors):
            found[f"{'' if inside else '~'}1e{exponent}"] = (
                seconds_at(peer, wanted) if inside else of_order_two(peer, wanted)
            ) / mine
    return found


def compare(case: Case, with_peer: bool) -> dict:
    """Run a case and return everything measured."""
    ours = Ours(case)
    reference = case.reference
    if reference is None:
        last = 1e-11 if len(case.model.bodies) < 500 else 1e-9
        tight = fmb.Explicit(rtol=last, atol=0.1 * last)
        reference = ours.run(tight, 1)[0]
    curves = our_curves(case, ours, reference)
    peer = peer_curve(case, reference) if with_peer else []
    bodies = len(case.model.bodies) - 1
    fixed = curves["generalized-alpha, fixed"][-1]  # the finest steps converge in every case
    per = 1e6 * fixed["seconds"] / fixed["iterations"] / bodies
    result = {
        "case": case.name,
        "bodies": bodies,
        "us per body and iteration": per,
        "ours": curves,
        "peer": peer,
        "ratio": ratios(curves, peer),
    }
    report(result)
    return result


def report(result: dict) -> None:
    """Print a case."""
    print(f"{result['case']}: {result['us per body and iteration']:.2f} us per body and iteration")
    for name, points in [*result["ours"].items(), ("Exudyn", result["peer"])]:
        row = "  ".join(f"{p['error']:.1e} m {1e3 * p['seconds']:.1f} ms" for p in points)
        print(f"  {name:28s} {row}")
    print(
        "  faster than the peer at equal error: " + ", ".join(f"{k} m: {v:.1f}" for k, v in result["ratio"].items()),
        flush=True,
    )


def seconds_and_errors(points: list[dict]) -> tuple[list[float], list[float]]:
    """Return the two coordinates of a curve."""
    return [p["seconds"] for p in points], [p["error"] for p in points]


def plot(results: list[dict], path: Path) -> None:
    """Draw error against time of every case."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    columns = 4 if len(results) > 6 else 3
    rows = -(-len(results) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(3.4 * columns, 3.0 * rows), squeeze=False, layout="constrained")
    names = list(dict.fromkeys(name for result in results for name in result["ours"]))
    colours = dict(zip(names, ("C0", "C9", "C2", "C1", "C3"), strict=False))
    for axis, result in zip(axes.flat, results, strict=False):
        for name, points in result["ours"].items():
            axis.loglog(*seconds_and_errors(points), "o-", ms=3, color=colours[name], label=name)
        if result["peer"]:
            axis.loglog(*seconds_and_errors(result["peer"]), "s--", ms=4, color="k", label="Exudyn, generalized-alpha")
        axis.set_title(result["case"], fontsize=10)
        axis.grid(alpha=0.3)
        axis.xaxis.set_minor_formatter("")
        axis.set_xlabel("CPU time, s")
        axis.set_ylabel("error, m")
    for axis in axes.flat[len(results) :]:
        axis.set_axis_off()
    shown = {
        label: handle for axis in axes.flat for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=5, fontsize=9)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small cases only")
    parser.add_argument("--cases", default="", help="only cases whose name contains this")
    parser.add_argument("--no-peer", action="store_true")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--again", type=Path, help="print and draw what an earlier run has saved")
    options = parser.parse_args()
    if options.again:
        results = [{**r, "ratio": ratios(r["ours"], r["peer"])} for r in json.loads(options.again.read_text("utf-8"))]
        for result in results:
            report(result)
        if options.plot:
            plot(results, options.plot)
        return
    try:
        import exudyn  # noqa: F401
    except ImportError:
        options.no_peer = True
        print("Exudyn is not installed: pip install exudyn")
    chosen = [case for case in cases(options.quick) if options.cases in case.name]
    for model in (mechanisms.bricard(case_data("RB04")), chain(3)):  # compiles
        small = Case("small", model, 1e-3, (2,), (1e-3,))
        our_curves(small, Ours(small), np.zeros((len(model.bodies) - 1, 3)))
    results: list[dict] = []
    for case in chosen:
        results.append(compare(case, not options.no_peer))
        if options.json:
            options.json.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    if options.plot and results:
        plot(results, options.plot)


if __name__ == "__main__":
    main()
