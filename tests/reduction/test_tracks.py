"""Loads that move over a body: Inglis' beam under a travelling force (A Mathematical Treatise on Vibrations in Railway
Bridges, 1934; Frýba, Vibration of Solids and Structures under Moving Loads, 1999, chapter 1)."""

import numpy as np
import pytest
from scipy.linalg import null_space

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError, ReductionError

LENGTH, SIDE, FORCE, SPEED = 4.0, 0.05, 200.0, 12.0
STEEL = fmb.MATERIALS["steel"]
NODES = 33


@pytest.fixture(scope="module")
def fe():
    points = np.column_stack([np.linspace(0.0, LENGTH, NODES), np.zeros(NODES), np.zeros(NODES)])
    section = fem.Section.rectangle(SIDE, SIDE)
    return fem.frame(points, section=section, material=STEEL, shear=False, rotary_inertia=False, name="bridge")


def inglis(t, x):
    """Deflection of a simply supported beam without damping under a force that came onto it at t = 0."""
    EI, rhoA = STEEL.young * SIDE**4 / 12, STEEL.density * SIDE**2
    n = np.arange(1, 200)[:, None]
    w = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / rhoA)
    drive = n * np.pi * SPEED / LENGTH
    share = 2.0 * FORCE / (rhoA * LENGTH * (w**2 - drive**2))
    return np.sum(share * (np.sin(drive * t) - drive / w * np.sin(w * t)) * np.sin(n * np.pi * x / LENGTH), axis=0)


def crossed(fe, rest, modes=0, basis="CraigBampton"):
    """Deflection at midspan while the force crosses, of a body with and without shapes for the track."""
    data = reduction.reduce(
        fe,
        {"a": [0], "b": [NODES - 1]},
        modes,
        basis=basis,
        stations={"mid": [NODES // 2]},
        loads={"rail": reduction.Track(range_of(fe), (0, 0, -1), rest=rest)},
        compare=0,
    )
    load = fmb.moving_load("roller", "beam.rail", FORCE, data=data, along=fmb.ramp(rate=SPEED))
    model = fmb.Model(
        name="bridge",
        bodies=[
            fmb.Ground(markers={"A": fmb.Pose.axes(z=(0, 1, 0)), "B": (LENGTH, 0, 0)}),
            fmb.FloatingBody("beam", data=data, markers={"a": fmb.Pose.axes(z=(0, 1, 0))}),
        ],
        joints=[
            fmb.Revolute("left", markers=("ground.A", "beam.a")),
            fmb.PointOnPlane("right", markers=("ground.B", "beam.b")),
        ],
        forces=load,
        sensors=[fmb.Position("mid", marker="beam.mid")],
    )
    solution = fmb.simulate(model, LENGTH / SPEED, samples=101)
    return data, -np.asarray(solution["mid"])[:, 2]


def range_of(fe):
    return list(range(len(fe.nodes)))


def test_a_travelling_force_bends_a_bridge_as_inglis_says(fe):
    """Without shapes for the track the error is a third; with them and no normal mode at all below a percent."""
    t = np.linspace(0.0, LENGTH / SPEED, 101)
    exact = inglis(t, LENGTH / 2)
    errors, shapes = {}, {}
    for rest in (1.0, 1e-3):
        data, found = crossed(fe, rest)
        errors[rest] = np.abs(found - exact).max() / np.abs(exact).max()
        shapes[rest] = data.quality["tracks"]["rail"]["shapes"]
    assert errors[1.0] > 0.3
    assert errors[1e-3] < 0.01
    assert shapes[1.0] == 0
    assert shapes[1e-3] < 12


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin"])
def test_statics_under_a_load_on_the_track_are_met(fe, basis):
    """Compliance of each node against the static solution of all freedoms, ends held by the interfaces."""
    without, data = (
        reduction.reduce(
            fe,
            {"a": [0], "b": [NODES - 1]},
            0,
            basis=basis,
            loads={"rail": reduction.Track(range_of(fe)[1:-1], (0, 0, -1), rest=rest)},
            frame="a",
            compare=0,
        )
        for rest in (1.0, 1e-3)
    )
    K = fe.K.toarray()[6:, 6:]
    z = [i for i in np.flatnonzero(fe.dofs[6:, 1] == 2) if i < len(K) - 6]
    exact = np.linalg.inv(K)[z, z]
    errors = []
    for body in (without, data):
        own = np.einsum("lm,m,lm->l", body.load_shapes[:, 6:], 1.0 / np.diag(body.stiffness), body.load_shapes[:, 6:])
        errors.append(np.abs(own / exact - 1.0).mean())
    assert errors[1] < 0.02
    assert errors[0] > 5.0 * errors[1]


@pytest.mark.parametrize(
    ("basis", "modes"), [("CraigBampton", 4), ("Rubin", 4), ("Krylov", "usual"), ("CharacteristicModes", 4)]
)
@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_the_report_says_what_is_missing_with_and_without_the_shapes_of_a_track(fe, basis, modes, frame):
    """Largest missing deflection over the largest one, against the matrices of the beam with held ends: from the data
    of a body with the shapes, and of one without."""
    K = fe.K.toarray()[6:-6, 6:-6]
    own = np.diag(np.linalg.inv(K))[fe.dofs[6:-6, 1] == 2]
    exact, missing = np.concatenate([[0.0], own, [0.0]]), []
    for rest in (1e-3, 1.0):
        loads = {"rail": reduction.Track(range_of(fe), (0, 0, -1), rest=rest)}
        given = {"basis": basis, "loads": loads, "compare": 0, "frame": frame}
        data = reduction.reduce(fe, {"a": [0], "b": [NODES - 1]}, modes, **given)
        rows = []
        for k, x in enumerate(data.marker_positions[:, 0]):
            lever = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, x], [0.0, -x, 0.0]])
            rigid = np.block([[np.eye(3), lever], [np.zeros((3, 3)), np.eye(3)]])
            rows.append(np.hstack([rigid, np.vstack([data.marker_translations[k], data.marker_rotations[k]])]))
        held = null_space(np.vstack(rows), rcond=1e-9)
        stiffness = held[6:].T @ data.stiffness @ held[6:]
        share = data.load_shapes @ held
        found = np.einsum("lm,ml->l", share, np.linalg.solve(stiffness, share.T))
        missing.append((exact - found).max() / exact.max())
    with_shapes = reduction.reduce(
        fe,
        {"a": [0], "b": [NODES - 1]},
        modes,
        basis=basis,
        loads={"rail": reduction.Track(range_of(fe), (0, 0, -1))},
        compare=0,
        frame=frame,
    )
    told = with_shapes.quality["tracks"]["rail"]
    assert told["missing"] == pytest.approx(missing[0], rel=1e-5)
    assert told["missing_before"] == pytest.approx(missing[1], rel=1e-5)
    assert told["missing"] < 1e-3 < 0.01 < told["missing_before"]
    line = next(line for line in with_shapes.report().splitlines() if line.startswith("  rail "))
    assert "33 nodes, 4 m, (0, 0, 0) to (4, 0, 0)" in line
    assert f"{100 * missing[0]:.3g} % missing; without them {100 * missing[1]:.3g} %" in line


def test_a_body_that_is_too_stiff_under_a_load_that_moves_says_so(fe):
    loads = {"rail": reduction.Track(range_of(fe), (0, 0, -1), rest=1.0)}
    data = reduction.reduce(fe, {"a": [0], "b": [NODES - 1]}, 0, loads=loads, compare=0)
    assert "'rail' the body is too stiff: up to 100 % of the largest deflection" in data.quality["warnings"][-1]


def test_a_track_is_ordered_and_follows_units(fe):
    named = {"rail": reduction.Track([4, 2, 0], (0, 0, 2.0))}
    data = reduction.reduce(fe, {"a": [NODES - 1]}, 2, loads=named, compare=0)
    assert data.load_names == ("rail 0", "rail 1", "rail 2")
    assert data.quality["tracks"]["rail"]["places"] == pytest.approx([0.0, 0.25, 0.5])
    assert data.load_shapes[:, 2] == pytest.approx([1.0, 1.0, 1.0])
    assert data.load_shapes[0, 4] == pytest.approx(-0.5)  # node 4 lies half a metre from the end
    assert data.rescaled(length=1e3).quality["tracks"]["rail"]["places"] == pytest.approx([0.0, 250.0, 500.0])


@pytest.fixture(scope="module")
def railed(fe):
    return reduction.reduce(
        fe, {"a": [0], "b": [NODES - 1]}, 0, loads={"rail": reduction.Track(range_of(fe)[::4], (0, 0, -1))}, compare=0
    )


def sliding(data, along, speed=0.0, sensors=(), samples=21, run=fmb.simulate):
    """A beam on its bearings and a carriage that slides above it; the load stands where `along` says."""
    axis = fmb.Pose.axes(at=(0, 0, 1), z=(1, 0, 0))
    ground = fmb.Ground(markers={"A": fmb.Pose.axes(z=(0, 1, 0)), "B": (LENGTH, 0, 0), "X": axis})
    beam = fmb.FloatingBody("beam", data=data, markers={"a": fmb.Pose.axes(z=(0, 1, 0))}, damping=0.02)
    markers = {"x": fmb.Pose.axes(z=(1, 0, 0))}
    car = fmb.RigidBody("car", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 1), velocity=(speed, 0, 0), markers=markers)
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[ground, beam, car],
        joints=[
            fmb.Revolute("left", markers=("ground.A", "beam.a")),
            fmb.PointOnPlane("right", markers=("ground.B", "beam.b")),
            fmb.Prismatic("slide", markers=("ground.X", "car.x")),
        ],
        forces=fmb.moving_load("roller", "beam.rail", FORCE, data=data, along=along),
        sensors=sensors,
    )
    return run(model, 0.2, samples=samples) if run is fmb.simulate else run(model)


@pytest.mark.parametrize(
    ("along", "speed", "words"),
    [
        (
            fmb.ramp(rate=12.0) + 5.0,
            0.0,
            "never on its track.*at 5 to 7.4 m, 1 m off the nearest end; expected: places",
        ),
        (fmb.ramp(rate=2.0) - 3.0, 0.0, r"never on its track.*at -3 to -2\.6 m, 2\.6 m off the nearest end"),
        (
            fmb.ramp(rate=12e3),
            0.0,
            "on its track at 1 of 21 samples: it stood at 0 to 2400 m; expected: places from 0 to 4 m",
        ),
        ("slide", 30.0, r"from t = 0\.14 s on it was off its track, where it has no force, up to 2 m; expected"),
        ("slide", -30.0, "on its track at 1 of 21 samples: it stood at -6 to 0 m"),
        (fmb.measured("place", 0), -30.0, "on its track at 1 of 21 samples: it stood at -6 to 0 m"),
    ],
    ids=str,
)
def test_a_load_beside_its_track_is_told(railed, along, speed, words):
    """It has no force there, and the run looked as if nothing was wrong."""
    sensors = [fmb.Position("place", marker="car.x")]
    with pytest.warns(fmb.ValidityWarning, match=f"Moving load 'roller' on track 'beam.rail'.*{words}"):
        solution = sliding(railed, along, speed, sensors)
    assert any("roller" in text for text in solution.statistics["warnings"])


def test_a_load_beside_its_track_in_equilibrium_is_told(railed):
    with pytest.warns(fmb.ValidityWarning, match=r"never on its track.*at 4\.5 m, 0\.5 m off"):
        sliding(railed, 4.5, run=fmb.statics)


def test_a_load_that_crosses_its_track_as_given_is_no_warning(railed):
    """Where it runs off by a given motion, a note says from when on; where it stays, nothing is said."""
    notes = {rate: sliding(railed, fmb.ramp(rate=rate)).statistics["notes"] for rate in (12.0, 30.0)}
    assert not any("roller" in text for text in notes[12.0])
    assert any("off its track from t = 0.14 s on, up to 2 m, without force" in text for text in notes[30.0])
    along = fmb.formula("x + 1", over={"x": fmb.JointCoordinate("x", joint="slide")})
    assert any("was not looked at" in text for text in sliding(railed, along).statistics["notes"])


def test_tracks_that_cannot_be_are_refused(fe):
    one = {"a": [0]}
    for match, loads in [
        ("1 node", {"rail": reduction.Track([3])}),
        ("another load with the name 'rail 1'", {"rail": reduction.Track([3, 4]), "rail 1": {4: (0, 0, 1.0)}}),
    ]:
        with pytest.raises(ReductionError, match=match):
            reduction.reduce(fe, one, loads=loads)
    with pytest.raises(ReductionError, match="join by themselves"):
        reduction.reduce(fe, one, loads={"rail": reduction.Track([3, 4])}, residual_vectors=["rail"])
    with pytest.raises(ReductionError, match="not all zero"):
        reduction.Track([1, 2], (0, 0, 0))
    with pytest.raises(ReductionError, match="a share from 0 to 1"):
        reduction.Track([1, 2], rest=2.0)
    data = reduction.reduce(fe, one, 1, loads={"rail": reduction.Track([3, 4])}, compare=0)
    with pytest.raises(ModelError, match="no track 'rial'"):
        fmb.moving_load("x", "beam.rial", 1.0, data=data, along=fmb.ramp(rate=1.0))


def test_all_loads_join_or_one_by_its_name(fe):
    """Tracks join by themselves and are not meant; one name is a name, not its letters."""
    loads = {"rail": reduction.Track([3, 4]), "tip": {4: (0, 1.0, 0)}, "twist": {4: (0, 0, 0, 1.0, 0, 0)}}
    of = lambda names: reduction.reduce(fe, {"a": [0]}, 2, loads=loads, residual_vectors=names, compare=0)  # noqa: E731
    for names, same in (("all", ["tip", "twist"]), ("tip", ["tip"])):
        given, listed = of(names), of(same)
        assert given.n_modes == listed.n_modes
        np.testing.assert_array_equal(given.stiffness, listed.stiffness)
    assert of("all").n_modes == of("tip").n_modes + 1 == of(()).n_modes + 2
