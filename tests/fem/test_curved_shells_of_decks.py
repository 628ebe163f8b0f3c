"""Shells of decks that do not turn in their plane, on curved surfaces: refinement must not make them softer."""

import numpy as np
import pytest

from flexmb import fem
from flexmb.fem.deck.blocks import shell_blocks
from flexmb.fem.deck.nastran import read_nastran_deck

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")


def strip(nx, ny, curvature, corners=4):
    """Return a deck of a steel strip 0.5 x 0.2 x 0.01 m, rolled to a curvature, clamped at one end."""
    lines = ["BEGIN BULK", "MAT1,1,2.1+11,,.3,7850.", "PSHELL,1,1,.01,1,,1", "PARAM,COUPMASS,1"]
    for j in range(ny + 1):
        for i in range(nx + 1):
            x, y = 0.5 * i / nx, 0.2 * j / ny
            at = (np.sin(curvature * x) / curvature, (1 - np.cos(curvature * x)) / curvature) if curvature else (x, 0.0)
            lines.append(f"GRID,{1 + i + j * (nx + 1)},,{at[0]:.10f},{y:.8f},{at[1]:.10f}")
    for j in range(ny):
        for i in range(nx):
            n, e = 1 + i + j * (nx + 1), 2 * (i + j * nx) + 1
            ring = (n, n + 1, n + nx + 2, n + nx + 1)
            if corners == 4:
                lines.append(f"CQUAD4,{e},1,{','.join(map(str, ring))}")
            else:
                lines += [
                    f"CTRIA3,{e},1,{ring[0]},{ring[1]},{ring[2]}",
                    f"CTRIA3,{e + 1},1,{ring[0]},{ring[2]},{ring[3]}",
                ]
    lines.append("SPC1,1,123456," + f"{1},THRU,{1}")
    lines += [f"SPC1,1,123456,{1 + j * (nx + 1)}" for j in range(1, ny + 1)]
    return "\n".join([*lines, "ENDDATA"]) + "\n"


@pytest.mark.parametrize(("corners", "tolerance"), [(4, 5e-3), (3, 8e-3)])
def test_a_fine_curved_strip_twists_as_in_calculix(tmp_path, corners, tolerance):
    """Radius 0.333 m. CalculiX 2.20 with 32 x 13 S8R: 36.16, 103.49, 177.39, 331.61 Hz. With the weak spring
    alone the second and fourth were 91 and 292 Hz with 64 x 26 CQUAD4, 99 and 318 Hz with 80 x 16 CTRIA3."""
    (tmp_path / "part.bdf").write_text(strip(40, 16, 3.0, corners))
    found = fem.eigenmodes(fem.read_deck(tmp_path / "part.bdf", show=False), "spc_1", n=4).frequencies
    np.testing.assert_allclose(found, [36.16, 103.49, 177.39, 331.61], rtol=tolerance)


def test_only_curved_surfaces_hold_the_turn(tmp_path):
    """A flat plate and a sharp fold keep the share of PARAM, K6ROT; a curved one has a hundred times (t k)^2."""
    for curvature, share in ((0.0, 1e-4), (3.0, 100.0 * (0.01 * 3.0) ** 2)):
        (tmp_path / "part.bdf").write_text(strip(20, 8, curvature))
        ((block, _),) = shell_blocks(read_nastran_deck(tmp_path / "part.bdf"), "part")
        np.testing.assert_allclose(block.spring, share, rtol=5e-3)  # chords
    folded = strip(2, 1, 0.0).replace("GRID,3,,0.5000000000,0.00000000,0.0", "GRID,3,,.25,0.,.25")
    (tmp_path / "part.bdf").write_text(folded.replace("GRID,6,,0.5000000000,0.20000000,0.0", "GRID,6,,.25,.2,.25"))
    ((block, _),) = shell_blocks(read_nastran_deck(tmp_path / "part.bdf"), "part")
    np.testing.assert_allclose(block.spring, 1e-4)
