"""Units that cannot be meant are doubted: by size, mass, speed of sound, density and stiffness together."""

import warnings

import numpy as np
import pytest
from fem.structured import structured

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ValidityWarning
from flexmb.model.material import MATERIALS

STEEL = MATERIALS["steel"]


def quietly(make):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return make()


def bracket(scale):
    """A block of 100 mm x 60 mm x 40 mm."""
    mesh = structured("tetra10", (2, 2, 2))
    size = np.ptp(mesh.points, axis=0)
    return fem.Mesh(
        points=(mesh.points - mesh.points.min(axis=0)) / size * [100, 60, 40] * scale, cells=mesh.cells, name="bracket"
    )


def test_a_bracket_in_millimetres():
    """123 m of diagonal are less than those of a bridge, but the block would weigh 1.884 million tonnes."""
    with pytest.warns(fem.MeshWarning, match=r"weighs 1\.88e\+09 kg and is 123 m long.*scale=1e-3.*weigh 1\.88 kg"):
        fem.solid(bracket(1.0), STEEL)
    with pytest.warns(fem.MeshWarning, match="weighs"):
        fem.solid(bracket(0.1), STEEL)  # a washer of 10 mm
    quietly(lambda: fem.solid(bracket(1e-3), STEEL))


def test_large_parts_that_are_meant():
    """A wing spar of 30 m as a frame, a hull panel of 20 m as a shell: 2 t and 16 t."""
    spar = fem.Section.box(0.5, 0.8, 0.01)
    quietly(lambda: fem.frame([(0, 0, 0), (15, 0, 0), (30, 0, 0)], section=spar, material=MATERIALS["aluminium"]))
    points = np.array([[0, 0, 0], [20, 0, 0], [20, 10, 0], [0, 10, 0.0]])
    panel = fem.Mesh(points=points, cells=(("quad", np.array([[0, 1, 2, 3]])),))
    quietly(lambda: fem.shell(panel, STEEL, 0.01))
    with pytest.warns(fem.MeshWarning, match="weighs"):
        fem.shell(panel, STEEL, 1.0)  # 1 mm of thickness, given as 1


@pytest.mark.parametrize(
    ("young", "density", "words"),
    [
        (210e3, 7850.0, "speed of sound"),  # MPa
        (210e9, 7.85e-9, "speed of sound"),  # t/mm3
        (210.0, 7.85e-6, r"density is 7\.85e-06"),  # GPa and kg/mm3 have the speed of sound of steel
        (2e14, 2.3e4, "speed of sound|modulus"),
    ],
)
def test_materials(young, density, words):
    material = fmb.Material(young=young, poisson=0.3, density=density)
    with pytest.warns(fem.MeshWarning, match=words):
        fem.solid(bracket(1e-3), material)
    section = fem.Section.solid_circle(0.005)
    line = {"points": ((0, 0, 0), (1, 0, 0)), "elements": 2}
    for kind in (fmb.AncfCable, fmb.AncfBeam):
        with pytest.warns(ValidityWarning, match=f"'line': .*({words})"):
            kind("line", **line, section=section, material=material)
    with pytest.warns(ValidityWarning, match=f"'plate': .*({words})"):
        fmb.AncfPlate.rectangle("plate", edges=(1.0, 0.5), elements=(1, 1), thickness=0.01, material=material)


@pytest.mark.parametrize(("radius", "words"), [(5.0, "larger than the part is long"), (1e-9, "times smaller")])
def test_sections_of_lines(radius, words):
    """A rope of 1 m whose radius of 5 mm is given as 5, or as nanometres."""
    for kind in (fmb.AncfCable, fmb.AncfBeam):
        fields = {"points": ((0, 0, 0), (1, 0, 0)), "elements": 2, "material": STEEL}
        with pytest.warns(ValidityWarning, match=f"'rope': a section .*{words}"):
            kind("rope", section=fem.Section.solid_circle(radius), **fields)
        quietly(lambda kind=kind, fields=fields: kind("rope", section=fem.Section.solid_circle(0.005), **fields))


@pytest.mark.parametrize(("thickness", "words"), [(10.0, "larger than the part is long"), (1e-9, "times smaller")])
def test_thickness_of_plates(thickness, words):
    fields = {"edges": (1.0, 0.5), "elements": (1, 1), "material": STEEL}
    with pytest.warns(ValidityWarning, match=f"'plate': a thickness .*{words}"):
        fmb.AncfPlate.rectangle("plate", thickness=thickness, **fields)
    quietly(lambda: fmb.AncfPlate.rectangle("plate", thickness=0.01, **fields))


def test_small_parts_that_are_meant():
    """A part of 123 um is no mistake of units; one of 1.2 um has been scaled twice, most likely."""
    quietly(lambda: fem.solid(bracket(1e-6), STEEL))
    with pytest.warns(fem.MeshWarning, match="below 1e-05 m.*scaled twice"):
        fem.solid(bracket(1e-8), STEEL)
