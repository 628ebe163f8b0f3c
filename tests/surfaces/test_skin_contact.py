"""Skins of two deforming bodies: derivatives, momenta, energy, and loads against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from contracts import test_tangents
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from reduction.solids import block
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.forces.skin_rows import ROW
from flexmb.forces.skin_wrench import COLUMNS, SPOT, act_on_skins
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.energies import Energy
from flexmb.math.switches import GAP
from flexmb.surfaces.skin_faces import FACET, PLACE, corner_boxes, nearest_face, packed_faces, signed_place
from flexmb.system import compile as compile_model
from flexmb.system.program import evaluate

L, B, HIGH = 0.4, 0.04, 0.01
LAW = fmb.ElasticFoundation(modulus=2e9, thickness=0.01, friction=0.3, damping=0.2)
CORNERS = np.array([[0.02, 0.02, 0.02], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1]])
FACE, LINE = np.array([[0, 1, 2]]), np.array([[0, 1, -1]])


@pytest.fixture(scope="module")
def beam():
    """A beam of steel whose left end is an interface."""
    fe = block((L, B, HIGH), (20, 2, 1))
    left = np.flatnonzero(fe.nodes[:, 0] < 1e-9)
    return reduction.reduce(fe, interfaces={"root": left}, modes=12, stations={"tip": (L, 0, 0)})


def acting(facets, radius, r, v, w, y, m):
    """Return the wrenches (24,), minus their derivatives, and the place."""
    faces, nodes, _ = packed_faces(CORNERS, facets)
    data = np.concatenate([faces.ravel(), nodes.ravel()])
    X, boxes = r[1:].copy(), np.empty((len(nodes), 6))
    corner_boxes(data, 0, faces.size, len(nodes), X, boxes)
    places, spots, law = np.zeros(1, PLACE), np.zeros(1, SPOT), np.zeros(1, ROW)
    for name, value in LAW.numbers().items():
        if name in ROW.names:
            law[name] = value
    for name, value in {"r": r, "v": v, "w": w, "y": y, "m": m, "area": 0.3, "radius": radius}.items():
        spots[name][0] = value
    nearest_face(data, 0, faces.size, X, boxes, r[0] + y, 10.0, places[0])
    signed_place(data, 0, X, r[0] + y, radius == 0.0, places[0])
    wrench, K, D = np.zeros((4, 6)), np.zeros((COLUMNS, COLUMNS)), np.zeros((COLUMNS, COLUMNS))
    act_on_skins(law[0], places[0], spots[0], True, wrench, K, D, np.zeros(1, Energy.dtype))
    return wrench.ravel(), K, D, places[0]


@pytest.mark.parametrize(
    ("facets", "radius", "z", "where"),
    [
        (FACE, 0.0, (0.3, 0.3, -0.02), 0),
        (FACE, 0.2, (0.3, 0.3, 0.1), 0),
        (FACE, 0.3, (0.3, 0.3, -0.1), 0),
        (FACE, 0.2, (0.5, -0.1, 0.1), 1),
        (FACE, 0.2, (-0.1, -0.1, 0.02), 4),
        (LINE, 0.3, (0.5, 0.1, 0.2), 1),
        (LINE, 0.3, (1.1, 0.1, 0.2), 5),
    ],
)
@pytest.mark.parametrize("tilt", [0.3, 1.2])
def test_derivatives_of_a_spot(facets, radius, z, where, tilt, rng):
    """Against central differences by displacements and turns, and by velocities; forces and moments are in balance."""
    y = 0.1 * rng.standard_normal(3)
    r = np.vstack([z - y, CORNERS])
    v, w = 0.1 * rng.standard_normal((2, 4, 3))
    if radius == 0.0:
        w[1:] = 0.0
    n = acting(facets, radius, r, v, w, y, np.ones(3))[3]["n"]
    side = np.cross(n, rng.standard_normal(3))
    m = Rotation.from_rotvec(tilt * side / np.linalg.norm(side)).apply(-n)
    given = (r, v, w, y, m)
    wrench, K, D, place = acting(facets, radius, *given)
    assert place["where"] == where
    assert np.abs(wrench).max() > 1.0
    for column in range(COLUMNS):
        marker, axis = divmod(column, 6)
        found = {"K": 0.0, "D": 0.0}
        for sign in (1.0, -1.0):
            e = 1e-6 * sign * np.eye(3)[axis % 3]
            r2, v2, w2 = r.copy(), v.copy(), w.copy()
            y2, m2 = y, m
            if axis < 3:
                r2[marker] += e
                v2[marker] += e
            else:
                w2[marker] += e
                if marker == 0:
                    y2, m2 = Rotation.from_rotvec(e).apply([y, m])
            found["K"] = found["K"] - sign * acting(facets, radius, r2, v, w, y2, m2)[0] / 2e-6
            found["D"] = found["D"] - sign * acting(facets, radius, r, v2, w2, y, m)[0] / 2e-6
        np.testing.assert_allclose(K[:, column], found["K"], atol=1e-8 * np.abs(K).max())
        np.testing.assert_allclose(D[:, column], found["D"], atol=1e-8 * np.abs(D).max())
    force, moment = wrench.reshape(4, 2, 3).transpose(1, 0, 2)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose((np.cross(r, force) + moment).sum(axis=0), 0.0, atol=1e-11 * np.abs(force).max())


def crossing(beam, *, gap=2e-4, law=LAW, **motion):
    """Return two free beams, one across the other and `gap` above it."""
    x = beam.nodes
    low, top = (np.flatnonzero(on) for on in ((x[:, 2] < 1e-9) & (np.abs(x[:, 0] - 0.17) < 0.0301), x[:, 2] > 0.00999))
    lower = fmb.FloatingBody("a", data=beam, skins={"top": fmb.Skin(spacing=0.1, nodes=top, faces=True)})
    upper = fmb.FloatingBody(
        "b",
        data=beam,
        at=(0.2513, -0.1513, HIGH + gap),
        rotation=(0, 0, np.pi / 2),
        skins={"low": fmb.Skin(spacing=0.01, nodes=low)},
        **motion,
    )
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(), lower, upper],
        surfaces=[fmb.SkinSurface("low", skin="b.low"), fmb.SkinSurface("top", skin="a.top")],
        forces=[fmb.SkinContact("touch", surfaces=("low", "top"), law=law)],
        sensors=[fmb.Momentum("P"), fmb.ContactState("state", force="touch")],
    )


def test_tangent_of_two_bodies(beam, rng, monkeypatch):
    """All derivatives by the coordinates of both frames and of all modes, at rest and moving."""
    model = crossing(beam, gap=-2e-4)
    system, state = random_state(model, rng)
    rest, h = np.zeros(system.nu), 1e-6
    q = system.state().q.copy()
    q[7:19], q[26:38] = 1e-5 * rng.standard_normal((2, 12))
    monkeypatch.setattr(test_tangents, "H", h)
    state = state._replace(q=q, a=rest)
    assert_tangent(system, state._replace(u=0.01 * rng.standard_normal(system.nu)), 1e-6, blocks=("D",))
    assert_tangent(system, state._replace(u=rest), 1e-6, blocks=("K",))


@pytest.mark.parametrize("tilt", [5e-3, -5e-3])
def test_least_gap_is_that_of_the_deepest_point(beam, tilt):
    """Of points that are apart or less deep, too, whichever comes first: z of every point over a plane top."""
    turned = Rotation.from_rotvec((tilt, 0, 0)) * Rotation.from_rotvec((0, 0, np.pi / 2))
    model = crossing(beam)
    upper = model.body("b").replaced(at=(0.2513, -0.1513, HIGH - 0.17 * tilt), rotation=turned.as_rotvec())
    model = replace(model, bodies=[model.bodies[0], model.body("a"), upper])
    system = compile_model(model)
    work, state = system.workspace(), system.state()
    evaluate(system.program, state, work)
    gap = new_switching(system, state, work, PassedOver()).now[0]
    names, table = model.force("touch").points(model)
    markers = [work.markers[system.marker_index[name]] for name in names]
    z = np.array([m["r"] + m["R"] @ y for m, y in zip(markers, table[:, :3], strict=True)])
    over = z[(z[:, 1] > 0.0) & (z[:, 1] < B)]
    assert (over[:, 2] > HIGH).any()
    assert gap[0] == GAP
    assert gap[1] == pytest.approx(over[:, 2].min() - HIGH, rel=1e-6)
    assert gap[1] < -5e-5


def test_momentum_and_energy(beam):
    """Two beams strike, rub and part: momenta stay; energy goes into friction and damping alone."""
    model = crossing(beam, gap=1e-5, velocity=(0.3, 0.1, -0.5), angular_velocity=(1, 2, 3))
    run = fmb.simulate(model, 6e-4, integrator=fmb.GeneralizedAlpha(rho_inf=1.0, rtol=1e-5), samples=13)
    assert run["state"][:, 0].max() > 1000.0
    np.testing.assert_allclose(run["P"], np.tile(run["P"][0], (13, 1)), atol=1e-6)
    series = run.series(0)
    energy = series.energy.sum(axis=1)
    assert series.works[-1, 2] > 1e-3
    np.testing.assert_allclose(energy + series.works[:, 2], energy[0], rtol=1e-3)


def test_against_a_rigid_surface(beam):
    """The faces of an undeformed beam press like the cuboid of its size: the same accelerations of both bodies."""
    law = fmb.ElasticFoundation(modulus=2e9, thickness=0.01, damping=0.2)
    model = crossing(beam, gap=-2e-4, law=law, velocity=(0.3, 0.1, -0.5), angular_velocity=(1, 2, 3))
    top = fmb.Surface("top", marker="a.middle", shape=fmb.Cuboid(size=(L, B, HIGH)))
    lower = fmb.RigidBody("a", mass=0.5, inertia=(1e-3,) * 3, markers={"middle": (L / 2, B / 2, HIGH / 2)})
    low = fmb.SkinSurface("low", skin="b.low")
    force = fmb.SurfaceContact("touch", surfaces=("top", "low"), law=law)
    rigid = fmb.Model(
        gravity=(0, 0, 0), bodies=[fmb.Ground(), lower, model.body("b")], surfaces=[low, top], forces=[force]
    )
    found, expected = fmb.accelerations(model), fmb.accelerations(rigid)
    assert np.abs(expected["b"]).max() > 1e4
    np.testing.assert_allclose(found["b"], expected["b"], rtol=1e-9, atol=1e-6)


@pytest.mark.slow
def test_two_cantilevers(rng):
    """A cantilever rests with its tip across the tip of a second one: each carries half of the load, 3 E I w / L^3.

    The crossing rods are round beams; what the layer gives way adds to the upper one.
    """
    r, P = 0.01, 100.0
    steel = fmb.Material(young=2.1e11, poisson=0.3, density=7850.0)
    section = fem.Section.solid_circle(2 * r)

    def rod(name, start, end, **skin):
        return fmb.AncfBeam(
            name,
            points=(start, end),
            elements=6,
            section=section,
            material=steel,
            skins={"end": fmb.Skin(spacing=1.5e-3, radius=r, between=(0.96, 1.0), **skin)},
        )

    upper = rod("upper", (-1.0, 0, 2 * r - 1e-6), (0.02, 0, 2 * r - 1e-6))
    lower = rod("lower", (0, -1.0, 0), (0, 0.02, 0), faces=True)
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(markers={"u": (-1.0, 0, 2 * r - 1e-6), "l": fmb.Pose((0, -1.0, 0), (0, 0, np.pi / 2))}),
            upper,
            lower,
        ],
        joints=[
            fmb.Fixed("left", markers=("ground.u", "upper.start")),
            fmb.Fixed("right", markers=("ground.l", "lower.start")),
        ],
        surfaces=[fmb.SkinSurface("upper", skin="upper.end"), fmb.SkinSurface("lower", skin="lower.end")],
        forces=[
            fmb.SkinContact(
                "touch", surfaces=("upper", "lower"), law=fmb.ElasticFoundation(modulus=1e11, thickness=0.01)
            ),
            fmb.PointLoad("load", marker="upper.end", force=(0, 0, -P)),
        ],
        sensors=[
            fmb.ContactState("state", force="touch"),
            fmb.Position("tip", marker="lower.end"),
            fmb.Position("over", marker="upper.end"),
        ],
    )
    rest = fmb.statics(model)
    EI = 2.1e11 * np.pi * r**4 / 4
    a, b = 1.0, 0.02  # to the crossing, and beyond
    # w_u = P (a^3/3 + a^2 b/2) / EI - F a^3 / (3 EI) is w_l = F a^3 / (3 EI)
    F = 0.5 * P * (1.0 + 1.5 * b / a)
    assert rest["state"][-1, 0] == pytest.approx(F, rel=0.01)
    sink = F * (a**3 / 3 + a**2 * b / 2) / EI
    assert -rest["tip"][-1, 2] == pytest.approx(sink, rel=0.01)


def test_model_file(beam, tmp_path):
    beam.save(tmp_path / "beam.h5")
    model = crossing(fmb.ModalNeutralData.load(tmp_path / "beam.h5"))
    fmb.save_model(model, tmp_path / "m.toml")
    again = fmb.load_model(tmp_path / "m.toml")
    assert again.body("a").skins["top"].faces
    assert again.force("touch").surfaces == ("low", "top")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"surfaces": ("low", "low")}, "two skins of Body 'b'"),
        ({"surfaces": ("top", "low")}, "skin 'low' of Body 'b' has no faces.*faces=True"),
        ({"surfaces": ("low", "roof")}, "roof"),
        ({"surfaces": "low"}, "two SkinSurfaces"),
        ({"law": fmb.Hertz(stiffness=1e9)}, "an ElasticFoundation"),
        ({"law": fmb.Rigid()}, "an ElasticFoundation"),
    ],
)
def test_refused(beam, change, message):
    fields = {"surfaces": ("low", "top"), "law": LAW, **change}
    model = crossing(beam)
    with pytest.raises(fmb.ModelError, match=message):
        fmb.Model(bodies=model.bodies, surfaces=model.surfaces, forces=[fmb.SkinContact("touch", **fields)])


def test_force_of_a_skin_is_refused(beam):
    """It acts on many markers: a sensor of one would show nothing."""
    with pytest.raises(fmb.ModelError, match=r"many markers of a skin.*ContactState"):
        crossing(beam).with_parts(sensors=[fmb.ForceOf("F", force="touch")])


@pytest.mark.parametrize(("gap", "told"), [(-2e-3, True), (-2e-5, False), (1e-4, False)])
def test_skins_that_overlap_at_the_start_are_told(beam, gap, told):
    sentences = " ".join(fmb.check(crossing(beam, gap=gap)).warnings)
    assert ("'low' lies in 'top' by 0.002 m" in sentences) == told


def test_boxes_follow_the_corners(rng):
    """Boxes refitted to corners that have moved find the same nearest face as looking at all of them."""
    grid = np.stack(np.meshgrid(np.arange(9.0), np.arange(9.0), indexing="ij"), axis=2).reshape(-1, 2)
    X = np.column_stack([grid, np.zeros(81)])
    k = np.arange(81).reshape(9, 9)
    a, b, c, d = (s.ravel() for s in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    facets = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    faces, nodes, _ = packed_faces(X, facets)
    data = np.concatenate([faces.ravel(), nodes.ravel()])
    X[:, 2] = np.sin(X[:, 0]) * np.cos(X[:, 1])
    boxes = np.empty((len(nodes), 6))
    corner_boxes(data, 0, faces.size, len(nodes), X, boxes)
    place, other = np.zeros(1, PLACE), np.zeros(1, PLACE)
    for z in rng.uniform((-1, -1, -2), (9, 9, 2), (200, 3)):
        nearest_face(data, 0, faces.size, X, boxes, z, 50.0, place[0])
        least = np.inf
        for n in range(len(faces)):
            one = np.concatenate([faces[n], (1.0, 1.0)])  # a tree of this face alone
            nearest_face(one, 0, FACET, X, np.array([[-99.0] * 3 + [99.0] * 3]), z, 50.0, other[0])
            least = min(least, np.linalg.norm(z - other[0]["p"]))
        assert np.linalg.norm(z - place[0]["p"]) == pytest.approx(least, rel=1e-12)
