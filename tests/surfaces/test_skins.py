"""Skins of deforming bodies: tangents, forces and motions against differences, closed forms and CalculiX."""

import numpy as np
import pytest
from contracts import test_tangents
from contracts.random_models import moved, random_state
from contracts.test_tangents import assert_tangent
from reduction.solids import block

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.forces.relative import relative_motion
from flexmb.forces.surface_contact import PAIR_STRIDE, ROW
from flexmb.surfaces.detection import find_areas
from flexmb.surfaces.records import CONTACT
from flexmb.system import compile
from flexmb.system.program import evaluate

L, B, HIGH = 0.4, 0.04, 0.01
SOFT = fmb.Material(young=1e8, poisson=0.3, density=1000.0)


@pytest.fixture(scope="module")
def beam():
    """A beam of steel whose left end is an interface, with the nodes of its upper side."""
    fe = block((L, B, HIGH), (20, 2, 1))
    x = fe.nodes
    left = np.flatnonzero(x[:, 0] < 1e-9)
    data = reduction.reduce(fe, interfaces={"root": left}, modes=12, stations={"tip": (L, 0, 0)})
    return data, np.flatnonzero(x[:, 2] > HIGH - 1e-9)


def struck(beam, law, *, at=(0.3, B / 3, HIGH + 0.052), skins=None, **ball):
    """Return the beam, free in space, and a ball of 0.2 kg."""
    data, top = beam
    body = fmb.FloatingBody("beam", data=data, skins=skins or {"top": fmb.Skin(spacing=0.02, nodes=top)})
    moving = fmb.RigidBody("ball", mass=0.2, inertia=(2e-4,) * 3, at=at, **ball)
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(), body, moving],
        surfaces=[
            fmb.SkinSurface("top", skin="beam.top"),
            fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(0.05)),
        ],
        forces=[fmb.SurfaceContact("press", surfaces=("top", "ball"), law=law)],
        sensors=[fmb.ForceOf("F", force="press"), fmb.Momentum("P")],
    )


def test_points_of_a_closed_skin(beam):
    """Their areas and normals enclose the volume of the block, and all look outward."""
    data, _ = beam
    body = fmb.FloatingBody("b", data=data, skins={"all": fmb.Skin(spacing=1.0)})
    patches = body.skin_patches["all"]
    at = body.reduced.marker_positions[-len(patches) :]
    area = np.array([p.areas[0] for p in patches])[:, None] * np.array([p.normals[0] for p in patches])
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-15)
    assert np.einsum("ij,ij->", at, area) / 3 == pytest.approx(L * B * HIGH, rel=1e-12)
    assert np.all(np.einsum("ij,ij->i", at - (L / 2, B / 2, HIGH / 2), area) > 0.0)


def test_normals_turn_with_the_modes(beam):
    """Axes of the points of a bent skin against normals of its displaced triangles, to the square of the slope."""
    data, top = beam
    body = fmb.FloatingBody("b", data=data, skins={"top": fmb.Skin(spacing=1.0, nodes=top)})
    patches, r = body.skin_patches["top"], body.reduced
    eta = np.zeros(r.n_modes)
    eta[:3] = 1e-3 * np.abs(r.shapes[:, :, :3]).max(axis=(0, 1)) ** -1
    turned = r.marker_rotations[-len(patches) :] @ eta
    n = np.array([p.normals[0] for p in patches])
    inside = r.marker_positions[-len(patches) :]
    slope = []  # of the deflection, by differences between neighbouring points of the skin
    moved = r.marker_translations[-len(patches) :] @ eta
    for x in inside:
        near = np.argsort(np.linalg.norm(inside - x, axis=1))[:12]
        A = np.column_stack([np.ones(len(near)), inside[near][:, :2] - x[:2]])
        slope.append(np.linalg.lstsq(A, moved[near][:, 2], rcond=None)[0][1])
    found = np.cross(turned, n)[:, 0]
    assert np.abs(found).max() > 5e-3
    np.testing.assert_allclose(found, -np.array(slope), atol=0.05 * np.abs(found).max())


def touching(system, state):
    """Return which points of the skin touch the ball."""
    work = system.workspace()
    evaluate(system.program, state, work)
    data = system.program.bulk
    row = system.program.raw[system.force_rows[0, 1] : system.force_rows[0, 2]].view(ROW)[0]
    motion, Q, found = np.empty(9), np.empty((3, 3)), np.zeros(row["capacity"], CONTACT)
    counts = []
    for k in range(row["count"]):
        at = row["pairs"] + PAIR_STRIDE * k
        a, b, _, at_a, at_b = (int(x) for x in data[at : at + 5])
        relative_motion(work.markers[a], work.markers[b], motion, Q)
        counts.append(find_areas(data, at_a, at_b, 0.0, motion[:3], Q, found))
    return np.array(counts)


def test_tangent(beam, rng, monkeypatch):
    """All derivatives of contact forces by the coordinates of the frames and of the modes."""
    law = fmb.ElasticFoundation(modulus=1e6, thickness=0.01, damping=0.1, friction=0.3, transition=0.1)
    h = 2e-5  # differences over ways that are small beside the distance of the points
    data, top = beam
    near = top[np.abs(data.nodes[top, 0] - 0.3) < 0.0301]
    skins = {"top": fmb.Skin(spacing=0.02, nodes=near)}
    for _ in range(20):
        model = struck(beam, law, at=(0.3, B / 3, HIGH + 0.046), rotation=(0.3, 0.2, 0.1), skins=skins)
        system, state = random_state(model, rng)
        q = system.state().q.copy()
        q[7:19] = 1e-4 * rng.standard_normal(12)
        state = state._replace(q=q)
        there = touching(system, state)
        steps = [x * e for e in np.eye(system.nu) for x in (-4 * h, 4 * h)]
        if there.sum() > 5 and all(np.all(touching(system, moved(system, state, e, 1.0)) == there) for e in steps):
            break
    else:
        raise AssertionError("no smooth state found")
    rest = np.zeros(system.nu)
    assert_tangent(system, state._replace(a=rest), blocks=("D",))
    monkeypatch.setattr(test_tangents, "H", h)
    assert_tangent(system, state._replace(u=rest, a=rest), blocks=("K",))


def test_momentum_and_energy(beam):
    """A ball strikes, rubs on and leaves a free beam: momenta stay, energy goes into friction and damping alone."""
    law = fmb.ElasticFoundation(modulus=2e9, thickness=0.01, friction=0.3, damping=0.2)
    near = beam[1][np.abs(beam[0].nodes[beam[1], 0] - 0.3) < 0.0301]
    skins = {"top": fmb.Skin(spacing=0.02, nodes=near)}
    model = struck(beam, law, skins=skins, velocity=(0.3, 0.1, -0.5), angular_velocity=(1, 20, 3))
    solution = fmb.simulate(model, 0.01, integrator=fmb.GeneralizedAlpha(rho_inf=1.0, rtol=1e-6), samples=51)
    assert solution["F"][:, 2].max() > 100.0
    np.testing.assert_allclose(solution["P"], np.tile(solution["P"][0], (51, 1)), atol=1e-8)
    series = solution.series(0)
    energy = series.energy.sum(axis=1)
    assert series.works[-1, 2] > 0.01
    np.testing.assert_allclose(energy + series.works[:, 2], energy[0], rtol=2e-4)


def test_rigid_contact(beam):
    """The same by impulses: momenta stay to the order of the joints' closing, and energy only falls."""
    model = struck(beam, fmb.Rigid(friction=0.3), velocity=(0.3, 0.1, -0.5))
    solution = fmb.simulate(model, 0.01, integrator=fmb.MoreauJean(step=5e-5), samples=21)
    P, series = solution["P"], solution.series(0)
    assert P[-1, 2] == pytest.approx(-0.1, abs=1e-5)
    assert solution["F"][:, 2].max() > 10.0
    np.testing.assert_allclose(P, np.tile(P[0], (21, 1)), atol=1e-5)
    energy = series.energy.sum(axis=1)
    np.testing.assert_allclose(energy + series.works[:, 2], energy[0], rtol=0.03)


def test_pressed_cantilever(beam):
    """A guided ball presses the beam with 50 N, 0.3 m from its clamp.

    CalculiX 2.22 with the same mesh (C3D10), clamped, and 50 N on the node there: 0.62877 mm at the node, 0.94550 mm at
    the tip. The layer gives way by sqrt(F / (pi K/h R)) more (Johnson, 4.3).
    """
    data, top = beam
    near = top[np.abs(data.nodes[top, 0] - 0.3) < 0.0201]
    body = fmb.FloatingBody("beam", data=data, skins={"top": fmb.Skin(spacing=0.004, nodes=near)})
    R, F = 0.05, 50.0
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(1e-3,) * 3, at=(0.3, B / 2, HIGH + R - 1e-5))
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(markers={"root": (0, B / 2, HIGH / 2), "guide": (0.3, B / 2, 0)}), body, ball],
        joints=[
            fmb.Fixed("clamp", markers=("ground.root", "beam.root")),
            fmb.Prismatic("guide", markers=("ground.guide", "ball.center")),
        ],
        surfaces=[
            fmb.SkinSurface("top", skin="beam.top"),
            fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(R)),
        ],
        forces=[
            fmb.SurfaceContact(
                "press", surfaces=("top", "ball"), law=fmb.ElasticFoundation(modulus=2e8, thickness=0.01)
            ),
            fmb.PointLoad("load", marker="ball.center", force=(0, 0, -F)),
        ],
        sensors=[
            fmb.Position("ball", marker="ball.center"),
            fmb.ForceOf("F", force="press"),
            fmb.Position("tip", marker="beam.tip"),
            fmb.ContactState("state", force="press"),
        ],
    )
    rest = fmb.statics(model)
    layer = (F / (np.pi * 2e10 * R)) ** 0.5
    assert rest["F"][-1, 2] == pytest.approx(F, rel=1e-6)
    assert rest["state"][-1, 0] == pytest.approx(F, rel=1e-3)
    assert HIGH + R - rest["ball"][-1, 2] == pytest.approx(0.62877e-3 + layer, rel=5e-3)
    assert -rest["tip"][-1, 2] == pytest.approx(0.94550e-3, rel=3e-3)


@pytest.mark.slow
def test_cantilever_over_a_drum():
    """A drum fixed to the ground holds the beam up at a = 0.3 m, and its tip is pushed down: a propped cantilever.

    By Euler-Bernoulli F a^2 (3 L - a) / (6 EI) = R a^3 / (3 EI) + d with the depth d of the layer, whatever the span
    between: without d the drum carries 1.5 F. The tip is an interface, so that its load has a static shape.
    """
    a, radius, F = 0.3, 0.05, 20.0
    fe = block((L, B, HIGH), (20, 2, 1))
    x = fe.nodes
    ends = {"root": np.flatnonzero(x[:, 0] < 1e-9), "tip": np.flatnonzero(x[:, 0] > L - 1e-9)}
    data = reduction.reduce(fe, interfaces=ends, modes=12)
    below = np.flatnonzero((x[:, 2] < 1e-9) & (np.abs(x[:, 0] - a) < 0.0201))
    drum = fmb.Pose.axes((a, B / 2, -radius), x=(1, 0, 0), z=(0, 1, 0))
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(markers={"root": (0, B / 2, HIGH / 2), "drum": drum}),
            fmb.FloatingBody("beam", data=data, skins={"below": fmb.Skin(spacing=2e-3, nodes=below)}),
        ],
        joints=[fmb.Fixed("clamp", markers=("ground.root", "beam.root"))],
        surfaces=[
            fmb.SkinSurface("below", skin="beam.below"),
            fmb.Surface("drum", marker="ground.drum", shape=fmb.Cylinder(radius=radius, length=2 * B)),
        ],
        forces=[
            fmb.SurfaceContact(
                "rest", surfaces=("drum", "below"), law=fmb.ElasticFoundation(modulus=1e10, thickness=0.01)
            ),
            fmb.PointLoad("push", marker="beam.tip", force=(0, 0, -F)),
        ],
        sensors=[fmb.ContactState("state", force="rest"), fmb.Reaction("clamp", joint="clamp")],
    )
    rest = fmb.statics(model)
    R, _, _, depth, *_ = rest["state"][-1]
    sinks = F * a**2 * (3.0 * L - a) / (6.0 * 210e9 * B * HIGH**3 / 12.0)
    assert depth < 0.01 * sinks
    assert R == pytest.approx(F * (3.0 * L - a) / (2.0 * a) * (1.0 - depth / sinks), rel=5e-3)
    assert np.abs(rest["clamp"][-1, 2]) == pytest.approx(R - F, abs=5e-3 * F)


def test_cable_on_the_ground():
    """A cable comes to rest on a plane, which carries its weight."""
    r = 0.01
    law = fmb.ElasticFoundation(modulus=1e5, thickness=0.01, damping=2.0)
    cable = fmb.AncfCable(
        "cable",
        points=((0, 0, r), (1, 0, r)),
        elements=6,
        section=fem.Section.solid_circle(2 * r),
        material=SOFT,
        skins={"all": fmb.Skin(spacing=0.05, radius=r)},
    )
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"floor": (0, 0, 0)}), cable],
        surfaces=[
            fmb.SkinSurface("cable", skin="cable.all"),
            fmb.Surface("floor", marker="ground.floor", shape=fmb.Plane()),
        ],
        forces=[fmb.SurfaceContact("lies", surfaces=("cable", "floor"), law=law)],
        sensors=[fmb.ForceOf("F", force="lies"), fmb.Position("end", marker="cable.end")],
    )
    assert len(cable.skin_patches["all"]) == 20
    assert sum(p.areas.sum() for p in cable.skin_patches["all"]) == pytest.approx(2 * np.pi * r, rel=1e-12)
    solution = fmb.simulate(model, 2.0, integrator=fmb.GeneralizedAlpha(rho_inf=0.3, rtol=1e-4), samples=4)
    weight = 9.81 * cable.mass
    assert solution["F"][-1, 2] == pytest.approx(-weight, rel=1e-3)


def test_sheet_on_a_ball():
    """A sheet that lies on a ball carries its weight there, and its edges hang lower than where it touches."""
    sheet = fmb.AncfPlate.rectangle(
        "sheet",
        edges=(0.2, 0.2),
        corner=(-0.1, -0.1, 0.0),
        elements=(4, 4),
        thickness=0.004,
        material=SOFT,
        damping=2e-2,
        markers={"mid": (0.5, 0.5)},
        skins={"all": fmb.Skin(spacing=0.01)},
    )
    patches = sheet.skin_patches["all"]
    assert sum(p.areas.sum() for p in patches) == pytest.approx(2 * 0.04, rel=1e-9)
    law = fmb.ElasticFoundation(modulus=1e6, thickness=0.01, damping=3.0, friction=0.5)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"o": (0, 0, -0.102)}), sheet],
        surfaces=[
            fmb.SkinSurface("sheet", skin="sheet.all"),
            fmb.Surface("ball", marker="ground.o", shape=fmb.Sphere(0.1)),
        ],
        forces=[fmb.SurfaceContact("lies", surfaces=("sheet", "ball"), law=law)],
        sensors=[
            fmb.ForceOf("F", force="lies"),
            fmb.Position("corner", marker="sheet.corner_00"),
            fmb.Position("mid", marker="sheet.mid"),
        ],
    )
    solution = fmb.simulate(model, 0.4, integrator=fmb.GeneralizedAlpha(rho_inf=0.5), samples=5)
    assert solution["F"][-1, 2] == pytest.approx(-9.81 * sheet.mass, rel=1e-4)
    assert solution["corner"][-1, 2] < solution["mid"][-1, 2] - 1e-3


def test_model_file(beam, tmp_path):
    """Skins and their surfaces stand in model files."""
    data, top = beam
    data.save(tmp_path / "beam.h5")
    model = struck((fmb.ModalNeutralData.load(tmp_path / "beam.h5"), top[:0].tolist()), LAW, skins=WHOLE)
    fmb.save_model(model, tmp_path / "m.toml")
    again = fmb.load_model(tmp_path / "m.toml")
    assert again.surface("top").skin == "beam.top"
    assert again.body("beam").skins["top"].spacing == 0.05
    assert len(again.body("beam").skin_patches["top"]) == len(model.body("beam").skin_patches["top"]) > 100


LAW = fmb.ElasticFoundation(modulus=1e6, thickness=0.01)
WHOLE = {"top": fmb.Skin(spacing=0.05)}


@pytest.mark.parametrize(
    ("skins", "law", "message"),
    [
        ({"top": fmb.Skin(spacing=1e-5)}, LAW, "points.*larger spacing"),
        ({"top": fmb.Skin(spacing=0.1, nodes="roof")}, LAW, "roof.*no set"),
        ({"top": fmb.Skin(spacing=0.1, nodes=[0, 1])}, LAW, "no facet of the free surface"),
        ({"top": fmb.Skin(spacing=0.1, radius=0.1)}, LAW, "have no shells"),
        ({"top": fmb.Skin(spacing=0.1, between=(0.0, 0.5))}, LAW, r"between = \(0.0, 0.5\).*no between"),
        ({"side": fmb.Skin(spacing=0.1)}, LAW, "no skin 'top'.*side"),
        ({"top": 0.1}, LAW, "expected: a Skin|Expected: a Skin"),
        (WHOLE, fmb.Hertz(stiffness=1e6), "a Sphere.*and a Surface"),
    ],
)
def test_refused(beam, skins, law, message):
    with pytest.raises(fmb.ModelError, match=message):
        struck(beam, law, skins=skins)


def test_two_skins_are_refused(beam):
    data, _ = beam
    bodies = [
        fmb.FloatingBody(name, data=data, at=at, skins=WHOLE) for name, at in (("a", (0, 0, 0)), ("b", (0, 0, 1)))
    ]
    with pytest.raises(fmb.ModelError, match="both points of skins"):
        fmb.Model(
            bodies=[fmb.Ground(), *bodies],
            surfaces=[fmb.SkinSurface("one", skin="a.top"), fmb.SkinSurface("two", skin="b.top")],
            forces=[fmb.SurfaceContact("touch", surfaces=("one", "two"), law=LAW)],
        )


def test_bad_skins():
    for fields in ({"spacing": 0.0}, {"spacing": 0.1, "radius": -1.0}, {"spacing": 0.1, "between": (0.5, 0.5)}):
        with pytest.raises(fmb.ModelError, match="Skin"):
            fmb.Skin(**fields)


def test_compiles_with_a_marker_for_every_point(beam):
    model = struck(beam, LAW)
    system = compile(model)
    assert len(model.body("beam").skin_patches["top"]) == 320
    assert "beam.top[319]" in system.marker_index
