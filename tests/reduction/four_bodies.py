"""Four bodies on which bases are compared, and the exact response of their full models by dense matrices."""

from functools import cache

import numpy as np
from scipy.linalg import eigh

from flexmb import fem
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import MATERIALS
from flexmb.reduction.interfaces import resolve

STEEL, ALUMINIUM = MATERIALS["steel"], MATERIALS["aluminium"]


def beam():
    """A bar of 2 m between its ends."""
    points = np.column_stack([np.linspace(0.0, 2.0, 25), np.zeros(25), np.zeros(25)])
    fe = fem.frame(points, section=fem.Section.rectangle(0.04, 0.06), material=STEEL, name="beam")
    return fe, {"a": [0], "b": [24]}, 600.0


def plate():
    """A plate of 0.6 m x 0.4 m x 4 mm, held at two corners and the middle of an edge."""
    x, y = np.meshgrid(np.linspace(0.0, 0.6, 11), np.linspace(0.0, 0.4, 8), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    mesh = Mesh(points=points, cells=(("quad", _quads(11, 8)),), node_sets={}, facet_sets={}, name="plate")
    fe = fem.shell(mesh, ALUMINIUM, 0.004, stress_side=1)
    return fe, {"a": [0], "b": [80], "c": [47]}, 400.0


def crank():
    """A crankshaft of one throw: two journals, two webs and a pin, of bricks of 20 mm."""
    boxes = [((0, 3), (0, 2)), ((3, 4), (0, 5)), ((4, 7), (3, 5)), ((7, 8), (0, 5)), ((8, 11), (0, 2))]
    grid = np.arange(12 * 3 * 6).reshape(12, 3, 6)
    cells = [
        grid[i : i + 2, j : j + 2, k : k + 2]
        for (first, last), (low, high) in boxes
        for i in range(first, last)
        for j in range(2)
        for k in range(low, high)
    ]
    order = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    numbers = np.array([[cell[place] for place in order] for cell in cells])
    used, numbers = np.unique(numbers, return_inverse=True)
    points = 0.02 * np.stack(np.unravel_index(used, grid.shape), axis=1).astype(float)
    x, _, z = points.T
    sets = {
        "left": np.flatnonzero(x < 1e-9),
        "right": np.flatnonzero(x > 0.2199),
        "pin": np.flatnonzero((abs(x - 0.11) < 0.011) & (z > 0.0599)),
    }
    mesh = Mesh(
        points=points, cells=(("hexahedron", numbers.reshape(-1, 8)),), node_sets=sets, facet_sets={}, name="crank"
    )
    return fem.solid(mesh, STEEL), {"left": "left", "right": "right", "pin": "pin"}, 8000.0


def wing():
    """The skin and two spars of a swept, tapered wing of 2 m, 3 mm thick, with fittings at root, middle and tip."""
    around, along = 8, 11
    angle = 2.0 * np.pi * np.arange(around) / around
    s = np.linspace(0.0, 1.0, along)[:, None]
    chord = 0.4 - 0.2 * s
    x = 0.5 * s + 0.5 * chord * np.cos(angle)
    z = 0.06 * chord / 0.4 * np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** 0.5 + 0.05 * s**2
    points = np.stack([x, np.broadcast_to(2.0 * s, x.shape), z], axis=2).reshape(-1, 3)
    ring = np.arange(around)
    skin = [
        np.stack([k * around + ring, k * around + (ring + 1) % around, (k + 1) * around + (ring + 1) % around,
                  (k + 1) * around + ring], axis=1)
        for k in range(along - 1)
    ]  # fmt: skip
    spars = [
        [k * around + up, k * around + down, (k + 1) * around + down, (k + 1) * around + up]
        for k in range(along - 1)
        for up, down in ((1, 7), (3, 5))
    ]
    cells = np.vstack([*skin, spars])
    mesh = Mesh(points=points, cells=(("quad", cells),), node_sets={}, facet_sets={}, name="wing")
    fe = fem.shell(mesh, ALUMINIUM, 0.003, stress_side=1)
    row = lambda k: list(range(k * around, (k + 1) * around))  # noqa: E731
    return fe, {"root": row(0), "fitting": [5 * around + 6], "tip": row(along - 1)}, 120.0


def short_crank():
    """The crankshaft with its journals only, for loads near 20 kHz."""
    fe, interfaces, _ = crank()
    return fe, {name: interfaces[name] for name in ("left", "right")}, 8000.0


def long_table():
    """The bar with nine places where something is fastened: 54 freedoms of interfaces."""
    fe, _, band = beam()
    return fe, {f"n{k}": [k] for k in range(0, 25, 3)}, band


def edge():
    """The plate fastened at the eight nodes of its short edge: 48 freedoms of interfaces."""
    fe, _, _ = plate()
    return fe, {f"n{k}": [k] for k in range(8)}, 200.0


BODIES = {"beam": beam, "plate": plate, "crank": crank, "wing": wing}
OTHERS = {"short crank": short_crank, "long table": long_table, "edge": edge}


def _quads(nx, ny):
    grid = np.arange(nx * ny).reshape(nx, ny)
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)


@cache
def body(name):
    """FE model, interfaces, band (Hz), and its elastic modes: 1/w2 and the shares of the interface loads in them."""
    fe, interfaces, band = (BODIES | OTHERS)[name]()
    couplings = resolve(fe, interfaces)
    tied = np.concatenate([c.rows for c in couplings])
    free = np.setdiff1d(np.arange(fe.ndof), tied)
    columns = sum(len(c.freedoms) for c in couplings)
    G = np.zeros((fe.ndof, len(free) + columns))
    G[free, np.arange(len(free))] = 1.0
    start, size = len(free), np.linalg.norm(fe.nodes - fe.nodes.mean(axis=0), axis=1).max()
    loads = np.zeros((G.shape[1], columns))
    for c in couplings:
        places = np.arange(start, start + len(c.freedoms))
        G[np.ix_(c.rows, places)] = c.matrix
        loads[places, places - len(free)] = np.where(c.freedoms < 3, 1.0, size)
        start += len(c.freedoms)
    K, M = G.T @ (fe.K @ G), G.T @ (fe.M @ G)
    rigid = np.linalg.lstsq(G, fe.rigid_motions(), rcond=None)[0]
    elastic = np.linalg.qr(M @ rigid, mode="complete")[0][:, 6:]
    mu, modes = eigh(elastic.T @ M @ elastic, elastic.T @ K @ elastic)
    return fe, interfaces, band, mu, modes.T @ (elastic.T @ loads)


def responses(mu, share, hertz, zeta):
    """H = F^T ((1 + 2 i zeta) K - w2 M)^-1 F from modes of unit stiffness."""
    return np.array([(share.T / ((1 + 2j * zeta) - (2 * np.pi * f) ** 2 * mu)) @ share for f in hertz])


def true_error(name, data, hertz=None):
    """Relative error of the response of a reduced body (Buckens frame), by default at the lines of its bound."""
    _, _, _, mu, share = body(name)
    told, rows = data.quality["transfer"], []
    hertz = told["frequencies"] if hertz is None else hertz
    for k, row in enumerate(data.quality["interfaces"]):
        for f in row["freedoms"]:
            motion = data.marker_translations[k, f] if f < 3 else data.marker_rotations[k, f - 3] * told["length"]
            rows.append(motion)
    own_mu, own = eigh(data.invariants.nn, data.stiffness)
    full = responses(mu, share, hertz, told["damping"])
    found = responses(own_mu, own.T @ np.array(rows).T, hertz, told["damping"])
    return np.linalg.norm(full - found, 2, axis=(1, 2)).max() / np.linalg.norm(full, 2, axis=(1, 2)).max()


def snapshots(fe, interfaces, band):
    """Displacements under each interface load at twelve frequencies over the band, for a basis of a run."""
    from flexmb.reduction.framed_body import FramedBody
    from flexmb.reduction.markers import interface_motions
    from flexmb.reduction.statics import HeldBody

    couplings = resolve(fe, interfaces)
    free = FramedBody(HeldBody(fe, couplings), None, interface_motions(fe, couplings), np.zeros((fe.ndof, 0)))
    w2 = (2.0 * np.pi * np.linspace(0.0, band, 12)) ** 2
    return np.hstack([free.response(free.inputs, square) for square in w2])


def by_pymor(name, orders, hertz, zeta=0.01, candidates=100):
    """Return (order, relative error) of pyMOR's position-velocity balanced truncation of the elastic modes."""
    from pymor.models.iosys import SecondOrderModel
    from pymor.reductors.sobt import SOBTpvReductor

    _, _, band, mu, share = body(name)
    lowest = np.argsort(mu)[::-1][:candidates]
    w2, force = 1.0 / mu[lowest], share[lowest] / np.sqrt(mu[lowest])[:, None]  # of unit mass
    own_scale = (2.0 * np.pi * band) ** 2  # of time: Gramians of rad/s in 1e5 lose digits
    w2 = w2 / own_scale
    model = SecondOrderModel.from_matrices(
        np.eye(len(w2)), np.diag(2.0 * zeta * np.sqrt(w2)), np.diag(w2), force, force.T
    )
    reductor, found = SOBTpvReductor(model), []
    full = responses(mu, share, hertz, zeta)
    for order in orders:
        reductor.reduce(order)
        V = np.linalg.qr(reductor.V.to_numpy().reshape(len(w2), -1))[0]
        own_mu, own = eigh(np.eye(V.shape[1]), V.T @ (w2[:, None] * V))
        other = responses(own_mu / own_scale, own.T @ (V.T @ force) / np.sqrt(own_scale), hertz, zeta)
        worst = np.linalg.norm(full - other, 2, axis=(1, 2)).max()
        found.append((order, worst / np.linalg.norm(full, 2, axis=(1, 2)).max()))
    return found
