"""AN11: a right-angle frame of a thin, deep section buckles out of its plane under an in-plane load at its free end.

Reference: published critical loads, Argyris et al. 1979; Simo & Vu-Quoc 1986. Lengths in mm, forces in N.
"""

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

import flexmb as fmb
from flexmb import fem
from flexmb.integrate.matrices import tangent_at


def lowest_stiffness(case, load):
    """Return the lowest eigenvalue of K against M at the plane equilibrium, on the motions that the joints permit."""
    model = case["model"]
    leg, deep, thin = model["leg"], 30.0, 0.6
    section = fem.Section.rectangle(deep, thin, poisson=model["nu"])  # y is the deep direction
    material = fmb.Material(young=model["E"], poisson=model["nu"], density=1e-6)
    first = fmb.AncfBeam("first", points=((0, 0, 0), (leg, 0, 0)), elements=8, section=section, material=material)
    second = fmb.AncfBeam(
        "second",
        points=((leg, 0, 0), (leg, -leg, 0)),
        elements=8,
        section=section,
        orientation=(1, 0, 0),
        material=material,
    )
    axes = {name: second.marker_poses()[name].matrix for name in ("start", "end")}
    turned = fmb.AncfBeam(
        "second",
        points=((leg, 0, 0), (leg, -leg, 0)),
        elements=8,
        section=section,
        orientation=(1, 0, 0),
        material=material,
        markers={"start": (0.0, axes["start"].T)},
    )
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), first, turned),
            gravity=(0, 0, 0),
            joints=(
                fmb.Fixed("clamp", markers=("ground.origin", "first.start")),
                fmb.Fixed("corner", markers=("first.end", "second.start")),
            ),
            forces=(fmb.PointLoad("P", marker="second.end", force=(load, 0, 0)),),
        )
    )
    system, final = solution.phases[-1].system, solution.final
    tangent = tangent_at(system, system.state(0.0, final.q, lam=final.lam), system.workspace())
    Z = null_space(tangent.G.toarray())
    K, M = (Z.T @ x.toarray() @ Z for x in (tangent.K, tangent.M))
    return eigh(0.5 * (K + K.T), M, eigvals_only=True, subset_by_index=[0, 0])[0]


def test_critical_load(reference):
    """2 %: where the lowest stiffness vanishes, interpolated between 1.0 and 1.07 N."""
    case = reference("AN11")
    loads = np.array([1.0, 1.07])
    low = np.array([lowest_stiffness(case, load) for load in loads])
    critical = loads[0] - low[0] * (loads[1] - loads[0]) / (low[1] - low[0])
    assert critical == pytest.approx(case["reference"]["P_cr_tip_load_N"], rel=0.02)
