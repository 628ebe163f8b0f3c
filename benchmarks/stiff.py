"""Stiff trees: error against run time of `Implicit`, `IDA` and `GeneralizedAlpha`, in one run.

    python benchmarks/stiff.py

Two steel beams of 1 m that fall on hinges (modes up to 3 kHz, little damping, 0.2 s); four rods of 1 m, the first on a
free hinge, the others on hinges with 1e5 N m/rad and 200 N m s/rad (overdamped, 1 s); a rod on a hinge with a bead held
to it by damped springs of 1e6 and 1e5 N/m (1 s). The error is that of the end's place against `Implicit(rtol=1e-11)`;
IDA with rtol=1e-10 comes to the same place within the number printed with the name. CPU time of one thread, kernels
compiled.
"""

from __future__ import annotations

import os
import time

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")


def beams():
    """Return two reduced steel beams on hinges."""
    import numpy as np

    import flexmb as fmb
    from flexmb import fem, reduction

    points = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6), np.zeros(6)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.05, 0.05), material=fmb.MATERIALS["steel"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [5]}, modes=3, geometric_stiffness=True)
    bodies = [fmb.FloatingBody(f"f{k}", data=data, at=(k, 0, 0), damping=0.01) for k in range(2)]
    ends = ("ground.origin", "f0.tip")
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(2)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *bodies], joints=joints), 0.2, "f1.tip"


def hinges():
    """Return four rods on a free hinge and three overdamped ones."""
    import flexmb as fmb

    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.05, at=(k, 0, 0)) for k in range(4)]
    ends = ["ground.origin"] + [f"b{k}.end" for k in range(3)]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.start")) for k in range(4)]
    forces = [fmb.TorsionSpring(f"k{k}", joint=f"j{k}", stiffness=1e5, damping=200.0) for k in range(1, 4)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *rods], joints=joints, forces=forces), 1.0, "b3.end"


def bead():
    """Return a rod on a hinge with a free bead at its end, held by stiff springs."""
    import flexmb as fmb

    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.02)
    free = fmb.RigidBody.sphere("bead", radius=0.05, density=1000.0, at=(1.0, 0, 0))
    forces = [
        fmb.SpringDamper("out", markers=("ground.origin", "bead.center"), stiffness=1e6, damping=20.0, length=1.0),
        fmb.SpringDamper("along", markers=("rod.center", "bead.center"), stiffness=1e5, damping=20.0, length=0.5),
    ]
    joints = [fmb.Revolute("A", markers=("ground.origin", "rod.start"))]
    return (
        fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), rod, free], joints=joints, forces=forces),
        1.0,
        "bead.center",
    )


def place(model, t_end: float, marker: str, integrator):
    """Return where the marker is at the end, m, and the CPU time, s."""
    import flexmb as fmb

    clock = time.process_time()
    solution = fmb.simulate(model, t_end, samples=2, integrator=integrator)
    spent = time.process_time() - clock
    return solution[fmb.Position("end", marker=marker)][-1], spent


def main() -> None:
    """Print the table."""
    import numpy as np

    import flexmb as fmb

    methods = [fmb.Implicit(rtol=rtol) for rtol in (1e-4, 1e-6, 1e-8)]
    methods += [fmb.IDA(rtol=rtol, atol=0.01 * rtol) for rtol in (1e-4, 1e-6, 1e-8)]
    methods += [fmb.GeneralizedAlpha(rtol=rtol) for rtol in (1e-6, 1e-8)]
    for case in (beams, hinges, bead):
        model, t_end, marker = case()
        exact, _ = place(model, t_end, marker, fmb.Implicit(rtol=1e-11))
        other, _ = place(model, t_end, marker, fmb.IDA(rtol=1e-10, atol=1e-12))
        print(f"{case.__name__}: references agree to {np.linalg.norm(other - exact):.1e} m")
        for method in methods:
            place(model, 0.02 * t_end, marker, method)
            runs = [place(model, t_end, marker, method) for _ in range(3)]
            spent = sorted(seconds for _, seconds in runs)[1]
            error = np.linalg.norm(runs[0][0] - exact)
            print(f"  {type(method).__name__:17} rtol {method.rtol:.0e}  error {error:.1e} m  {spent:.3f} s")


if __name__ == "__main__":
    main()
