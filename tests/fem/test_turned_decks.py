"""A Nastran deck of nearly every card, turned as a whole, with grid points and displacements in systems of their own.

Nothing may change but the axes: mass, centre and frequencies stay. A card that passes over one of its directions would
show. Composite strips with offsets stand beside the theory of laminates (R. M. Jones, 1999, eqs. (4.22) to (4.24)).
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexmb import fem
from flexmb.fem.deck.inventory import mass_and_center

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")


def words(values):
    return ",".join(f"{float(x):.13E}" for x in values)


class Deck:
    """A deck whose model is turned by R and moved; `own`: each grid point has a CP and a CD of its own."""

    def __init__(self, turn, shift, own):
        self.turn, self.shift, self.own = turn, np.asarray(shift, float), own
        self.rows, self.axes, self.count = ["SOL 103", "CEND", "BEGIN BULK", "PARAM,COUPMASS,1"], {}, 100
        self.random = np.random.default_rng(7)

    def place(self, point):
        return self.turn @ np.asarray(point, float) + self.shift

    def system(self, kind, axes, origin):
        self.count += 1
        self.rows.append(
            f"CORD2{kind},{self.count},,{words(origin)},{words(origin + axes[:, 2])},+\n+,{words(origin + axes[:, 0])}"
        )
        return self.count

    def moving(self, vector):
        """Return the number of a system that turns with the model."""
        return self.system("R", self.turn @ Rotation.from_rotvec(vector).as_matrix(), self.place([0.3, -0.2, 0.5]))

    def grid(self, number, point):
        at = self.place(point)
        if not self.own:
            self.axes[number] = np.eye(3)
            self.rows.append(f"GRID,{number},,{words(at)}")
            return
        numbers = []
        for kind in ("RCS"[number % 3], "RCS"[(number // 3) % 3]):
            axes = Rotation.from_rotvec(self.random.normal(size=3)).as_matrix()
            origin = self.random.normal(0.0, 5.0, 3)
            numbers.append((self.system(kind, axes, origin), kind, axes, origin))
        (cp, kind, axes, origin), (cd, shown, turned, centre) = numbers
        x, y, z = axes.T @ (at - origin)
        local = {
            "R": (x, y, z),
            "C": (np.hypot(x, y), np.degrees(np.arctan2(y, x)), z),
            "S": (
                np.linalg.norm([x, y, z]),
                np.degrees(np.arctan2(np.hypot(x, y), z)),
                np.degrees(np.arctan2(y, x)),
            ),
        }[kind]
        self.rows.append(f"GRID,{number},{cp},{words(local)},{cd}")
        x, y, z = turned.T @ (at - centre)
        phi, theta = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
        out, around, up = np.array([[np.cos(phi), np.sin(phi), 0], [-np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
        local = {
            "R": np.eye(3),
            "C": np.array([out, around, up]),
            "S": np.array([np.sin(theta) * out + np.cos(theta) * up, np.cos(theta) * out - np.sin(theta) * up, around]),
        }[shown]
        self.axes[number] = turned @ local.T

    def vector(self, values, node):
        """Return the words of a direction in the displacement system of a node."""
        return words(self.axes[node].T @ (self.turn @ np.asarray(values, float)))

    def add(self, *rows):
        self.rows += rows

    def write(self, path):
        path.write_text("\n".join([*self.rows, "ENDDATA", ""]))
        return fem.read_deck(path, show=False)


def structure(deck):
    """Write shells, solids, bushings, beams, links and masses, each with all directions that its card has."""
    places = [(0.3 * i, 0.25 * j + 0.02 * (i == 1), 0.0) for j in range(3) for i in range(4)]
    top = [(0, 0, 0.3), (0.3, 0, 0.3), (0.3, 0.25, 0.3), (0, 0.25, 0.3), (0.02, 0, 0.6), (0.33, 0, 0.58)]
    top += [(0.3, 0.27, 0.6), (0, 0.25, 0.63), (0.6, 0.1, 0.3), (0.6, 0.12, 0.55), (0.15, 0.12, 0.85)]
    bars = [(0.9, 0, 0.4), (1.2, 0.1, 0.5), (1.5, 0.3, 0.9), (0.2, 0.9, 0.3)]
    links = [(0.5, 0.25, -0.3), (1.6, 0.4, 1.0), (0.1, 0.1, -0.2), (0.2, 0.8, 0.2)]
    for first, points in ((1, places), (21, top), (41, bars), (70, links)):
        for k, point in enumerate(points):
            deck.grid(first + k, point)
    m, solid, mass = deck.moving([0.1, 0.2, 0.7]), deck.moving([-0.4, 0.3, 0.2]), deck.moving([0.9, 0.2, 0.1])
    deck.add(f"CQUAD4,1,1,1,2,6,5,{m},.004", "CQUAD4,2,2,2,3,7,6,25.,-.006", "CTRIA3,3,1,3,4,8,33.,.006")
    deck.add(f"CTRIA3,4,2,3,8,7,{m},-.003", f"CQUADR,5,1,5,6,10,9,{m},.002", "CQUAD4,6,2,6,7,11,10,25.")
    deck.add("CTRIAR,7,1,7,8,12,33.,.006", f"CTRIA3,8,2,7,12,11,{m},-.003")
    deck.add("PCOMP,1,-.002,3.5,,,,,,+\n+,8,.001,30.,YES,8,.002,-45.,YES,+\n+,1,.0015,0.,YES")
    deck.add("PSHELL,2,1,.008,1,.9,1,,4.", "MAT8,8,140.+9,9.+9,.3,5.+9,4.+9,3.+9,1600.", "MAT1,1,70.+9,,.33,2700.")
    deck.add(
        "CHEXA,31,31,21,22,23,24,25,26,+\n+,27,28", "CPENTA,32,32,22,29,23,26,30,27", "CPYRAM,33,32,25,26,27,28,31"
    )
    deck.add(f"PSOLID,31,9,{solid}", "PSOLID,32,1", "MAT9,9,40.+9,6.+9,5.+9,,,,20.+9,+\n+,4.+9,,,,15.+9,,,,+")
    deck.rows[-1] += "\n+,6.+9,,,5.+9,,4.+9,1800."
    c = [deck.moving([0.2, 1.1, -0.3 + k]) for k in range(3)]
    deck.add(f"CBUSH,50,5,1,21,,,,{c[0]},+\n+,.3", f"CBUSH,51,5,2,22,{deck.vector([0.3, 1, 0.2], 2)},,+\n+,.7")
    deck.add("CBUSH,52,5,6,23,12", f"CBUSH,53,5,5,24,,,,{c[1]},+\n+,,{c[2]},.03,.02,-.05")
    deck.add("PBUSH,5,K,1.+6,2.+6,3.+6,1.+4,2.+4,3.+4")
    v = deck.vector
    deck.add(
        f"CBEAM,61,61,4,41,{v([0.1, 1, 0.2], 4)},GGG,+\n+,,5,{v([0.01, 0.02, -0.01], 4)},{v([0, -0.015, 0.02], 41)}"
    )
    deck.add("CBEAM,62,61,41,42,44,,,,+\n+,45", "CBAR,64,63,30,41,31,,,,+\n+,,56")
    deck.add(f"CBAR,63,62,42,43,{v([1, 0.1, 0.3], 42)},GGG,+\n+,,6,{v([0.01, 0, 0.02], 42)},{v([0, 0.02, 0], 43)}")
    deck.add("CROD,65,65,43,9", "CONROD,66,12,43,1,2.-4,1.-8,,.4", "PROD,65,1,1.-4,3.-8,,.2")
    deck.add("PBEAM,61,1,4.-4,8.-8,5.-8,1.-8,9.-8,1.2,+\n+,,,,,,,,,+\n+,YES,1.,2.-4,3.-8,2.-8,.3-8,3.-8,.7,+")
    deck.rows[-1] += "\n+,,,,,,,,,+\n+,.8,.9,,,,,,,+\n+,.004,.003,.002,.001,.005,-.004,.003,.002"
    deck.add("PBAR,62,1,3.-4,6.-8,4.-8,7.-8,.6,,+\n+,,,,,,,,,+\n+,.83,.8,1.-8", "PBARL,63,1,,TUBE,,,,,+\n+,.02,.015,.3")
    deck.add("RBE3,80,,70,123456,1.,123,1,2,+\n+,3,2.5,123,9,10,12,.7,123456,+\n+,7", "RBE2,81,43,123456,71")
    deck.add("RBE2,82,8,123456,72", "RBAR,83,11,73,123456,,,123456", "CONM2,93,73,,1.5", "CONM2,92,72,,1.")
    deck.add(f"CONM2,90,70,{mass},4.,.03,.02,-.05,,+\n+,.1,.01,.12,-.02,.015,.09")
    deck.add(f"CONM2,91,71,,2.5,{words(deck.turn @ [0.01, 0.02, 0.03])}")


CASES = {
    "turned": ([0.5, -1.1, 0.8], (1.0, 2.0, -3.0), False),
    "own systems": ([0.0, 0.0, 0.0], (0.0, 0.0, 0.0), True),
    "both": ([-0.7, 0.4, 2.0], (-1.0, 0.5, 2.0), True),
}


def measures(tmp_path, vector, shift, own):
    deck = Deck(Rotation.from_rotvec(vector).as_matrix(), shift, own)
    structure(deck)
    fe = deck.write(tmp_path / "part.bdf")
    mass, centre = mass_and_center(fe)
    return mass, deck.turn.T @ (np.asarray(centre) - shift), fem.eigenmodes(fe, n=30).frequencies


@pytest.mark.parametrize("case", CASES)
def test_nothing_changes_but_the_axes(tmp_path, case):
    plain, turned = (measures(tmp_path, *given) for given in (([0.0] * 3, (0.0,) * 3, False), CASES[case]))
    assert plain[2][5] < 1e-3 < 0.1 < plain[2][6]  # one body: six rigid motions
    assert turned[0] == pytest.approx(plain[0], rel=1e-8)
    np.testing.assert_allclose(turned[1], plain[1], atol=1e-8)
    np.testing.assert_allclose(turned[2][6:], plain[2][6:], rtol=1e-6)


@pytest.mark.parametrize(("z0", "offset"), [("", 0.01), ("-.002", -0.02), ("0.", 0.005)])
def test_offsets_of_composites(tmp_path, z0, offset):
    """A strip of two plies with Z0 and ZOFFS: an axial force at the nodes bends it about its neutral plane."""
    n, length, width, e1, e2, t1, t2 = 10, 1.0, 0.1, 140e9, 9e9, 0.004, 0.003
    rows = ["BEGIN BULK", "MAT8,8,140.+9,9.+9,0.,5.+9,,,1600.", f"PCOMP,1,{z0},,,,,,,+\n+,8,{t1},0.,,8,{t2},90."]
    rows += [f"GRID,{1 + 2 * i + j},,{length * i / n},{width * j},0." for i in range(n + 1) for j in range(2)]
    rows += [f"CQUAD4,{i + 1},1,{1 + 2 * i},{3 + 2 * i},{4 + 2 * i},{2 + 2 * i},0.,{offset}" for i in range(n)]
    rows += [f"GRID,900,,{length},.05,0.", "RBE2,901,900,123456,21,22", "SPC1,1,123456,1,2", "ENDDATA"]
    path = tmp_path / "strip.bdf"
    path.write_text("\n".join(rows))
    fe = fem.read_deck(path, show=False)
    low = (float(z0) if z0 else -(t1 + t2) / 2) + offset
    area = np.array([e1 * t1, e2 * t2]) * width
    middle = np.array([low + t1 / 2, low + t1 + t2 / 2])
    neutral = area @ middle / area.sum()
    bending = area @ (np.array([t1, t2]) ** 2 / 12 + (middle - neutral) ** 2)
    load = np.zeros((len(fe.nodes), 6, 1))
    at = list(fe.labels).index(900)
    load[at, 0] = 1.0
    tip = fe.field(fem.static(fe, fe.forces(load)[:, 0], fem.fixed_freedoms(fe, "spc_1")))[at, :, 0]
    assert tip[0] == pytest.approx(length / area.sum() + neutral**2 * length / bending, rel=1e-8)
    assert tip[2] == pytest.approx(neutral * length**2 / 2 / bending, rel=1e-8)
