"""Pieces of parts against closed forms: beams, tapers, plates, shells, extrusions, stretched meshes.

References: Timoshenko & Young, Vibration Problems in Engineering (beams, plates); volumes and areas of solids.
"""

import ctypes
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, parts
from flexmb.errors import FlexmbError

STEEL = fmb.MATERIALS["steel"]
TUBE = {"material": "steel", "size": 0.02, "around": 40, "outer_diameter": 0.06, "wall": 0.005, "length": 0.1}
MESHES = Path(__file__).parents[2] / "meshes"


def test_line_with_a_taper():
    """A cantilever whose height falls from h to h/2, width b: d = 12 F/(E b) int (L - x)^2 / h(x)^3 dx, no shear."""
    length, b, h = 1.0, 0.02, 0.04
    sections = [fem.Section.rectangle(b, h), fem.Section.rectangle(b, h / 2)]
    line = parts.Line(
        points=[(0, 0, 0), (length, 0, 0)],
        section=sections,
        material="steel",
        elements=40,
        shear=False,
        nodes={"tip": 1.0},
    )
    fe = line.finite_elements()
    force = np.zeros((len(fe.nodes), 6, 1))
    force[fe.node_sets["tip"][0], 2] = 100.0
    u = fe.field(fem.static(fe, fe.forces(force)[:, 0], fe.node_sets["start"])[:, None])
    x = np.linspace(0.0, length, 20001)
    height = h * (1.0 - 0.5 * x / length)
    exact = np.trapezoid(12.0 * 100.0 * (length - x) ** 2 / (STEEL.young * b * height**3), x)
    assert u[fe.node_sets["tip"][0], 2, 0] == pytest.approx(exact, rel=2e-4)


def test_named_nodes_and_size_of_a_line():
    """Named places are nodes exactly; no beam is longer than asked for."""
    line = parts.Line(
        points=[(0, 0, 0), (1, 0, 0), (1, 2, 0)],
        section=fem.Section.tube(0.05, 0.003),
        material="steel",
        size=0.3,
        nodes={"a": 0.1, "b": [0.9, 0.5]},
        name="spar",
    )
    fe = line.finite_elements()
    assert np.allclose(fe.nodes[fe.node_sets["a"]], [[0.3, 0, 0]])
    assert np.allclose(fe.nodes[fe.node_sets["b"]], [[1, 0.5, 0], [1, 1.7, 0]])
    assert np.linalg.norm(np.diff(fe.nodes, axis=0), axis=1).max() <= 0.3 + 1e-12


def test_plate_simply_supported():
    """First frequency pi/2 sqrt(D/(rho t)) (1/a^2 + 1/b^2) of a plate on all edges."""
    a, b, t = 1.0, 0.7, 0.01
    fe = parts.Plate(
        corners=[(0, 0, 0), (a, 0, 0), (a, b, 0), (0, b, 0)], thickness=t, material="steel", size=0.05
    ).finite_elements()
    fe = fem.with_supports(fe, directions="xyrz")
    for k in range(1, 5):
        fe = fem.with_supports(fe, f"plate.edge_{k}", "z")
    D = STEEL.young * t**3 / 12.0 / (1.0 - STEEL.poisson**2)
    exact = np.pi / 2.0 * np.sqrt(D / (STEEL.density * t)) * (1.0 / a**2 + 1.0 / b**2)
    assert fem.eigenmodes(fe, n=1).frequencies[0] == pytest.approx(exact, rel=5e-3)


def test_tapered_plate_and_curved_shell():
    """Mass rho t A with the mean thickness; a parabolic panel has the length of the parabola."""
    flat = [(0, 0, 0), (1, 0, 0), (1, 0.5, 0), (0, 0.5, 0)]
    fe = parts.Plate(corners=flat, thickness=[1e-3, 3e-3, 3e-3, 1e-3], material="steel", size=0.1).finite_elements()
    assert fe.M[::6, ::6].sum() == pytest.approx(STEEL.density * 2e-3 * 0.5, rel=1e-12)
    middles = [(0.5, 0, 0.2), (1, 0.25, 0), (0.5, 0.5, 0.2), (0, 0.25, 0)]
    fe = parts.Plate(corners=[*flat, *middles], thickness=1e-3, material="steel", size=0.02).finite_elements()
    x = np.linspace(0.0, 1.0, 10001)
    length = np.trapezoid(np.sqrt(1.0 + (0.8 * (1.0 - 2.0 * x)) ** 2), x)  # z = 0.8 x (1 - x)
    assert fe.M[::6, ::6].sum() == pytest.approx(STEEL.density * 1e-3 * 0.5 * length, rel=1e-3)


def test_extrusions():
    """Volumes of plate with bore, tube and lug, and areas of their named surfaces."""
    pytest.importorskip("gmsh")
    common = {"material": "steel", "size": 0.02}
    plate = parts.Extrusion.plate(
        length=0.2, width=0.1, thickness=0.01, bores=[{"name": "pin", "at": (0.05, 0.05), "diameter": 0.03}], **common
    )
    tube = parts.Extrusion.tube(**TUBE)
    lug = parts.Extrusion.lug(length=0.1, width=0.06, thickness=0.02, bore=0.025, **common)
    volumes = {
        plate: 0.2 * 0.1 * 0.01 - np.pi * 0.015**2 * 0.01,
        tube: np.pi * (0.03**2 - 0.025**2) * 0.1,
        lug: 0.02 * (0.1 * 0.06 + np.pi * 0.03**2 / 2 - np.pi * 0.0125**2),
    }
    for piece, volume in volumes.items():
        fe = piece.finite_elements()
        assert fe.M[::3, ::3].sum() == pytest.approx(STEEL.density * volume, rel=1e-4)
    radius = np.linalg.norm(fe.nodes[fe.node_sets["bore"]][:, :2], axis=1)
    assert np.allclose(radius, 0.0125, rtol=1e-9)
    assert set(fe.facet_sets) >= {"bore", "bottom", "top", "sides", "side_1", "side_4"}
    foot = fe.nodes[fe.node_sets["side_4"]]
    assert np.ptp(foot, axis=0) == pytest.approx([0.0, 0.06, 0.02], abs=1e-9)
    assert foot[:, 0] == pytest.approx(-0.1, abs=1e-9)
    assert "side_2" not in fe.facet_sets  # the boss covers it


def test_a_broken_pipe_is_an_error_after_a_mesh_too():
    """Gmsh sets SIGPIPE to its default, by which a process that writes to a dead one ends; Python ignores it."""
    pytest.importorskip("gmsh")
    handler = ctypes.pythonapi.PyOS_getsig  # what C has: Python does not hear of the change
    ignored = handler(signal.SIGPIPE)
    with ThreadPoolExecutor(1) as other:  # where Python itself cannot set signals
        other.submit(parts.Extrusion.tube(**TUBE).finite_elements).result()
    assert handler(signal.SIGPIPE) == ignored == 1


def test_a_stretched_mesh():
    """The lever of the flap track, 0.1 m longer: bores as they were, mass of the web, deflection of the longer web."""
    stretch = parts.Stretch(along=(1, 0, 0), between=(0.15, 0.5), by=0.1)
    short, long = (
        parts.MeshFile(file=MESHES / "lever_arm.msh", material="titanium", stretch=given) for given in ((), stretch)
    )
    a, b = short.finite_elements(), long.finite_elements()
    tip_a, tip_b = (fe.nodes[fe.node_sets["bore_tip"]] for fe in (a, b))
    assert np.allclose(tip_b - tip_a, [0.1, 0, 0], atol=1e-12)
    assert np.allclose(a.nodes[a.node_sets["bore_root"]], b.nodes[b.node_sets["bore_root"]], atol=0)
    x = np.array([0.15, 0.5])
    web = 0.06 * np.mean(0.14 - 0.05 / 0.6 * x)  # width times mean height of the tapered web between the planes
    density = fmb.MATERIALS["titanium"].density
    assert (b.M.sum() - a.M.sum()) / 3.0 == pytest.approx(density * web * 0.1, rel=1e-3)


def test_a_stretch_beside_the_mesh_is_refused():
    """Planes in millimetres for a mesh in metres would change nothing, whatever the parameter."""
    for between in ((150, 500), (-2.0, -1.0)):
        lever = parts.MeshFile(
            file=MESHES / "lever_arm.msh",
            material="titanium",
            stretch=parts.Stretch(along=(1, 0, 0), between=between, by=0.1),
        )
        with pytest.raises(FlexmbError, match=r"the mesh reaches from -0\.1.* to 0\.6.*some of the mesh between"):
            lever.finite_elements()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: parts.Line(points=[(0, 0, 0), (0, 0, 0)], section=BAR, material="steel"), "are both at"),
        (lambda: parts.Line(points=LINE, section=BAR, material="stel"), "Did you mean 'steel'"),
        (lambda: parts.Line(points=LINE, section=BAR, material="steel", nodes={"rib": 1.2}), "node 'rib'.*fraction"),
        (lambda: parts.Line(points=LINE, section=BAR, material="steel", size=0.1, elements=3), "one of them"),
        (lambda: parts.Line(points=LINE, section=BAR, material="steel", size=1e-9), "at most 100000 in a model"),
        (
            lambda: parts.Line(points=LINE, section=BAR, material="steel", elements=100_001),
            "about 100001 beams.*reduce",
        ),
        (
            lambda: parts.Line(points=LINE, section=(BAR, BAR, BAR), material="steel"),
            r"3 sections for 2 points\. Expected: 1, or 2 for a taper\. ",
        ),
        (
            lambda: parts.Plate(corners=[SQUARE[k] for k in (0, 1, 3, 2)], thickness=0.1, material="steel", size=0.1),
            r"do not go round.*Write corners = \[\[0.0, 0.0, 0.0\], \[1.0, 0.0, 0.0\], \[1.0, 1.0, 0.0\], ",
        ),
        (
            lambda: parts.Plate(corners=[SQUARE[k] for k in (0, 2, 1, 3)], thickness=0.1, material="steel", size=0.1),
            "two opposite edges cross",
        ),
        (lambda: parts.Line(points=LINE, sections=BAR, material="steel"), "Did you mean 'section'"),
        (lambda: parts.Plate(corners=SQUARE, thickness=0.0, material="steel", size=0.1), "thickness = 0.0 m"),
        (lambda: parts.Plate(corners=SQUARE[:3], thickness=0.1, material="steel", size=0.1), "four points"),
        (lambda: parts.Plate(corners=SQUARE, thickness=0.1, material="steel", size=1e-6), "at most 100000 in a model"),
        (lambda: parts.Plate(corners=SQUARE, thickness=0.1, material="steel", size=0.00316), "shell elements.*metres"),
        (
            lambda: parts.Plate(corners=SQUARE, thickness=0.1, material="steel", size=0.1, nodes={"a": (2, 0)}),
            "node 'a'",
        ),
        (lambda: plate({"name": "pin", "at": (0, 0), "diameter": 0.03}), "leaves the figure"),
        (lambda: plate(PIN, {"name": "b", "at": (0.06, 0.05), "diameter": 0.03}), "meets the bore 'pin'"),
        (lambda: plate(PIN, PIN), "taken"),
        (lambda: parts.Extrusion(depth=0.1, material="steel", size=0.1), "neither an outline nor a boss"),
        (lambda: parts.Extrusion.tube(outer_diameter=0.1, wall=0.05, length=1, material="steel", size=0.1), "wall"),
        (lambda: parts.MeshFile(file="lever_arn.msh", material="steel"), "no file 'lever_arn.msh'"),
        (lambda: parts.Stretch(along=(1, 0, 0), between=(0, 1), by=-1.0), "leaves something"),
        (lambda: parts.Part(name="x", interfaces={}), "neither pieces nor a deck"),
        (lambda: parts.Part(name="x", pieces=["flap.msh"]), "descriptions of flexmb.parts"),
        (lambda: parts.Part(name="x", pieces=[A_LINE], units="mm, t, s"), "without a deck"),
    ],
)
def test_bad_descriptions_are_named(make, message):
    with pytest.raises(FlexmbError, match=message):
        make()


BAR, LINE = fem.Section.rectangle(0.02, 0.01), [(0, 0, 0), (1, 0, 0)]
A_LINE = parts.Line(points=LINE, section=BAR, material="steel")
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
PIN = {"name": "pin", "at": (0.05, 0.05), "diameter": 0.03}


def plate(*bores):
    return parts.Extrusion.plate(length=0.2, width=0.1, thickness=0.01, bores=bores, material="steel", size=0.02)


STRIP = "*NODE\n" + "".join(f"{2 * i + j + 1},{0.1 * i},{0.1 * j},0\n" for i in range(11) for j in range(2))
STRIP += "*ELEMENT,TYPE=S4,ELSET=all\n" + "".join(
    f"{i + 1},{2 * i + 1},{2 * i + 3},{2 * i + 4},{2 * i + 2}\n" for i in range(10)
)
STRIP += "*NSET,NSET=root\n1,2\n*NSET,NSET=tip\n21,22\n"


@pytest.mark.parametrize("side", [1.0, 0.0, -1.0])
def test_side_of_the_stress_of_a_mesh(tmp_path, side):
    """A cantilever strip, a force at its tip: the faces carry +-6 F (L - x)/(b t^2), the middle nothing."""
    (tmp_path / "strip.inp").write_text(STRIP)
    material = fmb.Material(young=70e9, poisson=0.0, density=2700.0)
    mesh = parts.MeshFile(file=tmp_path / "strip.inp", material=material, thickness=0.01, stress_side=side)
    part = parts.Part(name="strip", pieces=[mesh], interfaces={"root": "root", "tip": "tip"}, modes=2, compare=0)
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"r": (0, 0.05, 0)}), fmb.FloatingBody("strip", data=part.reduced())],
        joints=[fmb.Fixed("root", markers=("ground.r", "strip.root"))],
        forces=[fmb.PointLoad("tip", marker="strip.tip", force=(0, 0, -1.0))],
        sensors=[fmb.Stress("s", body="strip", node=10, component="xx")],
    )
    found = np.ravel(fmb.statics(model)["s"])[-1]
    assert found == pytest.approx(side * 6.0 * 0.5 / (0.1 * 0.01**2), rel=1e-4, abs=1.0)


def test_sides_are_of_shells(tmp_path):
    (tmp_path / "strip.inp").write_text(STRIP)
    with pytest.raises(fmb.errors.ModelError, match=r"stress_side = 1 of solids.*Remove stress_side"):
        parts.MeshFile(file=tmp_path / "strip.inp", material="steel", stress_side=1)
    with pytest.raises(fmb.errors.ModelError, match=r"stress_side = 2\. Expected: -1"):
        parts.MeshFile(file=tmp_path / "strip.inp", material="steel", thickness=0.01, stress_side=2)
