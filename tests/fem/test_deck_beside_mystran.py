"""Static answers of decks of bars, links, bushes and springs beside MYSTRAN 18.0, an open solver of Nastran decks.

The numbers are its printed displacements, seven digits, in the basic system (nodes without CD).
"""

import numpy as np
import pytest

from flexmb import fem

HEAD = """MAT1,1,7.+10,,.3,2700.
MAT1,2,2.1+11,,.28,7800.
PBAR,1,1,4.-4,2.-8,5.-8,4.-8,,
PBAR,2,2,3.-4,1.-8,3.-8,2.-8,.5,+
+,,,,,,,,,+
+,.8,.7,0.5-8
SPC1,1,123456,1
"""
FRAME = """CORD2R,5,,1.,0.,0.,1.,.3,1.,+
+,1.5,1.,.2
CORD2C,6,,0.,0.,1.,0.,.2,2.,+
+,1.,.1,1.
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.,5
GRID,3,,2.,0.,.3
GRID,4,,2.,1.,0.
GRID,5,6,1.2,40.,.5,6
GRID,6,,0.5,0.5,1.5
GRID,7,,0.,1.,2.,5
CBAR,1,1,1,2,0.,0.,1.,,+
+,,,0.,.05,.02,0.,-.03,.04
CBAR,2,1,2,3,0.,1.,1.
CBAR,3,2,3,4,5
CBAR,4,2,4,5,0.,.2,1.,,+
+,5,46
CBAR,5,1,5,6,1.,0.,0.,,+
+,,5,.01,.02,.03,0.,0.,0.05
CBAR,6,2,6,7,0.,1.,.3
CBAR,7,2,7,1,0.,1.,.3
"""
ASSEMBLY = """CORD2R,5,,0.,0.,0.,.1,.3,1.,+
+,1.5,.2,.2
CORD2C,6,,0.,0.,0.,0.,.2,2.,+
+,1.,.1,1.
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,.2,.1
GRID,4,,1.,-.2,.1
GRID,5,,1.,.2,1.
GRID,6,,1.,-.2,1.1
GRID,7,,1.3,0.,1.2
GRID,8,,1.3,0.,1.2,5
GRID,9,,2.,0.,1.2,6
GRID,10,,5.,5.,5.,,123456
CBAR,1,1,1,2,0.,0.,1.
RBE2,20,2,123456,3,4
CBAR,2,1,3,5,1.,0.,.1
CBAR,3,2,4,6,1.,0.,.1
CBAR,5,2,5,6,1.,0.,.1
RBE3,21,,7,123456,1.,123,3,4,+
+,5,2.,123,6
CBUSH,30,30,7,8,,,,5
PBUSH,30,K,1.+6,2.+6,3.+6,4.+3,5.+3,6.+3
CBAR,4,2,8,9,0.,0.,1.
CELAS2,31,2.5+4,5,1,9,3
CELAS2,32,1.+5,6,2,10,2
MPC,7,5,1,1.,9,2,-.5,,+
+,,6,3,-.3
"""
CASES = {
    "frame": (
        FRAME,
        {3: (0, 100, 50, 0, 0, 0), 6: (0, 0, 0, 20, 0, 6), 7: (50, 10, 5, 0, 0, 0)},
        {
            3: (-5.307948e-03, 8.124618e-02, 3.547154e-02, -7.291694e-02, -2.028983e-02, 4.011010e-02),
            4: (-3.351605e-02, 5.821237e-02, -4.130872e-02, -7.918594e-02, -3.778140e-03, 2.635050e-02),
            6: (2.512897e-02, -2.254473e-02, -1.522103e-02, 1.470368e-02, 3.126546e-02, -2.828231e-02),
        },
    ),
    "assembly": (
        ASSEMBLY,
        {9: (0, 100, 50, 0, 0, 0), 5: (0, 0, 0, 20, 0, 6), 2: (50, 10, 5, 0, 0, 0)},
        {
            2: (5.790995e-06, 4.934697e-03, -5.966245e-04, 4.417195e-03, 6.380330e-03, 8.511470e-03),
            4: (2.346118e-03, 4.492978e-03, -1.480063e-03, 4.417195e-03, 6.380330e-03, 8.511470e-03),
            5: (6.323718e-03, 5.850999e-04, 2.883424e-04, 4.744981e-03, 8.844453e-03, 8.214329e-03),
            6: (1.028192e-02, 1.427990e-04, -1.480704e-03, 4.280992e-03, 8.659338e-03, 7.559383e-03),
            7: (9.487778e-03, 2.151941e-03, -3.009889e-03, 4.358594e-03, 8.036566e-03, 8.156932e-03),
        },
    ),
}


@pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
@pytest.mark.parametrize("name", CASES)
def test_displacements_beside_mystran(tmp_path, name):
    """Offsets at both ends, pins, a product of inertia, shear areas, turned and cylindrical systems; RBE2, RBE3 of two
    weights, a bush and springs in systems of their own, an MPC of three terms. Measured 3e-7 of the largest."""
    deck, forces, theirs = CASES[name]
    (tmp_path / "part.bdf").write_text(f"SPC = 1\nMPC = 7\nCEND\nBEGIN BULK\n{HEAD}{deck}ENDDATA\n")
    fe = fem.read_deck(tmp_path / "part.bdf", show=False, units="m, kg, s")
    row = {int(label): k for k, label in enumerate(fe.labels) if label}
    field = np.zeros((len(fe.nodes), 6, 1))
    for label, force in forces.items():
        field[row[label], :, 0] = force
    u = fem.static(fe, fe.forces(field)[:, 0], fem.fixed_freedoms(fe, "spc"))
    ours = fe.field(u[:, None])[:, :, 0]
    found, wanted = np.array([ours[row[label]] for label in theirs]), np.array(list(theirs.values()))
    for part in (slice(0, 3), slice(3, 6)):
        np.testing.assert_allclose(found[:, part], wanted[:, part], atol=1e-6 * np.abs(wanted[:, part]).max())
