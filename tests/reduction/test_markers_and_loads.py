"""Markers follow rigid motion and strain exactly; load shapes have the resultants of their loads; damping proposals."""

from pathlib import Path

import numpy as np
import pytest
from reduction.solids import STEEL, block
from tolerances import MACHINE

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ReductionError
from flexmb.reduction.interfaces import resolve, rigid_block
from flexmb.reduction.loads import load_vectors
from flexmb.reduction.markers import interface_motions, station_motions

EVERY_STATION = {
    "set": "mid",
    "node": [5],
    "inside": (0.213, 0.021, 0.017),
    "outside": (0.2, 0.03, 0.3),
    "near": (0.2, 0.03, 0.045),
    "nodes": [0, 7, 20, 33, 50],
}


@pytest.fixture(scope="module")
def fe():
    return block()


@pytest.fixture(scope="module")
def beam():
    points = np.linspace((0.0, 0.0, 0.0), (1.0, 0.5, 0.2), 6)
    return fem.frame(points, section=fem.Section.rectangle(0.02, 0.03), material=STEEL, shear=False)


def assert_rigid(fe, markers):
    for marker in markers:
        motion = marker.matrix @ rigid_block(fe, np.arange(fe.ndof), marker.position)
        assert np.abs(motion - np.eye(6)).max() < 100 * MACHINE, marker.name


def test_stations_follow_rigid_motion(fe, beam):
    assert_rigid(fe, station_motions(fe, EVERY_STATION))
    assert_rigid(
        beam,
        station_motions(beam, {"node": [2], "on": (0.45, 0.225, 0.09), "off": (0.5, 0.3, 0.4), "set": [1, 2, 4]}),
    )


def test_interfaces_follow_rigid_motion(fe):
    kinds = {"a": "left", "b": reduction.Averaging("right", at=(0.5, 0.0, 0.0)), "c": reduction.Nodes([30])}
    couplings = resolve(fe, kinds)
    assert_rigid(fe, interface_motions(fe, couplings))
    np.testing.assert_allclose(couplings[0].position, fe.nodes[fe.node_set("left")].mean(axis=0))


def test_bare_nodes_become_one_interface_each(fe):
    names = [c.name for c in resolve(fe, {"pin": reduction.Nodes([30, 31])})]
    assert names == ["pin_30", "pin_31"]


@pytest.mark.parametrize("station", ["node", "inside", "near"])
def test_station_in_a_quadratic_displacement(fe, station):
    """u = (a x z, b x y, -a x^2 / 2 + c y z): translation and half the curl, in closed form."""
    a, b, c = 1e-3, -2e-3, 3e-3
    x, y, z = fe.nodes.T
    field = np.zeros((len(fe.nodes), 6, 1))
    field[:, 0, 0], field[:, 1, 0], field[:, 2, 0] = a * x * z, b * x * y, -a * x**2 / 2 + c * y * z
    marker = station_motions(fe, EVERY_STATION | {"inside": (0.213, 0.021, 0.017)})[list(EVERY_STATION).index(station)]
    x, y, z = marker.position
    expected = [
        a * x * z,
        b * x * y,
        -a * x**2 / 2 + c * y * z,
        0.5 * c * z,
        0.5 * (a * x + a * x),
        0.5 * b * y,
    ]
    np.testing.assert_allclose((marker.matrix @ fe.vectors(field))[:, 0], expected, atol=1e-3 * MACHINE**0.5)


def test_station_on_a_beam_takes_the_cubic(beam):
    """Tip-loaded cantilever: w = F x^2 (3 L - x) / 6 EI and its slope, exact at a point between the nodes."""
    along = np.array([1.0, 0.5, 0.2])
    L = np.linalg.norm(along)
    t = along / L
    n = np.cross(t, [0.3, -0.4, 0.8])
    n /= np.linalg.norm(n)
    x = beam.nodes @ t
    field = np.zeros((len(x), 6, 1))
    field[:, :3, 0] = np.outer(x**2 * (3 * L - x), n)
    field[:, 3:, 0] = np.outer(6 * L * x - 3 * x**2, np.cross(t, n))
    s = 0.333 * L
    marker = station_motions(beam, {"p": tuple(s * t)})[0]
    motion = (marker.matrix @ beam.vectors(field))[:, 0]
    np.testing.assert_allclose(motion[:3], s**2 * (3 * L - s) * n, atol=MACHINE)
    np.testing.assert_allclose(motion[3:], (6 * L * s - 3 * s**2) * np.cross(t, n), atol=10 * MACHINE)


def test_station_must_be_one_point(fe):
    with pytest.raises(
        ReductionError, match=r"Station 's': 2 points\. Expected: one point.*Name one station per point"
    ):
        station_motions(fe, {"s": np.array([[0.0, 0, 0], [1, 0, 0]])})


def resultant(fe, load):
    return fe.rigid_motions().T @ load_vectors(fe, {"air": load})[:, 0]


def test_pressure_has_the_resultant_of_the_surface(fe):
    """Top face 0.4 x 0.06 at z = 0.04, outward normal +z: a pressure pushes down with F = A, M = r_c x F with r_c the
    middle of the face."""
    area, middle = 0.4 * 0.06, np.array([0.2, 0.03, 0.04])
    force = np.array([0.0, 0.0, -area])
    np.testing.assert_allclose(resultant(fe, "top"), [*force, *np.cross(middle, force)], atol=MACHINE)
    tilted = np.array([0.6, 0.0, 0.8]) * area
    np.testing.assert_allclose(
        resultant(fe, reduction.Pressure("top", direction=(3, 0, 4))),
        [*tilted, *np.cross(middle, tilted)],
        atol=MACHINE,
    )


def test_nodal_forces_and_line_load(fe, beam):
    np.testing.assert_allclose(resultant(fe, {7: (1.0, 2.0, 3.0)}), [1, 2, 3, *np.cross(fe.nodes[7], [1, 2, 3])])
    np.testing.assert_allclose(resultant(beam, {2: (0, 0, 0, 1.0, 2.0, 3.0)}), [0, 0, 0, 1, 2, 3])
    L, middle = np.linalg.norm([1.0, 0.5, 0.2]), np.array([0.5, 0.25, 0.1])
    force = np.array([0.0, 0.0, -L])
    load = reduction.LineLoad(list(range(6)), (0, 0, -2))
    np.testing.assert_allclose(resultant(beam, load), [*force, *np.cross(middle, force)], atol=MACHINE)


def test_line_load_deflects_a_cantilever_by_the_closed_form(beam):
    """w = q L^4 / 8 EI at the tip of a cantilever under uniform load: nodally exact for cubic beams."""
    L = np.linalg.norm([1.0, 0.5, 0.2])
    n = np.array([0.0, 0.2, -0.5]) / np.linalg.norm([0.0, 0.2, -0.5])
    F = load_vectors(beam, {"q": reduction.LineLoad(list(range(6)), n)})
    u = np.linalg.solve(beam.K.toarray()[6:, 6:], F[6:, 0])
    stiffness = 210e9 * 0.02 * 0.03 / 12 * np.array([0.02**2, 0.03**2])
    soft, hard = L**4 / 8 / stiffness
    assert min(soft, hard) * (1 - 1e-9) <= np.linalg.norm(u[-6:-3]) <= max(soft, hard) * (1 + 1e-9)


@pytest.mark.parametrize(
    ("load", "match"),
    [
        ("topp", r"Load 'air': the facet set 'topp' does not exist\. One of: .*top\. Did you mean 'top'\?"),
        ("mid", r"the facet set 'mid' is a node set without facets"),
        (reduction.Pressure("top", direction=(0, 0, 0)), r"direction .*three numbers, not all zero"),
        ({3: (1.0, 2.0)}, r"node 3 with a force of shape \(2,\)"),
        ({100000: (1.0, 2.0, 0.0)}, r"node 100000 with a force"),
        (
            {3: (0, 0, 0, 0, 1.0, 0)},
            r"a load on node 3 in rotation y\. Expected: a freedom that the node has.*Solid nodes carry no moments",
        ),
        (reduction.LineLoad("mid", (0, 0, 1)), r"no line element has all its nodes in 'mid'"),
        (3.0, r"Load 'air': float\. Expected: a facet set's name"),
    ],
)
def test_refused_loads(fe, load, match):
    with pytest.raises(ReductionError, match=match):
        load_vectors(fe, {"air": load})


def ratios(damping, fe):
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=2, damping=damping, compare=0)
    return data.damping_ratios, 2 * np.pi * data.frequencies


def test_damping_proposals(fe):
    zeta, w = ratios(None, fe)
    np.testing.assert_array_equal(zeta, 0.0)
    np.testing.assert_array_equal(ratios(0.02, fe)[0], np.full(len(w), 0.02))
    np.testing.assert_array_equal(ratios(np.linspace(0, 0.1, len(w)), fe)[0], np.linspace(0, 0.1, len(w)))
    np.testing.assert_allclose(
        ratios(reduction.Rayleigh(mass=3.0, stiffness=1e-5), fe)[0], 3.0 / (2 * w) + 1e-5 * w / 2
    )
    middle = np.sqrt(w[1] * w[2]) / (2 * np.pi)
    bands = reduction.Bands(((middle, 0.01), (2 * middle, 0.02), (3 * middle, 0.05)))
    f = w / (2 * np.pi)
    np.testing.assert_array_equal(ratios(bands, fe)[0], np.select([f <= middle, f <= 2 * middle], [0.01, 0.02], 0.05))


@pytest.mark.parametrize(
    ("damping", "match"),
    [
        ([0.1, 0.2], r"Damping: 2 ratios\. Expected: one, or one per mode"),
        (-0.1, r"a ratio of -0\.1\. Expected: numbers from 0 upwards"),
        (reduction.Bands(((100.0, 0.1), (50.0, 0.2))), r"bands up to .*rising upper frequencies"),
    ],
)
def test_refused_damping(fe, damping, match):
    with pytest.raises(ReductionError, match=match):
        ratios(damping, fe)


def test_interface_of_a_surface_sits_at_its_centroid():
    """The bores of the connecting rod lie at the origin and at x = 0.32 m; their mean is a millimetre off."""
    rod = fem.solid(fem.read_mesh(Path(__file__).parents[2] / "meshes" / "conrod.msh"), STEEL)
    a, b = resolve(rod, {"a": "bore_a", "b": "bore_b"})
    np.testing.assert_allclose(a.position, [0.0, 0.0, 0.0], atol=2e-6)
    np.testing.assert_allclose(b.position, [0.32, 0.0, 0.0], atol=2e-6)
    assert np.linalg.norm(rod.nodes[a.nodes].mean(axis=0)) > 1e-3
    given = resolve(rod, {"a": reduction.Rigid("bore_a", at=(0.0, 0.0, 0.01))})[0]
    np.testing.assert_array_equal(given.position, [0.0, 0.0, 0.01])


def test_pressure_has_one_sign(fe):
    """The load shape is the nodal forces of the same pressure: both push onto the surface, as PLOAD4 does."""
    np.testing.assert_allclose(load_vectors(fe, {"air": "top"})[:, 0], fem.pressure_load(fe, "top", 1.0), atol=1e-16)
    u = fe.field(fem.static(fe, fem.pressure_load(fe, "top", 1e6), {"left": "xyz"}))
    tip = u[fe.node_set("right"), 2, 0].mean()
    assert tip < 0.0  # the outward normal of the top is +z
    data = reduction.reduce(
        fe, {"a": "left", "b": reduction.Averaging("right")}, modes=2, loads={"air": "top"}, residual_vectors=["air"]
    )
    body = fmb.FloatingBody("bar", data=data)
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"a": body.marker_poses()["a"]}), body],
        joints=[fmb.Fixed("clamp", markers=("ground.a", "bar.a"))],
        forces=[fmb.Pressure("air", load="bar.air", amount=1e6)],
        sensors=[fmb.Position("tip", marker="bar.b")],
    )
    drawn = fmb.FloatingBody("bar", data=data).marker_poses()["b"].at
    moved = fmb.statics(model)["tip"][-1] - np.asarray(drawn)
    assert moved[2] == pytest.approx(tip, rel=1e-2)
