"""Cables and beams in VTK files: closed surfaces of the right volume, with the section forces at their points."""

import numpy as np
import pytest
import pyvista
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.bodies.line.curve import minimal_rotation
from flexmb.io.scene import Scene
from flexmb.io.swept_lines import SweptLine
from flexmb.results import recover

STEEL = fmb.MATERIALS["steel"]
SECTIONS = {
    "rectangle": fem.Section.rectangle(0.15, 0.03),
    "box": fem.Section.box(0.1, 0.15, 0.01, 0.02),
    "i": fem.Section.i(0.1, 0.15, 0.01, 0.02),
    "tube": fem.Section.tube(0.1, 0.01),
    "taper": (fem.Section.box(0.1, 0.15, 0.01), fem.Section.box(0.05, 0.05, 0.005)),
    "circle": fem.Section.solid_circle(0.05),
}


def beam(section, kind=fmb.AncfBeam, **fields):
    return kind(
        "b", **{"points": ((0, 0, 0), (2, 0, 0)), "elements": 4, "section": section, "material": STEEL, **fields}
    )


def volume(line, q) -> float:
    """Volume inside a surface with outward normals: one third of the flux of x."""
    points = line.points(q)
    faces = [
        cells if name == "triangle" else np.vstack([cells[:, :3], cells[:, [0, 2, 3]]]) for name, cells in line.cells
    ]
    a, b, c = (points[np.vstack(faces)][:, k] for k in range(3))
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize("name", SECTIONS)
def test_surface_is_closed_and_has_the_volume(name):
    """Area times length; a circle of 20 sides has sin(18 deg) / 18 deg of it."""
    body = beam(SECTIONS[name])
    line, q = SweptLine(body), body.initial_state()[0]
    polygon = np.sin(np.pi / 10) / (np.pi / 10) if name in ("tube", "circle") else 1.0
    assert volume(line, q) == pytest.approx(
        polygon * body.mass / STEEL.density, rel=2e-3 if name == "taper" else SOLVER
    )
    cells = np.vstack([np.pad(c, ((0, 0), (0, 4 - c.shape[1])), mode="edge") for _, c in line.cells])
    grid = pyvista.PolyData(line.points(q), faces=np.hstack([np.full((len(cells), 1), 4), cells]).ravel())
    edges = grid.clean().extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False)
    assert edges.n_cells == 0


def test_belt_closes():
    belt = beam(
        SECTIONS["circle"],
        fmb.AncfCable,
        closed=True,
        elements=12,
        points=((0, 0, 0), (1, 0, -0.4), (2, 0, 0), (1, 0, 0.4)),
    )
    inside = volume(SweptLine(belt), belt.initial_state()[0])
    assert inside == pytest.approx(np.sin(np.pi / 10) / (np.pi / 10) * belt.mass / STEEL.density, rel=0.02)


def test_belt_in_space_closes_without_a_twist():
    """Axes that go around without twist come back turned; that turn is shared by all sections,
    the seam like the others.
    """
    x = 2 * np.pi * np.arange(16) / 16
    bent = np.stack([np.cos(x), np.sin(x), 0.5 * np.sin(2 * x + 0.4) + 0.3 * np.cos(x)], axis=1)
    belt = beam(SECTIONS["circle"], fmb.AncfCable, closed=True, elements=16, points=bent)
    axes = belt.section_axes(belt.initial_state()[0], np.arange(64) / 64)[1]
    twists = []
    for now, after in zip(axes, np.roll(axes, -1, axis=0), strict=True):
        y = minimal_rotation(now[:, 0], after[:, 0]) @ now[:, 1]
        twists.append(np.arctan2(y @ after[:, 2], y @ after[:, 1]))
    assert abs(sum(twists)) > 0.05
    np.testing.assert_allclose(twists, np.mean(twists), atol=1e-6)


@pytest.fixture(scope="module")
def loaded():
    return fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), beam(SECTIONS["box"])),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
            forces=(fmb.PointLoad("P", marker="b.end", force=(0, 0, fmb.expression("-1e5*t"))),),
        ),
        t=1.0,
        path=fmb.LoadSteps(steps=3),
    )


def test_files_have_the_section_forces(loaded, tmp_path):
    """Points follow the tip, and M at the clamp is the load times its lever."""
    loaded_body, q = loaded.model.body("b"), loaded.final.q
    fmb.write_vtk(loaded, tmp_path / "a.pvd")
    grid = pyvista.read(tmp_path / "a" / "b_3.vtu")
    assert {"N", "Qy", "Qz", "Mx", "My", "Mz"} <= set(grid.point_data)
    at_clamp, at_tip = (np.argmin(sign * grid.points[:, 0]) for sign in (1, -1))
    ends = recover.line_forces(loaded_body, q, (0.0, 1.0))[0]
    assert grid.point_data["My"][at_clamp] == pytest.approx(ends[0, 4], rel=1e-5)
    assert grid.point_data["Qz"][at_tip] == pytest.approx(ends[1, 2], rel=1e-5)
    tip = loaded_body.section_axes(q, 1.0)[0][0]
    corner = np.hypot(0.05, 0.075)
    near = np.linalg.norm(grid.points - tip, axis=1)
    assert near.min() <= corner + 1e-6
    fmb.write_vtk(loaded, tmp_path / "b.vtkhdf")
    assert (tmp_path / "b.xdmf").exists()


def test_path_with_a_falling_load_is_numbered(loaded):
    """Frames need increasing times: the numbers of the samples where the load goes down."""
    assert list(Scene(loaded).times) == pytest.approx([0.0, 1 / 3, 2 / 3, 1.0])
    phase = loaded.phases[0]
    turned = type(phase)(
        model=phase.model,
        system=phase.system,
        t=np.array([0.0, 1.0, 0.5, 0.7]),
        q=phase.q,
        u=phase.u,
        a=phase.a,
        lam=phase.lam,
        works=phase.works,
    )
    assert list(Scene(fmb.Solution(phases=(turned,))).times) == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.render
def test_picture(loaded, tmp_path):
    from flexmb import view

    assert view.render(loaded, tmp_path / "a.png", size=(320, 180)).stat().st_size > 3000
