"""Elastic flaps and tracks of the high-lift example: the outcomes 5.16, 5.17, 5.18 and 5.20, and frequencies by hand.

Reference: statics of the full finite elements, Craig & Bampton 1968, and Euler-Bernoulli beams in closed form.
"""

import itertools
from functools import cache

import highlift_bodies
import numpy as np
import pytest
from by_turns import slow
from highlift_runs import DATA, FOLDER
from scipy.linalg import eigh
from tolerances import MACHINE

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError
from flexmb.reduction.basis import normal_modes
from flexmb.reduction.interfaces import resolve
from flexmb.reduction.statics import HeldBody

FLAP = DATA["trailing_edge"]["inboard_flap"]
CHORDS = np.interp(FLAP["nose_points_y"], FLAP["y_range"], FLAP["chord"])
STRIP = np.ptp(FLAP["y_range"]) / 7


@cache
def flap():
    """The finite elements of the inboard flap."""
    wing = DATA["trailing_edge"]
    ribs = {
        "root": wing["track_1"]["y"],
        "tip": wing["track_2"]["y"],
        "rib": wing["interconnection_strut"]["y_inboard"],
    }
    return highlift_bodies.flap_model(FLAP, *FLAP["y_range"], ribs, FLAP["nose_points_y"], "inboard_flap")


def node(fe, name) -> int:
    return int(fe.node_sets[name][0])


def nodal(fe, table):
    """Return the forces on the freedoms of {node: six components}."""
    return reduction.NodalForces(table).forces(fe, "test")


@pytest.mark.parametrize("eta", [0, 5, 10])
def test_outcome_5_16(eta):
    """Nose force plus correction moment is the load at the centre of pressure: in every freedom of the elements, so in
    resultant, moment and all modal loads."""
    coefficients = [DATA["airloads"]["inboard"][key][eta] for key in ("CN", "CC", "XCP")]
    CN, CC, XCP = coefficients
    real, fe = flap(), flap()
    for k, (y, c) in enumerate(zip(FLAP["nose_points_y"], CHORDS), 1):
        rib = int(np.argmin(np.linalg.norm(real.nodes - (0.33 * c, y, 0.0), axis=1)))
        real = fem.with_rigid_link(fem.with_node(real, (XCP * c, y, 0.0), name=f"pressure_{k}"), rib, f"pressure_{k}")
    strips = STRIP * CHORDS
    loads = {node(real, f"pressure_{k}"): (CC * s, 0, CN * s) for k, s in enumerate(strips, 1)}
    noses = {
        node(fe, f"nose_{k}"): (CC * s, 0, CN * s, 0, -CN * s * XCP * c, 0)
        for k, (s, c) in enumerate(zip(strips, CHORDS), 1)
    }
    one, two = nodal(real, loads), nodal(fe, noses)
    assert np.abs(one - two).max() < 1e2 * MACHINE * np.abs(two).max()
    resultant = fe.rigid_motions().T @ two
    area = np.sum(strips)
    np.testing.assert_allclose(resultant[:3], [CC * area, 0, CN * area], rtol=1e-9, atol=1e-9)
    assert resultant[4] == pytest.approx(-CN * XCP * np.sum(strips * CHORDS), rel=1e-9)
    data = reduction.reduce(fe, {"tip": [node(fe, "tip")]}, modes=4, loads={"nose": reduction.NodalForces(noses)})
    np.testing.assert_allclose(data.load_shapes[0][:6], resultant, rtol=1e-9, atol=1e-9)


def held_coordinates(data, interfaces, load) -> np.ndarray:
    """Return rigid motion and modal coordinates (6 + m,) under a load, the named interfaces held in all directions."""
    m, rows = data.n_modes, []
    for name in interfaces:
        k = data.marker_names.index(name)
        x, y, z = data.marker_positions[k]
        arm = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        rows.append(np.hstack([np.eye(3), arm, data.marker_translations[k]]))
        rows.append(np.hstack([np.zeros((3, 3)), np.eye(3), data.marker_rotations[k]]))
    G = np.vstack(rows)
    K = np.zeros((6 + m, 6 + m))
    K[6:, 6:] = data.stiffness
    matrix = np.block([[K, G.T], [G, np.zeros((len(G), len(G)))]])
    return np.linalg.solve(matrix, np.concatenate([load, np.zeros(len(G))]))[: 6 + m]


def held_deflection(data, interfaces, load) -> np.ndarray:
    """Return the translations of all nodes under a load shape, the named interfaces held in all directions."""
    u = held_coordinates(data, interfaces, load)
    moved = data.shapes @ u[6:] if data.shapes.ndim == 3 else data.shapes
    return moved + u[:3] + np.cross(u[3:6], data.nodes)


def full_deflection(fe, interfaces, force) -> np.ndarray:
    """Return the same from the full model."""
    fixed = [node(fe, name) for name in interfaces]
    return fe.field(fem.static(fe, force, fixed)[:, None])[:, :3, 0]


def test_outcome_5_17():
    """The response to the distributed load gains with every normal mode; constraint modes alone give that to forces at
    interfaces, and a residual vector that to the load, exactly."""
    fe, held = flap(), ("root", "tip", "rib")
    interfaces = {name: [node(fe, name)] for name in held}
    air = {
        node(fe, f"nose_{k}"): (0, 0, s, 0, -0.4 * s * c, 0) for k, (s, c) in enumerate(zip(STRIP * CHORDS, CHORDS), 1)
    }
    shape = {"air": reduction.NodalForces(air)}
    exact = full_deflection(fe, held, nodal(fe, air))
    errors = []
    for modes in (0, 2, 4, 8, 16):
        data = reduction.reduce(fe, interfaces, modes=modes, loads=shape, compare=0)
        errors.append(np.abs(held_deflection(data, held, data.load_shapes[0]) - exact).max() / np.abs(exact).max())
    assert errors[0] == pytest.approx(1.0, abs=0.05)
    assert all(later < sooner for sooner, later in itertools.pairwise(errors))
    assert errors[-1] < 0.05
    data = reduction.reduce(fe, interfaces, modes=2, loads=shape, residual_vectors=("air",), compare=0)
    assert np.abs(held_deflection(data, held, data.load_shapes[0]) - exact).max() < 1e-7 * np.abs(exact).max()
    push = {node(fe, "rib"): (1e3, 0, 5e3, 0, 2e3, 0)}
    data = reduction.reduce(fe, interfaces, modes=0, loads={"push": reduction.NodalForces(push)}, compare=0)
    exact = full_deflection(fe, ("root",), nodal(fe, push))
    assert np.abs(held_deflection(data, ("root",), data.load_shapes[0]) - exact).max() < 1e-7 * np.abs(exact).max()


def outboard_flap():
    """The finite elements of the outboard flap, and what holds it."""
    wing, data = DATA["trailing_edge"], DATA["trailing_edge"]["outboard_flap"]
    tracks = dict(zip(("root", "mid", "tip"), (track["Y"] for track in wing["outboard_tracks"])))
    ribs = {"rib": wing["interconnection_strut"]["outboard_attachment_Y"], **tracks}
    return highlift_bodies.flap_model(data, 0.0, data["span"], ribs, data["nose_points_Y"], "outboard_flap"), ribs


BODIES = {
    "inboard_flap": lambda: (flap(), ("root", "tip", "rib")),
    "outboard_flap": outboard_flap,
    "track_2": lambda: (bare_track("track_2"), ("front", "rear", "actuator", "foot")),
    "track_outboard": lambda: (bare_track("track_outboard"), ("front", "rear", "actuator", "foot")),
    "droop_nose": lambda: (highlift_bodies.droop_nose_model(DATA), ("n1", "n2", "n3", "n4", "n5", "side")),
}
"""Finite elements and interfaces of the elastic bodies."""


def bare_track(name):
    return highlift_bodies.track_model(*highlift_bodies.track_arguments(DATA)[name])


@pytest.mark.parametrize("name", BODIES)
def test_outcome_5_18(name):
    """Stiffness in constraint and normal modes is block diagonal; the free body has six zero frequencies."""
    fe, held = BODIES[name]()
    body = HeldBody(fe, resolve(fe, {interface: [node(fe, interface)] for interface in held}))
    modes = normal_modes(body, 12)
    basis = np.hstack([body.constraint_modes, modes.vectors])
    K, M = basis.T @ (fe.K @ basis), basis.T @ (fe.M @ basis)
    q = body.constraint_modes.shape[1]
    scale = np.sqrt(np.abs(np.outer(np.diag(K)[:q], np.diag(K)[q:])))
    assert np.abs(K[:q, q:] / scale).max() < 1e-8
    np.testing.assert_allclose(K[q:, q:], np.diag(modes.w2), atol=1e-7 * modes.w2.max())
    w2 = eigh(0.5 * (K + K.T), 0.5 * (M + M.T), eigvals_only=True)
    assert np.abs(w2[:6]).max() < 1e-6 * w2[6]
    if name == "inboard_flap":
        data = highlift_bodies.inboard_flap(DATA)
        assert np.sqrt(w2[6]) / (2 * np.pi) == pytest.approx(data.frequencies[0], rel=1e-2)


def test_outcome_5_20():
    """A load through the shear centre does not twist the flap;
    at the area centre it does, by its moment over G J / L.
    """
    fe = flap()
    root, end = int(np.argmin(fe.nodes[:, 1])), int(np.flatnonzero(fe.nodes[:, 1] == FLAP["y_range"][1])[0])
    axis = fe.nodes[end] - fe.nodes[root]
    length = np.linalg.norm(axis)
    axis /= length
    centre = int(np.argmin(np.linalg.norm(fe.nodes - (0.42 * FLAP["chord"][1], FLAP["y_range"][1], 0.0), axis=1)))
    twists = []
    for place in (end, centre):
        u = fem.static(fe, nodal(fe, {place: (0, 0, 1e3)}), [root])
        twists.append(fe.field(u[:, None])[end, 3:, 0] @ axis)
    arm = np.linalg.norm(np.cross(axis, fe.nodes[centre] - fe.nodes[end]))
    assert abs(twists[0]) < 1e-9 * abs(twists[1])
    assert abs(twists[1]) == pytest.approx(1e3 * arm * length / FLAP["GJ"], rel=1e-3)


@pytest.mark.parametrize("side", ["inboard", "outboard"])
def test_outcome_5_20_of_the_reduced_flap(side):
    """The same of the bodies of the elastic model: held at the inner fitting, the outer one pushed through the shear
    centres does not turn about their line; a couple about it turns it by couple times length over G J."""
    data = fmb.load_model(FOLDER / f"{side}_flap_beam.toml").body("beam").data
    places = [data.marker_positions[data.marker_names.index(name)] for name in ("root", "tip")]
    length = np.linalg.norm(places[1] - places[0])
    axis = (places[1] - places[0]) / length
    k = data.marker_names.index("tip")
    m, x = data.n_modes, places[1]
    turn = np.vstack([np.zeros((3, 3)), np.eye(3), data.marker_rotations[k].T]).T
    arm = np.array([[0, x[2], -x[1]], [-x[2], 0, x[0]], [x[1], -x[0], 0]])
    move = np.hstack([np.eye(3), arm, data.marker_translations[k]])
    twists = []
    for load in (move.T @ (0, 0, 1e3), turn.T @ (1e3 * axis)):
        twists.append(axis @ turn @ held_coordinates(data, ("root",), load)[: 6 + m])
    GJ = DATA["trailing_edge"][f"{side}_flap"]["GJ"]
    assert abs(twists[0]) < 1e-9 * abs(twists[1])
    assert twists[1] == pytest.approx(1e3 * length / GJ, rel=1e-3)


def test_frequencies_by_hand():
    """Free flaps against the uniform beams of the data set, which leave out taper, and the offset of the mass from the
    shear centre: that couples bending and torsion, within 8 %."""
    for name, made in (
        ("inboard_flap", highlift_bodies.inboard_flap(DATA)),
        ("outboard_flap", highlift_bodies.outboard_flap(DATA)),
    ):
        expected = DATA["trailing_edge"][name]["expected_frequencies_hz"]
        for key in ("free_bending_1", "free_torsion_1"):
            assert np.min(np.abs(made.frequencies / expected[key] - 1.0)) < 0.08
        assert made.mass + len(made.marker_names[: made.n_interfaces]) * highlift_bodies.FITTING == pytest.approx(
            DATA["trailing_edge"][name]["mass"], rel=1e-2
        )


@pytest.mark.parametrize("yielding", [0.0, 1.0])
def test_track_beam_on_the_wing(yielding):
    """First vertical frequency with 150 kg at the pendulum foot and 60 kg at the carriage.

    The beam with an overhang a behind the span b gives way by a^2 (a + b)/3EI, its shear by (a + a^2/b)/GA, its
    attachments by (1 + a/b)^2/k and (a/b)^2/k. The 58 Hz of the data set leave out shear and attachments. Its own mass
    counts by the square of the deflection, of which a/(a + b) is that of a clamped beam, c = 1.5 x^2 - 0.5 x^3, and
    the rest a rotation: the integrals of c^2, c x and x^2 are 33/140, 11/40 and 1/3.
    """
    arguments = highlift_bodies.track_arguments(DATA)["track_2"]
    fe, beam = highlift_bodies.track_model(*arguments), DATA["trailing_edge"]["track_beams"]
    k = beam["attachment_stiffness"] if yielding else 1e13
    fe = fem.with_mass(fem.with_mass(fe, node(fe, "foot"), 150.0), node(fe, "carriage 0"), 60.0)
    fe = fem.with_spring(fe, node(fe, "front"), (k, k, k, 7e5, 0, 0))
    fe = fem.with_spring(fe, node(fe, "rear"), (0, k, k, 0, 0, 0))
    modes = fem.eigenmodes(fe, n=6)
    foot = np.abs(fe.field(modes.shapes)[node(fe, "foot")])
    found = modes.frequencies[foot[2] > foot[1]][0]
    titanium = DATA["materials"]["titanium_6al4v"]
    section = fem.Section.box(*(beam["section"][key] for key in ("width", "height", "wall")))
    front, rear = beam["wing_attachments_s"]
    a, b = beam["interfaces_s"]["pendulum_foot"] - rear, rear - front
    bending = a**2 * (a + b) / (3.0 * titanium["E"] * section.inertia_y)
    shear = (a + a**2 / b) * 2.0 * (1.0 + titanium["nu"]) / (titanium["E"] * section.area * section.shear_z)
    attachment = ((1.0 + a / b) ** 2 + (a / b) ** 2) / k
    bent = a / (a + b)
    own = bent**2 * 33 / 140 + 2 * bent * (1 - bent) * 11 / 40 + (1 - bent) ** 2 / 3
    mass = 150.0 + own * beam["mass_per_length"] * a
    by_hand = 1.0 / np.sqrt(mass * (bending + shear + attachment)) / (2.0 * np.pi)
    assert found == pytest.approx(by_hand, rel=0.02)
    if not yielding:
        assert found == pytest.approx(beam["expected_frequency_hz"], rel=0.08)


def test_load_shapes_are_the_loads_at_the_nose_points():
    """The load shapes of the reduced flap, and point loads on its nose markers, as the model files apply them."""
    data = highlift_bodies.inboard_flap(DATA)
    sizes = {"normal": (2, STRIP * CHORDS), "chord": (0, STRIP * CHORDS), "moment": (4, STRIP * CHORDS**2)}
    motion = np.concatenate([data.marker_translations, data.marker_rotations], axis=1)
    for name, (direction, amounts) in sizes.items():
        noses = [data.marker_names.index(f"nose_{k}") for k in range(1, 8)]
        modal = sum(amount * motion[nose, direction] for nose, amount in zip(noses, amounts))
        shape = data.load_shapes[data.load_names.index(name)]
        np.testing.assert_allclose(shape[6:], modal, atol=1e-9 * np.abs(modal).max())


@pytest.mark.parametrize(
    ("file", "body", "by_hand", "tolerance"),
    [
        ("inboard_flap_beam", "beam", lambda: highlift_bodies.inboard_flap(DATA), 1e-10),
        ("outboard_flap_beam", "beam", lambda: highlift_bodies.outboard_flap(DATA), 1e-10),
        ("trailing_edge", "inboard_t2_track", lambda: track("track_2"), 1e-8),
        ("trailing_edge", "outboard_t4_track", lambda: track("track_outboard"), 1e-8),
        ("droop_nose", "s2_arm", lambda: highlift_bodies.hinge_arm(DATA), 1e-10),
        ("slats", "s1_beam", lambda: highlift_bodies.slat(DATA, 1), 1e-10),
        ("slats", "s6_beam", lambda: highlift_bodies.slat(DATA, 6), 1e-10),
        # equal bays between the arms of the nose: pairs of modes of nearly one frequency, either of which may be taken
        ("droop_nose", "nose_beam", lambda: highlift_bodies.droop_nose(DATA), 1e-2),
    ],
)
def test_the_model_files_describe_the_same_bodies(file, body, by_hand, tolerance):
    """Mass, frequencies, markers and load shapes of the description are those of the functions called by hand."""
    given = {"rigid": False} if "beam" not in file else {}
    data, expected = fmb.load_model(FOLDER / f"{file}.toml", given).body(body).data, by_hand()
    assert data.mass == pytest.approx(expected.mass, rel=1e-12)
    assert data.marker_names == expected.marker_names
    assert data.load_names == expected.load_names
    np.testing.assert_allclose(data.marker_positions, expected.marker_positions, atol=1e-9)
    np.testing.assert_allclose(data.load_shapes[:, :6], expected.load_shapes[:, :6], atol=1e-12)
    # of modes of nearly one frequency either may be taken: in the upper half they follow rounding, by processors
    count = len(expected.frequencies) if tolerance < 1e-6 else len(expected.frequencies) // 2
    assert len(data.frequencies) == len(expected.frequencies)
    np.testing.assert_allclose(data.frequencies[:count], expected.frequencies[:count], rtol=tolerance)
    np.testing.assert_allclose(data.frequencies[:6], expected.frequencies[:6], rtol=min(tolerance, 1e-3))


def track(name):
    return highlift_bodies.track_beam(*highlift_bodies.track_arguments(DATA)[name])


@pytest.mark.parametrize(("name", "low"), [("inboard_flap_GJ", 1.5e5), slow("inboard_flap_EI_flapwise", 3.4e5)])
def test_stiffness_of_the_flap_reaches_the_struts(name, low):
    """A tenth of the torsional or bending stiffness of the elastic flap: other forces in the drive struts.

    They were equal to the last digit, because bodies came from files that knew nothing of the parameters.
    """
    start = {"rigid": False, "load_factor": 2.0}
    forces = [
        fmb.statics(fmb.load_model(FOLDER / "operation.toml", {**start, **given}))["inboard_t1_strut force"][-1, 0]
        for given in ({}, {name: low})
    ]
    assert abs(forces[1] / forces[0] - 1.0) > 1e-3


def test_a_track_takes_the_interface_of_the_flap_along():
    """Track 2 at y = 8.0 m instead of 6.85 m: fitting and interface of the elastic flap are there, nothing is open."""
    model = fmb.load_model(FOLDER / "trailing_edge.toml", {"rigid": False, "track_2_y": 8.0})
    data = model.body("inboard_flap_beam").data
    tip = data.marker_positions[data.marker_names.index("tip")]
    assert tip[1] == pytest.approx(8.0, abs=1e-12)
    assert fmb.check(model).assembly_error < 1e-4


def test_a_flap_of_other_parameters_is_refused(tmp_path):
    """The flap in a file, as it was: it says what it was made with, and does not fit another place of the track."""
    for file in FOLDER.glob("*.toml"):
        (tmp_path / file.name).write_text(file.read_text())
    path = tmp_path / "inboard_flap_beam.toml"
    data = fmb.load_model(path).body("beam").data
    data.save(tmp_path / "inboard_flap.h5")
    text = path.read_text()
    table = text[text.index("[body.data]") : text.index('[[body]]\nkind = "RigidBody"\nname = "root"')]
    path.write_text(text.replace(table, "").replace('name = "beam"\n', 'name = "beam"\ndata = "inboard_flap.h5"\n', 1))
    case = tmp_path / "operation.toml"
    assert fmb.load_model(case, {"rigid": False})
    for name, value in (("track_2_y", 8.0), ("inboard_flap_GJ", 1e3), ("inboard_flap_EI_flapwise", 1e3)):
        with pytest.raises(ModelError, match=f"'inboard_flap.h5' was made with {name} = "):
            fmb.load_model(case, {"rigid": False, name: value})
