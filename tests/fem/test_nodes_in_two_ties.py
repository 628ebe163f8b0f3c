"""Three blocks of C3D8 whose meshes do not match, two side by side and one on both: an edge is in two ties."""

import numpy as np
import pytest
from fem.test_deck_abaqus import STEEL, bricks

from flexmb import fem

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
BLOCKS = {"A": (1, (3, 2, 2)), "B": (101, (4, 3, 3)), "C": (301, (3, 5, 2))}
SIZES = {"A": (1.0, 0.5, 0.5), "B": (1.0, 0.5, 0.5), "C": (2.0, 0.5, 0.5)}
PLACES = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (0.0, 0.0, 0.5)}
CALCULIX = {
    "BL AT BT": [62.24484, 80.28308, 221.0635, 471.7985, 473.8269, 664.4366],
    "BT AT BL": [62.2465, 80.27848, 221.151, 471.8498, 473.7444, 664.5861],
}
"""Hz, frequencies that CalculiX 2.20 prints for E = 210e9, nu = 0.3, rho = 7800, by the order of the ties."""


def numbered(name, chosen):
    """Return the nodes of a block whose place (i, j, k) in the grid is chosen."""
    first, (nx, ny, nz) = BLOCKS[name]
    places = [(i, j, k) for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
    return [first + number for number, place in enumerate(places) if chosen(*place)]


def assembly(order, held):
    """Return the deck; `held` chooses nodes of A by their place."""
    text = "".join(bricks(BLOCKS[name][1], SIZES[name], PLACES[name], BLOCKS[name][0], name) for name in BLOCKS)
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL\n" for name in BLOCKS)
    sets = {"BL": numbered("B", lambda i, j, k: i == 0), "AT": numbered("A", lambda i, j, k: k == 2)}
    sets["BT"] = numbered("B", lambda i, j, k: k == 3)
    for name, nodes in sets.items():
        text += f"*SURFACE, NAME={name}, TYPE=NODE\n" + "".join(f"{node},\n" for node in nodes)
    text += "*SURFACE, NAME=AR\n" + "".join(f"{number}, S4\n" for number in (3, 6, 9, 12))
    text += "*SURFACE, NAME=CB\n" + "".join(f"{number}, S1\n" for number in range(301, 316))
    for name in order.split():
        text += f"*TIE, NAME=T{name}, POSITION TOLERANCE=.01\n{name}, {'AR' if name == 'BL' else 'CB'}\n"
    text += "*BOUNDARY\n" + "".join(f"{node}, 1, 3\n" for node in numbered("A", held))
    return text + STEEL.replace("7850", "7800")


def read(tmp_path, text):
    (tmp_path / "blocks.inp").write_text(text)
    return fem.read_deck(tmp_path / "blocks.inp", show=False)


@pytest.mark.parametrize("order", CALCULIX)
def test_the_first_tie_of_a_node_holds(tmp_path, order):
    """A second one was refused as a contradiction."""
    fe = read(tmp_path, assembly(order, lambda i, j, k: i == 0 and k < 2))
    np.testing.assert_allclose(fem.eigenmodes(fe, "boundary", n=6).frequencies, CALCULIX[order], rtol=1e-6)
    assert (
        fe.source["approximated"][f"*TIE: nodes of '{order.split()[2]}' that an earlier *TIE holds, tied there alone"]
        == 4
    )


def test_supports_of_tied_nodes_are_told(tmp_path):
    """CalculiX drops the tie of a node that is held (88.1 Hz in place of 102.2)."""
    fe = read(tmp_path, assembly("BL AT BT", lambda i, j, k: i == 0))
    told = [count for words, count in fe.source["approximated"].items() if "*BOUNDARY at nodes that a *TIE" in words]
    assert told == [3]
