"""Geometric stiffness of unit loads: buckling and rotating beams in closed form, support independence, linearity."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import plate
from fem.structured import structured
from reduction.solids import STEEL, block
from scipy.linalg import eigh
from scipy.optimize import brentq

from flexmb import fem, reduction
from flexmb.model.material import Material
from flexmb.reduction.geometric import geometric_stiffness, inertia_loads
from flexmb.reduction.interfaces import resolve
from flexmb.reduction.markers import interface_motions
from flexmb.reduction.statics import HeldBody


def cantilever(width, height, length=2.0, n=20, material=STEEL):
    """Straight beam along x: width along y, height along z; slender beam theory (no shear, no rotary inertia)."""
    points = np.column_stack([np.linspace(0, length, n + 1), np.zeros(n + 1), np.zeros(n + 1)])
    return fem.frame(
        points,
        section=fem.Section.rectangle(width, height),
        material=material,
        shear=False,
        rotary_inertia=False,
    )


def reduced(fe, modes=20, **options):
    return reduction.reduce(
        fe, {"a": "start", "b": "end"}, modes=modes, frame="a", geometric_stiffness=True, compare=0, **options
    )


def buckling_load(data, geometric):
    """Smallest positive factor of the load at which K + factor * G is singular (K = diag(w2))."""
    root = np.sqrt(np.diag(data.stiffness))
    return 1.0 / np.linalg.eigvalsh(-geometric / np.outer(root, root)).max()


def test_euler_column_through_an_interface():
    """Clamped-free column: P = pi^2 E I / (4 L^2) (Euler)."""
    fe = cantilever(0.02, 0.03)
    data = reduced(fe)
    compression = -data.geometric.interface[1, 0]  # force along -x at b
    expected = np.pi**2 * 210e9 * 0.03 * 0.02**3 / 12 / (4 * 2.0**2)
    np.testing.assert_allclose(buckling_load(data, compression), expected, rtol=1e-5)


def test_lateral_torsional_buckling_through_an_interface():
    """Narrow cantilever under a transverse end force: P = 4.0126 sqrt(E I G J) / L^2 (Timoshenko & Gere, sec. 6.3)."""
    fe = cantilever(0.005, 0.1)  # bending stiff in z, soft in y
    data = reduced(fe, modes=30)
    down = -data.geometric.interface[1, 2]
    inertia = 0.1 * 0.005**3 / 12
    ratio = 0.005 / 0.1
    torsion = 0.1 * 0.005**3 / 3 * (1 - 0.63 * ratio * (1 - ratio**4 / 12))
    expected = 4.0126 * np.sqrt(210e9 * inertia * STEEL.shear * torsion) / 2.0**2
    # the prebuckling deflection (I_soft / I_stiff = 1/400) is not in the classical formula
    np.testing.assert_allclose(buckling_load(data, down), expected, rtol=4e-3)


@pytest.mark.parametrize("spin", [3.0, 12.0])
def test_rotating_cantilever(spin):
    """Flap frequencies for E I = rho A = L = 1 (Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982) 197)."""
    published = {3.0: [4.7973, 23.3203, 62.9850], 12.0: [13.1702, 37.6031, 79.6145]}[spin]
    side = 1e-3
    material = Material(young=12.0 / side**4, poisson=0.3, density=1.0 / side**2)
    fe = cantilever(side, side, length=1.0, n=40, material=material)
    data = reduced(fe, modes=30)
    centripetal = -(spin**2) * np.diag([1.0, 1.0, 0.0])  # w~ w~ for a spin about z
    stiffness = data.stiffness + np.einsum("i,iab->ab", centripetal.ravel(), data.geometric.inertia[3:])
    w2, shapes = eigh(stiffness)
    tip = data.marker_translations[1] @ shapes
    flap = np.abs(tip[2]) > np.abs(tip[1])
    # the axial force is constant within each of the 40 elements: second order in their length
    np.testing.assert_allclose(np.sqrt(w2[flap][:3]), published, rtol=2.5e-4)
    lag = np.sqrt(w2[np.abs(tip[1]) > np.abs(tip[2])][:3] - spin**2)  # in the plane: the frame turns, w2 - spin^2
    np.testing.assert_allclose(lag, np.sqrt(w2[flap][:3] - spin**2), rtol=1e-9)


def body_with_shapes(fe, interfaces):
    body = HeldBody(fe, resolve(fe, interfaces))
    rng = np.random.default_rng(11)
    shapes = fe.vectors(
        np.concatenate([rng.standard_normal((len(fe.nodes), 3, 4)), np.zeros((len(fe.nodes), 3, 4))], axis=1)
    )
    return body, interface_motions(fe, body.couplings), shapes


MODELS = {
    "solid": lambda: (
        block(divisions=(4, 2, 1)),
        {"a": "left", "b": "right", "c": reduction.Averaging("mid", at=(0.25, 0.1, -0.1))},
    ),
    "frame": lambda: (
        cantilever(0.02, 0.03, n=6),
        {"a": "start", "b": reduction.Rigid("end", at=(2.5, 0.1, 0.0)), "c": [3]},
    ),
    "shells with a beam": lambda: (stiffened_sheet(), {"a": "left", "b": "right", "c": reduction.Averaging("mid")}),
}


def stiffened_sheet():
    """A sheet of shells with a beam along its middle line."""
    sheet = plate(6, 2, 1.0, 0.3, "quad")
    x = sheet.points[:, 0]
    sets = {"left": x < 1e-9, "right": x > 1 - 1e-9, "mid": np.abs(x - 0.5) < 0.2}
    skin = fem.shell(replace(sheet, node_sets={k: np.flatnonzero(v) for k, v in sets.items()}), STEEL, 0.004)
    line = np.linspace((0.0, 0.15, 0.0), (1.0, 0.15, 0.0), 7)
    return fem.joined(skin, fem.frame(line, section=fem.Section.tube(0.03, 0.002), material=STEEL))


@pytest.mark.parametrize("kind", MODELS)
def test_the_sum_does_not_depend_on_the_support(kind, rng):
    """Any acceleration field and interface loads in equilibrium: the same sum for every determinate support."""
    fe, interfaces = MODELS[kind]()
    body, markers, shapes = body_with_shapes(fe, interfaces)
    nothing = np.zeros((fe.ndof, 0))
    supports = [
        np.arange(0, 6),
        np.arange(6, 12),
        np.array([0, 1, 2, 3, 7, 8]),
        np.array([12, 13, 14, 15, 16, 17]),
    ]
    sets = [geometric_stiffness(body, shapes, markers, nothing, np.zeros(fe.ndof), support) for support in supports]
    acceleration = rng.standard_normal(12)
    loads = rng.standard_normal((3, 6)) * 100.0
    rigid = fe.rigid_motions()
    forces = inertia_loads(fe) @ acceleration
    for marker, load in zip(markers, loads, strict=True):
        forces = forces + marker.matrix.T @ load
    at_a = np.linalg.solve(rigid.T @ markers[0].matrix.T.toarray(), -rigid.T @ forces)  # what holds the body, at a
    loads[0] += at_a
    sums = [
        np.einsum("i,iab->ab", acceleration, g.inertia) + np.einsum("ik,ikab->ab", loads, g.interface) for g in sets
    ]
    parts = [np.abs(np.einsum("i,iab->ab", acceleration, g.inertia)).max() for g in sets]
    assert max(parts) > 1.5 * min(parts)  # the parts differ ...
    for other in sums[1:]:  # ... their sum does not
        np.testing.assert_allclose(other, sums[0], atol=1e-8 * np.abs(sums[0]).max())


@pytest.mark.parametrize("kind", [reduction.Rigid, reduction.Averaging])
@pytest.mark.parametrize("arm", [0.5, -0.3])
def test_load_beside_the_nodes_of_its_interface(kind, arm):
    """Marker b at a rigid extension a of a clamped column L: tan(k L) = 1 / (k a), P = k^2 E I."""
    fe = cantilever(0.02, 0.01, length=1.0)
    interfaces = {"a": "start", "b": kind("end", at=(1.0 + arm, 0.0, 0.0))}
    data = reduction.reduce(fe, interfaces, modes=14, geometric_stiffness=True, compare=0, frame="a")
    found = 1.0 / np.linalg.eigvals(np.linalg.solve(data.stiffness, data.geometric.interface[1, 0])).real.max()
    low, high = (1e-6, np.pi / 2) if arm > 0.0 else (np.pi / 2 + 1e-6, np.pi)
    k = brentq(lambda k: np.cos(k) - arm * k * np.sin(k), low, high)
    assert found == pytest.approx(k**2 * STEEL.young * 0.02 * 0.01**3 / 12.0, rel=1e-5)


@pytest.mark.parametrize("kind", [reduction.Rigid, reduction.Averaging])
def test_solid_column_with_a_load_beside_its_face(kind):
    """The same with solids (nu = 0): Engesser's column, whose clamped end sees the lever too, within 1 %."""
    side, length, arm = 0.02, 0.4, 0.2
    plain = Material(young=210e9, poisson=0.0, density=7850.0)
    mesh = structured("hexahedron20", (10, 1, 1), (length, side, side))
    fe = fem.solid(mesh, plain)
    interfaces = {"a": "x0", "b": kind("x1", at=(length + arm, side / 2, side / 2))}
    data = reduction.reduce(fe, interfaces, modes=14, geometric_stiffness=True, compare=0, frame="a")
    found = 1.0 / np.linalg.eigvals(np.linalg.solve(data.stiffness, data.geometric.interface[1, 0])).real.max()
    k = brentq(lambda k: np.cos(k * length) - arm * k * np.sin(k * length), 1e-6, np.pi / 2 / length)
    assert found == pytest.approx(k**2 * plain.young * side**4 / 12.0, rel=0.01)


def test_weight_above_a_column():
    """A mass on a rigid arm above a light column, its own weight the load: tan(k L) = 1 / (k a), m g = k^2 E I."""
    arm, mass = 0.5, 3.0
    light = Material(young=210e9, poisson=0.3, density=1e-3 * STEEL.density)
    fe = cantilever(0.02, 0.01, length=1.0, material=light)
    fe = fem.with_mass(fem.with_rigid_link(fe, (1.0 + arm, 0.0, 0.0), "end", "top"), "top", mass, (1e-3, 1e-3, 1e-3))
    data = reduction.reduce(fe, {"a": "start", "b": "top"}, modes=14, geometric_stiffness=True, compare=0, frame="a")
    found = 1.0 / np.linalg.eigvals(-np.linalg.solve(data.stiffness, data.geometric.inertia[0])).real.max()
    k = brentq(lambda k: np.cos(k) - arm * k * np.sin(k), 1e-6, np.pi / 2)
    assert found * mass == pytest.approx(k**2 * STEEL.young * 0.02 * 0.01**3 / 12.0, rel=2e-3)


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_rigid_links_and_rigid_interfaces_are_the_same(frame):
    """The same ends, tied by the model or by the reduction: the same stiffness of the same axial load."""
    fe = block(size=(0.4, 0.06, 0.04), divisions=(6, 1, 1))
    linked = fem.with_rigid_link(
        fem.with_rigid_link(fe, (0.0, 0.03, 0.02), "left", "A"), (0.4, 0.03, 0.02), "right", "B"
    )
    found = []
    for model, (a, b) in ((fe, ("left", "right")), (linked, ("A", "B"))):
        data = reduction.reduce(
            model,
            {"a": reduction.Rigid(a, at=(0.0, 0.03, 0.02)), "b": reduction.Rigid(b, at=(0.4, 0.03, 0.02))},
            modes=8,
            geometric_stiffness=True,
            compare=0,
            frame=frame,
        )
        G = data.geometric.interface[0, 0] - data.geometric.interface[1, 0]
        found.append(np.sort(np.linalg.eigvals(np.linalg.solve(data.stiffness, G)).real))
    np.testing.assert_allclose(found[1], found[0], atol=1e-8 * np.abs(found[0]).max())


def test_inertia_loads_balance_the_rigid_body(rng):
    """Antisymmetric fields are rigid angular accelerations: the loads are -M P X alpha, exactly."""
    fe = cantilever(0.02, 0.03, n=5)
    alpha = rng.standard_normal(3)
    matrix = np.cross(alpha, np.eye(3)).T
    np.testing.assert_allclose(matrix @ np.ones(3), np.cross(alpha, np.ones(3)))
    forces = inertia_loads(fe)
    np.testing.assert_allclose(forces[:, 3:] @ matrix.ravel(), -fe.M @ (fe.rigid_motions()[:, 3:] @ alpha), atol=1e-12)
    np.testing.assert_allclose(forces[:, :3], -(fe.M @ fe.rigid_motions()[:, :3]), atol=1e-15)


def test_preload_and_load_shapes_are_linear():
    fe = block(divisions=(4, 2, 1))
    options = {
        "modes": 3,
        "geometric_stiffness": True,
        "compare": 0,
        "loads": {"air": "top", "tip": {3: (1.0, 2.0, 3.0)}},
    }
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, preload={"air": 5e3, "tip": -20.0}, **options)
    g = data.geometric
    np.testing.assert_allclose(g.preload, 5e3 * g.loads[0] - 20.0 * g.loads[1], atol=1e-10 * np.abs(g.preload).max())
    twice = reduction.reduce(fe, {"a": "left", "b": "right"}, preload={"air": 1e4, "tip": -40.0}, **options)
    np.testing.assert_allclose(twice.geometric.preload, 2.0 * g.preload, rtol=1e-9, atol=1e-9 * np.abs(g.preload).max())


def test_euler_column_of_solids():
    """Clamped-free column of tet10, length / width = 20: within 2 % of Euler's load (coarse mesh)."""
    fe = block((0.4, 0.02, 0.02), (10, 1, 1))
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=10, frame="a", geometric_stiffness=True, compare=0)
    np.testing.assert_allclose(
        buckling_load(data, -data.geometric.interface[1, 0]),
        np.pi**2 * 210e9 * 0.02**4 / 12 / (4 * 0.4**2),
        rtol=0.02,
    )
