"""A part as a whole: pieces joined, arms, masses, loads; reduced once, found again, damaged, shared, without a disk.

References: closed forms of beams; the same body reduced by hand with `flexmb.fem` and `flexmb.reduction`.
"""

import multiprocessing
import os
import resource
import warnings
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, parts, reduction
from flexmb.errors import FlexmbError, ModelError, ReductionError

BAR = fem.Section.rectangle(0.02, 0.01)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A cache of its own for every test."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    return tmp_path / "bodies"


def beam(length=1.0, **others):
    line = parts.Line(
        points=[(0, 0, 0), (length, 0, 0)], section=BAR, material="steel", elements=8, nodes={"ribs": [0.25, 0.5, 0.75]}
    )
    return parts.Part(
        **{"name": "beam", "pieces": [line], "interfaces": {"a": "start", "b": "end"}, "modes": 4, **others}
    )


def counted(part):
    with parts.watching(parts.Count()) as count:
        data = part.reduced()
    return data, count.reduced, count.reused


def test_the_same_as_by_hand():
    """Frame, arms, masses and load shapes of a description are those of the functions."""
    part = beam(
        links=[parts.Arm(of="ribs", offset=(0, [0.1, 0.2, 0.3], 0), name="arms")],
        masses=[parts.Mass(at="end", mass=2.0)],
        loads={"push": parts.Forces(on="arms", force=(0, 0, [1.0, 2.0, 3.0]), moment=(0.5, 0, 0))},
        stations={"far": [9 + 2]},
    )
    fe = fem.frame(
        np.column_stack([np.linspace(0, 1, 9), np.zeros((9, 2))]), section=BAR, material=fmb.MATERIALS["steel"]
    )
    for k, (node, arm) in enumerate(((2, 0.1), (4, 0.2), (6, 0.3))):
        fe = fem.with_node(fe, (0.125 * node, arm, 0.0))
        fe = fem.with_rigid_link(fe, node, [9 + k])
    fe = fem.with_mass(fe, "end", 2.0)
    push = reduction.NodalForces({9 + k: (0, 0, 1.0 + k, 0.5, 0, 0) for k in range(3)})
    by_hand = reduction.reduce(fe, {"a": "start", "b": "end"}, modes=4, stations={"far": [11]}, loads={"push": push})
    data = part.reduced()
    assert np.allclose(data.frequencies, by_hand.frequencies, rtol=1e-10)
    assert np.allclose(
        np.abs(data.load_shapes), np.abs(by_hand.load_shapes), atol=1e-7 * np.abs(by_hand.load_shapes).max()
    )
    assert data.mass == pytest.approx(7850.0 * 2e-4 + 2.0, rel=1e-12)


def test_joined_plates_are_a_box():
    """A thin-walled box of four plates twists like Bredt's: theta = T L oint(ds/t) / (4 A^2 G)."""
    b, h, t, length, steel = 0.2, 0.1, 2e-3, 1.0, fmb.MATERIALS["steel"]
    corners = [(0, 0), (b, 0), (b, h), (0, h)]
    walls = [
        parts.Plate(
            corners=[(0, *p), (0, *q), (length, *q), (length, *p)],
            thickness=t,
            material=steel,
            size=0.05,
            name=f"wall_{k}",
        )
        for k, (p, q) in enumerate(zip(corners, corners[1:] + corners[:1]))
    ]
    ends = [
        parts.RigidLink(nodes=where, reference=(x, b / 2, h / 2), name=name)
        for name, x, where in (("near", 0.0, "root"), ("far", length, "tip"))
    ]
    part = parts.Part(name="box", pieces=walls, interfaces={"near": "near", "far": "far"}, modes=0, compare=0)
    fe = part.finite_elements()
    sets = {"root": np.flatnonzero(fe.nodes[:, 0] < 1e-9), "tip": np.flatnonzero(fe.nodes[:, 0] > length - 1e-9)}
    fe = replace(fe, node_sets={**fe.node_sets, **sets})
    for end in ends:
        fe = end.applied(fe)
    load = np.zeros((len(fe.nodes), 6, 1))
    load[fe.node_sets["far"][0], 3] = 100.0
    u = fe.field(fem.static(fe, fe.forces(load)[:, 0], fe.node_sets["near"])[:, None])
    # the ends keep their shape and are held against warping; of a box with b/h = 2 that stiffens a length of about b
    expected = 100.0 * length * 2.0 * (b + h) / t / (4.0 * (b * h) ** 2 * steel.shear)
    assert u[fe.node_sets["far"][0], 3, 0] == pytest.approx(expected, rel=0.05)


def test_reduced_once(folder):
    """The same content is found again, by equal descriptions too; any change of content is reduced anew."""
    data, made, found = counted(beam())
    assert (made, found) == (1, 0)
    again, made, found = counted(beam())
    assert (made, found) == (0, 1)
    assert np.array_equal(data.shapes, again.shapes)
    for change in (
        {"length": 1.1},
        {"modes": 5},
        {"geometric_stiffness": True},
        {"masses": [parts.Mass(at="end", mass=1.0)]},
    ):
        assert counted(beam(**change))[1:] == (1, 0), change
    assert counted(beam(parameters={"L": 1.0}, model="station"))[1:] == (0, 1)
    assert len(parts.kept_bodies()) == len(list(folder.glob("*.h5"))) == 5


def test_a_changed_mesh_is_another_part(tmp_path):
    """The content of the file decides, not its date."""
    mesh = tmp_path / "bar.inp"
    cells = "*ELEMENT,TYPE=C3D4,ELSET=all\n1,1,2,3,4\n2,2,3,4,5\n*NSET,NSET=foot\n1,2,3\n"
    text = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n" + cells
    mesh.write_text(text)
    part = lambda: parts.Part(  # noqa: E731
        name="bar", pieces=[parts.MeshFile(file=mesh, material="steel")], interfaces={"a": "foot"}, modes=0, compare=0
    )
    counted(part())
    os.utime(mesh, (1, 1))
    assert counted(part())[1:] == (0, 1)
    mesh.write_text(text.replace("5,1,1,1", "5,1,1,1.5"))
    assert counted(part())[1:] == (1, 0)
    (tmp_path / "nodes.inp").write_text("1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n")
    mesh.write_text("*NODE, INPUT=nodes.inp\n" + cells)
    counted(part())
    (tmp_path / "nodes.inp").write_text("1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,2\n")
    assert counted(part())[1:] == (1, 0), "what the mesh includes counts as well"


def test_a_deck(tmp_path):
    """A whole deck in millimetres: a cantilever tube with its mass in tonnes; another wall is another part."""
    card = "PBARL,1,1,,TUBE\n,{outer},{inner}\n"
    deck = tmp_path / "beam.bdf"
    text = (
        "SOL 103\nCEND\nBEGIN BULK\nMAT1,1,210000.,,0.3,7.85-9\n"
        + card
        + "".join(f"GRID,{k + 1},,{100.0 * k},0.,0.\n" for k in range(11))
        + "".join(f"CBAR,{k},1,{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
        + "ENDDATA\n"
    )
    deck.write_text(text.format(outer="20.", inner="18."))
    part = lambda: parts.Part(  # noqa: E731
        name="beam",
        deck=deck,
        units="mm, t, s",
        interfaces={"root": [0], "tip": [10]},
        masses=[
            parts.Mass(at=list(range(11)), mass=0.0, inertia=(1e-5, 1e-9, 1e-9))
        ],  # bars of Nastran have none about their axis
        modes=4,
    )
    data, made, _ = counted(part())
    area = np.pi * (0.02**2 - 0.018**2)
    assert made == 1
    assert data.mass == pytest.approx(7850.0 * area, rel=1e-6)
    deck.write_text(text.format(outer="20.", inner="16."))
    assert counted(part())[0].mass == pytest.approx(7850.0 * np.pi * (0.02**2 - 0.016**2), rel=1e-6)


@pytest.mark.parametrize(("side", "lumped"), [(1.0, None), (-1.0, False), (0.0, True), (None, None)])
def test_side_of_the_stress_of_a_deck(tmp_path, side, lumped):
    """A cantilever strip with a force at its tip: the faces carry +-6 F (L - x) / (b t^2), the middle nothing."""
    deck, n = tmp_path / "strip.bdf", 10
    rows = [f"GRID,{2 * i + j + 1},,{0.1 * i:.1f},{0.1 * j:.1f},0." for i in range(n + 1) for j in range(2)]
    rows += [f"CQUAD4,{i + 1},1,{2 * i + 1},{2 * i + 3},{2 * i + 4},{2 * i + 2}" for i in range(n)]
    rows += ["PSHELL,1,1,.01,1", "MAT1,1,7.+10,,0.,2700.", "GRID,90,,0.,.05,0.", "GRID,91,,1.,.05,0."]
    rows += ["RBE2,95,90,123456,1,2", f"RBE2,96,91,123456,{2 * n + 1},{2 * n + 2}"]
    deck.write_text("\n".join(["BEGIN BULK", *rows, "ENDDATA"]))
    part = parts.Part(
        name="strip", deck=deck, units="m, kg, s", interfaces="all", modes=2, stress_side=side, lumped=lumped
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        data = part.reduced()
    words = [str(w.message) for w in told if "middle surface, without bending" in str(w.message)]
    assert len(words) == (side is None)
    assert sum("middle surface" in w for w in data.quality["warnings"]) == (side is None)
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"r": (0, 0.05, 0)}), fmb.FloatingBody("strip", data=data)],
        joints=[fmb.Fixed("root", markers=("ground.r", "strip.rbe2_95"))],
        forces=[fmb.PointLoad("tip", marker="strip.rbe2_96", force=(0, 0, -1.0))],
        sensors=[fmb.Stress("s", body="strip", node="node 11", component="xx")],
    )
    found = np.ravel(fmb.statics(model)["s"])[-1]
    assert found == pytest.approx((side or 0.0) * 6.0 * 0.5 / (0.1 * 0.01**2), rel=1e-4, abs=1.0)


@pytest.mark.parametrize(
    ("options", "words"), [({"stress_side": 2}, "stress_side = 2"), ({"lumped": "no"}, "lumped = 'no'")]
)
def test_options_of_decks_that_cannot_be(tmp_path, options, words):
    (tmp_path / "a.bdf").write_text("BEGIN BULK\nENDDATA\n")
    with pytest.raises(ModelError, match=words):
        parts.Part(name="a", deck=tmp_path / "a.bdf", interfaces="all", **options)


class Told:
    """Keeps what is told about troubles of the cache."""

    def __init__(self):
        self.troubles, self.count = [], 0

    def progress(self, part, stage, fraction):
        assert 0.0 <= fraction <= 1.0

    def made(self, part, seconds):
        self.count += 1

    def taken(self, part):
        pass

    def trouble(self, part, text):
        self.troubles.append(text)


@pytest.mark.parametrize("damage", [b"", b"not hdf5", "middle"])
def test_a_damaged_entry_is_made_again(folder, damage):
    data = beam().reduced()
    (entry,) = folder.glob("*.h5")
    whole = entry.read_bytes()
    whole = whole[: whole.index(b"FLEXSEAL") + 24]  # as of former times: the parity behind it would restore the bytes
    half = len(whole) // 2
    other = bytes(byte ^ 0x5A for byte in whole[half : half + 64])  # zeros may have been there before
    entry.write_bytes(damage if isinstance(damage, bytes) else whole[:half] + other + whole[half + 64 :])
    with parts.watching(Told()) as told:
        again = beam().reduced()
    assert told.count == 1
    assert len(told.troubles) == 1
    assert "damaged" in told.troubles[0]
    assert np.array_equal(data.frequencies, again.frequencies)
    assert counted(beam())[1:] == (0, 1)


def test_a_full_disk_loses_nothing(monkeypatch):
    """The body is made and used, and it is said that it could not be kept."""
    monkeypatch.setenv("FLEXMB_BODIES", "/dev/full/bodies")
    with parts.watching(Told()) as told:
        assert beam().reduced().n_modes == 10
    assert told.count == 1
    assert "cannot be kept" in told.troubles[0]


def _reduce_on_a_small_disk(queue):
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
    with parts.watching(Told()) as told:
        data = beam().reduced()
    queue.put((data.n_modes, told.count, told.troubles))


def test_a_disk_that_fills_during_the_write(folder):
    """The body is made and used, it is said that it could not be kept, and nothing half written is left to be read."""
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(target=_reduce_on_a_small_disk, args=(queue,))
    process.start()
    n_modes, made, troubles = queue.get(timeout=60)
    process.join()
    assert (n_modes, made) == (10, 1)
    assert "could not be kept" in troubles[0]
    assert "FLEXMB_BODIES" in troubles[0]
    assert "File too large" in troubles[0]
    assert not list(folder.iterdir())
    assert counted(beam())[1:] == (1, 0)
    assert counted(beam())[1:] == (0, 1)


def _reduce_in_a_process(ready, queue):
    ready.wait()
    _, made, found = counted(beam(length=1.3, modes=6))
    queue.put((made, found))


def test_two_processes_reduce_once():
    context = multiprocessing.get_context("fork")
    ready, queue = context.Event(), context.Queue()
    processes = [context.Process(target=_reduce_in_a_process, args=(ready, queue)) for _ in range(2)]
    for process in processes:
        process.start()
    ready.set()
    results = sorted(queue.get(timeout=60) for _ in processes)
    for process in processes:
        process.join()
    assert results == [(0, 1), (1, 0)]


def test_bodies_take_descriptions():
    """A body with a description has its data; `similar` too; equal bodies of Python need no file."""
    body = fmb.FloatingBody("arm", data=beam())
    assert isinstance(body.data, fmb.ModalNeutralData)
    assert body.data.recipe["part"]["pieces"][0]["kind"] == "Line"
    large = fmb.FloatingBody.similar("arm", data=beam(), scale=2.0)
    assert large.data.mass == pytest.approx(8.0 * body.data.mass)


def test_a_part_that_nothing_holds_is_refused():
    with pytest.raises(ModelError, match=r"Part 'beam', interfaces: none.*the places where joints and forces hold"):
        beam(interfaces={}, stations={"mid": (0.5, 0, 0)})


def test_a_station_beside_the_part():
    """In a bore or on an arm: it needs no node."""
    data = beam(stations={"beside": (0.5, 0.3, 0.0)}).reduced()
    assert data.marker_positions[data.marker_names.index("beside")] == pytest.approx((0.5, 0.3, 0.0))


def test_the_data_file_carries_its_recipe(tmp_path):
    data = beam(parameters={"L": 1.0}, model="station").reduced()
    path = data.save(tmp_path / "beam.h5")
    recipe = fmb.ModalNeutralData.load(path).recipe
    assert recipe["parameters"] == {"L": 1.0}
    assert recipe["part"]["pieces"][0]["points"] == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"interfaces": {"a": "stat"}}, "Did you mean 'start'"),
        ({"interfaces": {"a": (0.5, 0.01, 0.0)}}, "no node at"),
        ({"loads": {"air": parts.Forces(on="ribs", force=(0, 0, [1, 2]))}}, "a list of 3"),
        ({"links": [parts.Arm(of="ribs", offset=(0, 1, 0), name="ribs")]}, "exists already"),
        (
            {"links": [parts.Arm(of="ribs", offset=(0, [0.1, 0.0, 0.1], 0), name="arms")]},
            r"Arm 'arms': an arm of length 0 at \[0.5, 0.0, 0.0\] m",
        ),
        ({"stations": {"far": (50.0, 0.01, 0.0)}}, "Station 'far'.* 49 m away from the nearest node of a part of 1 m"),
        (
            {"residual_vectors": ["aer"], "loads": {"air": parts.Forces(on="ribs", force=(0, 0, 1))}},
            "Did you mean 'air'",
        ),
    ],
)
def test_what_does_not_fit_the_elements_is_named(change, message):
    with pytest.raises(FlexmbError, match=message) as told:
        beam(**change).reduced()
    assert told.value.part.startswith("Part 'beam'")


def test_pieces_that_do_not_meet_are_refused():
    far = parts.Line(points=[(2, 0, 0), (3, 0, 0)], section=BAR, material="steel", name="far")
    with pytest.raises(ModelError, match="2 separate pieces"):
        parts.Part(name="x", pieces=[*beam().pieces, far], interfaces={"a": "start"}).reduced()


def test_a_misspelt_accuracy():
    """The remedy names the text form too."""
    for wrong in ("up to 200", "upto 200 Hz within 1 %"):
        with pytest.raises(
            ModelError, match=rf"Part 'beam': modes = '{wrong}'.*or modes = \"up to 200 Hz within 1 %\""
        ):
            beam(modes=wrong)


def test_stress_of_a_part_of_beams_is_refused():
    """Beams have forces: the largest of no stresses would read as 0 Pa."""
    body = fmb.FloatingBody("jib", data=beam().reduced())
    with pytest.raises(
        fmb.ModelError, match=r"body 'jib', whose elements are beams, rods or springs: none gives stress"
    ):
        fmb.check(fmb.Model(bodies=[fmb.Ground(), body], sensors=[fmb.Stress("s", body="jib")]))


BARS = "\n".join(
    [
        "BEGIN BULK",
        "MAT1,1,7.+10,,0.33,2700.",
        "PBARL,1,1,,ROD",
        "+,.01",
        *(f"GRID,{k + 1},,{0.1 * k:.1f},0.,0." for k in range(4)),
        *(f"CBAR,{k},1,{k},{k + 1},0.,0.,1." for k in range(1, 4)),
        "ENDDATA",
    ]
)


def test_a_deck_of_bars_is_told_what_it_lacks(tmp_path):
    """Bars of Nastran have no inertia about their line; with it the part has its mass, pi r^2 L rho."""
    (tmp_path / "bars.bdf").write_text(BARS)
    given = {"name": "bars", "deck": tmp_path / "bars.bdf", "units": "m, kg, s", "modes": 0, "compare": 0}
    given["interfaces"] = {"a": "node 1", "b": "node 4"}
    told = r"no mass resists rigid motion in rotation x.*own line.*model file lumped = false; or add.*inertia=\(Ixx"
    with pytest.raises(ReductionError, match=told):
        parts.Part(**given).reduced()
    consistent = parts.Part(**given, lumped=False).reduced()
    assert consistent.mass == pytest.approx(np.pi * 1e-4 * 0.3 * 2700.0, rel=1e-6)
    assert consistent.inertia[0, 0] == pytest.approx(np.pi * 1e-8 / 2.0 * 0.3 * 2700.0, rel=1e-3)  # pi r^4 / 2 L rho
    ends = parts.Mass(at=[0], mass=0.0, inertia=(1e-6, 1e-12, 1e-12))
    with pytest.raises(
        ReductionError, match=r"an interface motion without mass.*of a part in a model file lumped = false"
    ):
        parts.Part(**given, masses=[ends]).reduced()
    every = parts.Mass(at=[0, 1, 2, 3], mass=0.0, inertia=(1e-6, 1e-12, 1e-12))
    data = parts.Part(**given, masses=[every]).reduced()
    assert data.mass == pytest.approx(np.pi * 1e-4 * 0.3 * 2700.0, rel=1e-6)


def test_a_folder_is_no_deck(tmp_path):
    (tmp_path / "flap.bdf").mkdir()
    with pytest.raises(ModelError, match=r"'flap.bdf' is a folder\. Expected: a mesh or deck.*Correct the name"):
        parts.Part(name="flap", deck=tmp_path / "flap.bdf", interfaces="all")
