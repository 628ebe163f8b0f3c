"""Plates from meshes, lumped masses, sensors, inversion, files for ParaView."""

import re

import numpy as np
import pytest
import pyvista
from bodies.ancf_states import SOFT

import flexmb as fmb
from flexmb import fem
from flexmb.errors import IntegrationError, ModelError
from flexmb.system import compile
from flexmb.system.program import evaluate

KINDS = pytest.mark.parametrize("shear", [False, True], ids=["thin", "shear"])


def plate(**fields):
    return fmb.AncfPlate.rectangle(
        "p", **{"edges": (2.0, 1.0), "elements": (4, 2), "thickness": 0.1, "material": SOFT, **fields}
    )


def quads(ns, nt, rng=None):
    """A mesh of ns by nt quadrilaterals, with node numbers, order and sense of the cells mixed by `rng`."""
    s, t = np.meshgrid(np.arange(ns + 1.0), np.arange(nt + 1.0), indexing="ij")
    points = np.stack([s.ravel(), t.ravel(), 0.1 * s.ravel() ** 2], axis=1)
    n = np.arange(points.shape[0]).reshape(ns + 1, nt + 1)
    cells = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)
    if rng is not None:
        new = rng.permutation(len(points))
        points = points[np.argsort(new)]
        cells = np.array([np.roll(c, k) for c, k in zip(new[cells], rng.integers(4, size=len(cells)), strict=True)])
        cells = rng.permutation(cells)
    return fem.Mesh(points=points, cells=(("quad", cells),), cell_sets={"skin": (np.arange(len(cells)),)})


def test_grid_of_a_mesh_is_found_again(rng):
    body = fmb.AncfPlate.from_mesh("p", quads(4, 3, rng), thickness=0.1, material=SOFT, group="skin")
    assert sorted(body.elements) == [3, 4]
    found = body.points.reshape(-1, 3)
    np.testing.assert_allclose(sorted(map(tuple, found)), sorted(map(tuple, quads(4, 3).points)))
    steps = [np.linalg.norm(np.diff(body.points[..., :2], axis=k), axis=-1) for k in (0, 1)]
    np.testing.assert_allclose(np.concatenate([x.ravel() for x in steps]), 1.0)
    assert np.all(body.surface.normals[:, 2] > 0.0)  # as the cells are ordered


def ring():
    mesh = quads(4, 1)
    cells = mesh.cells[0][1].copy()
    cells[cells >= 8] -= 8
    return fem.Mesh(points=mesh.points[:8], cells=(("quad", cells),))


MESHES = {
    "triangles": (
        lambda: fem.Mesh(points=np.eye(3), cells=(("triangle", np.array([[0, 1, 2]])),)),
        None,
        "a mesh of triangle",
    ),
    "group": (lambda: quads(2, 2), "wing", "has no group 'wing'"),
    "ring": (ring, None, "4 quadrilaterals, of which 0 lie in rows"),
    "step": (
        lambda: fem.Mesh(points=quads(2, 2).points, cells=(("quad", quads(2, 2).cells[0][1][:3]),)),
        None,
        "3 quadrilaterals, of which",
    ),
}


@pytest.mark.parametrize(("mesh", "group", "found"), MESHES.values(), ids=MESHES)
def test_meshes_that_are_no_grid(mesh, group, found):
    with pytest.raises(ModelError, match="Body 'p'") as error:
        fmb.AncfPlate.from_mesh("p", mesh(), thickness=0.1, material=SOFT, group=group)
    assert found in str(error.value)


@KINDS
def test_lumped_mass(shear):
    """The weight that a clamped plate feels, and its moment, are those of plate and mass."""
    body, supports, clamps = plate(
        shear=shear,
        lumped_masses=[((0.75, 0.3), 5.0)],
        material=fmb.MATERIALS["steel"],
    ).held("root", "s0", fmb.Fixed)
    own = 7850.0 * 0.2
    assert body.mass == pytest.approx(own + 5.0, rel=1e-12)
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=supports), body),
            joints=clamps,
            gravity=(0, 0, -10.0),
            sensors=tuple(fmb.Reaction(j.name, joint=j.name) for j in clamps),
        )
    )
    wrench = np.array([solution[j.name][-1] for j in clamps])
    assert wrench[:, 2].sum() == pytest.approx(10.0 * body.mass, rel=1e-7)
    arms = np.array([supports[j.name].at for j in clamps])
    moment = (wrench[:, 3:] + np.cross(arms, wrench[:, :3])).sum(axis=0)
    expected = 10.0 * (own * np.array([0.5, -1.0]) + 5.0 * np.array([0.3, -1.5]))
    np.testing.assert_allclose(moment[:2], expected, rtol=1e-4)  # the plate sags a little


@pytest.mark.parametrize("masses", [[(0.5, 2.0)], [((0.5, 1.5), 2.0)], [((0.5, 0.5), -1.0)]])
def test_lumped_mass_refused(masses):
    with pytest.raises(ModelError, match="Body 'p': lumped mass"):
        plate(lumped_masses=masses)


@KINDS
def test_resultants_of_a_cantilever(shear):
    """Under an end force, M11 falls linearly to the end, Q1 is the force per width: the sensor at two places."""
    stiff = fmb.Material(young=1e9, poisson=0.0, density=1e3)
    body, supports, clamps = plate(shear=shear, material=stiff, markers={"end": (1.0, "mean")}).held(
        "root", "s0", fmb.Fixed
    )
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=supports), body),
            joints=clamps,
            gravity=(0, 0, 0),
            forces=(fmb.PointLoad("F", marker="p.end", force=(6.0, 0, -30.0)),),
            sensors=(
                fmb.StressResultants("a", body="p", at=(0.25, 0.5)),
                fmb.StressResultants("b", body="p", at=(0.6, 0.2)),
            ),
        )
    )
    for name, s in (("a", 0.25), ("b", 0.6)):
        N11, _, _, M11, M22, _, Q1, _ = solution[name][-1]
        assert N11 == pytest.approx(6.0, rel=0.01)
        assert M11 == pytest.approx(30.0 * 2.0 * (1.0 - s), rel=0.01)  # it bends down: the upper side is stretched
        assert pytest.approx(0.0, abs=0.01) == M22 / M11
        assert (Q1 == pytest.approx(-30.0, rel=0.01)) if shear else (Q1 == 0.0)


def test_sensor_refused():
    with pytest.raises(ModelError, match=r"at = 0\.5"):
        fmb.StressResultants("a", body="p", at=0.5)
    with pytest.raises(ModelError, match="body 'ground' is a Ground"):
        fmb.Model(bodies=(fmb.Ground(), plate()), sensors=(fmb.StressResultants("a", body="ground"),))


@KINDS
def test_inversion_is_named_with_its_time(shear):
    """An end force far beyond the stiffness pushes an element through its neighbour."""
    body = plate(shear=shear, elements=(2, 1), markers={"end": (1.0, "mean")})
    push = fmb.PointLoad("push", marker="p.end", force=(-3e5, 0, 0))
    found = r"Body 'p' at t = (0\.\d+) s: element \(\d, 0\) of \(2, 1\) has (turned|collapsed)"
    with pytest.raises(IntegrationError, match=found) as error:
        fmb.simulate(
            fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0), forces=(push,)),
            t_end=0.2,
            samples=201,
            integrator=fmb.GeneralizedAlpha(step=1e-3),
        )
    time = float(re.search(found, str(error.value))[1])
    assert time == pytest.approx(error.value.solution.t[-1], rel=1e-3)


@KINDS
def test_files_for_paraview(shear, tmp_path):
    """The sheet has its volume, and its fields those of a plate bent to a radius."""
    radius = 2.0
    body = fmb.AncfPlate.cylinder(
        "p",
        radius=radius,
        angle=0.8,
        length=1.0,
        elements=(8, 2),
        thickness=0.1,
        shear=shear,
        material=SOFT,
        flat=True,
        velocity=(1.0, 0.0, 0.0),
    )
    model = fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0))
    solution = fmb.simulate(model, t_end=1e-6, samples=2, integrator=fmb.GeneralizedAlpha(step=1e-6))
    fmb.write_vtk(solution, tmp_path / "out.pvd")
    mesh = pyvista.read(sorted((tmp_path / "out").glob("p_*.vtu"))[0])
    surface = mesh.extract_surface(algorithm="dataset_surface")
    assert surface.n_open_edges == 0 or surface.clean().n_open_edges == 0
    assert surface.clean().triangulate().volume == pytest.approx(0.8 * radius * 0.1, rel=0.01)
    D = SOFT.young * 0.1**3 / 12.0 / (1.0 - SOFT.poisson**2)
    np.testing.assert_allclose(mesh["K11"], 1.0 / radius, rtol=0.01)
    np.testing.assert_allclose(mesh["M11"], D / radius, rtol=0.01)
    np.testing.assert_allclose(mesh["M22"], SOFT.poisson * D / radius, rtol=0.01)


@KINDS
def test_loads_sum_up(shear):
    """The forces of pressure and dead load are p A along the turned normal and b A in W: on a square at rest."""
    body = plate(shear=shear, rotation=(0.4, -0.3, 1.2), edges=(1.5, 1.5))
    forces = (
        fmb.Pressure("p", load="p.pressure", amount=7.0),
        fmb.Pressure("y", load="p.load_y", amount=3.0),
        fmb.Pressure("z", load="p.load_z", amount=-2.0),
    )
    system = compile(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0), forces=forces))
    work = system.workspace()
    work.weights[0].wanted = 0
    evaluate(system.program, system.state(), work)
    total = -work.residual.reshape(-1, body.vectors, 3)[:, 0].sum(axis=0)
    np.testing.assert_allclose(total, 1.5**2 * (7.0 * np.asarray(body.rotation)[:, 2] + (0.0, 3.0, -2.0)), rtol=1e-9)
