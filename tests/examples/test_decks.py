"""Four assemblies from deck to motion: frequencies beside CalculiX, and balances of force and momentum.

The numbers of CalculiX are those of version 2.20 for the decks that `calculix` and `flat` of the generators write (the
same cells, held at the same nodes), for the bracket of a model of solids; `test_numbers_beside_calculix` runs it again.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, io, reduction

FOLDER = Path(__file__).parents[2] / "examples" / "decks"
sys.path.insert(0, str(FOLDER))

import make_assembly  # noqa: E402
import make_decks  # noqa: E402

UNITS = "mm, t, s"
CALCULIX = {
    "wing_box": [26.34011, 81.96608],
    "satellite": [5.199958, 5.204332, 10.48799, 10.48834, 28.63628, 28.81528, 30.67907, 32.09803],
    "bracket": [46.06958, 110.0479, 316.5823, 362.9951, 684.1786, 722.077],
    "arms": [411.7684, 413.9074, 589.0059, 601.1939],
}
"""Hz. Beyond the second mode of the wing box panels swing by themselves, for which its mesh is coarse."""
TOLERANCE = {"wing_box": 1e-2, "satellite": 1.5e-2, "bracket": 2e-2, "arms": 1e-3}


def deck(name):
    return FOLDER / ("arms.inp" if name == "arms" else f"{name}.bdf")


def supports(name):
    return "boundary" if name == "arms" else "spc_1"


def flat(name):
    if name == "arms":
        return make_assembly.flat()
    if name == "bracket":
        return make_decks.bracket_of_solids()
    return make_decks.calculix(make_decks.STRUCTURES[name]())


def test_the_decks_are_those_of_the_generators():
    for name, make in make_decks.STRUCTURES.items():
        assert deck(name).read_text() == make_decks.nastran(make())
    assert deck("arms").read_text() == make_assembly.assembly()


@pytest.mark.parametrize("name", CALCULIX)
def test_frequencies(name):
    fe = fem.read_deck(deck(name), units=UNITS, show=False)
    assert fe.warnings == ()
    checks = fem.deck_checks(fe)
    assert len(checks.parts) == 1
    hinges = {"satellite": (4, 8)}.get(name, (0, 0))  # panel nodes beside the frame, and on its hinges and struts
    assert (len(checks.unmerged), checks.joined) == hinges
    ours = fem.eigenmodes(fe, supports(name), len(CALCULIX[name])).frequencies
    np.testing.assert_allclose(ours[: len(CALCULIX[name])], CALCULIX[name], rtol=TOLERANCE[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", CALCULIX)
def test_numbers_beside_calculix(ccx, tmp_path, name):
    (tmp_path / "job.inp").write_text(flat(name))
    subprocess.run([ccx, "job"], cwd=tmp_path, capture_output=True, check=True, timeout=200)
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    found = [float(row[3]) for row in rows if len(row) == 5 and row[0].isdigit()]
    np.testing.assert_allclose(found[: len(CALCULIX[name])], CALCULIX[name], rtol=1e-4)


@pytest.mark.parametrize("name", CALCULIX)
def test_reduction_keeps_the_frequencies(name):
    """All references of the deck as interfaces; free-free, beside the whole model."""
    fe = fem.read_deck(deck(name), units=UNITS, show=False)
    names = {"wing_box": {"rbe2_1001", "rbe2_1002", "rbe3_2001"}, "satellite": {"rbe2_901"}}
    names |= {"bracket": {"rbe2_801", "rbe3_802", "rbe2_803"}, "arms": {"Left_tip", "Right_tip"}}
    data = reduction.reduce(fe, "all", 16, compare=4)
    assert set(data.marker_names) == names[name]
    assert max(row["error"] for row in data.quality["frequencies"]) < 2e-3


def test_wing_box_rests_on_its_strut():
    """Moments about the hinge line: strut force times its arm balances the weight, by the mass of the deck."""
    model = io.load_model(FOLDER / "wing_box.toml")
    data = model.body("wing").data
    volume = (2 * 2.4 * 0.6 + 2 * 2.4 * 0.14) * 0.006 + 5 * 0.6 * 0.14 * 0.005
    assert data.mass == pytest.approx(2700.0 * volume + 3.0, rel=1e-9)
    at = fmb.statics(model)
    tip, force = at["foot of the strut"][-1], at["strut force"][-1]
    assert force[2] > 0.0
    weight = 9.81 * data.mass * (data.center_of_mass[0] + 0.05)
    foot, head = np.array([1.2, 0.3, -0.58]), tip[:3]
    direction = (head - foot) / np.linalg.norm(head - foot)
    size = np.linalg.norm(force[:3])
    arm = head - (-0.05, head[1], 0.07)
    lifted = size * (arm[0] * direction[2] - arm[2] * direction[0])
    assert lifted == pytest.approx(weight, rel=2e-3)  # the body has turned and bent a little
    assert at["root of the front spar"][-1] > 0.0
    assert at["skins"][-1] > 0.0


def test_thrust_becomes_momentum():
    model = io.load_model(FOLDER / "satellite.toml")
    solution = fmb.simulate(model, t_end=0.6, samples=13)
    momentum = solution[fmb.Momentum("p")][-1][:3]
    np.testing.assert_allclose(momentum, [30.0, 0.0, 0.0], atol=2e-3)  # 60 N for 0.5 s


def test_pendulum_hangs_on_the_bracket():
    model = io.load_model(FOLDER / "bracket.toml")
    hung = fmb.statics(model)
    np.testing.assert_allclose(np.abs(hung["pin force"][-1][:3]), [0.0, 0.0, 4.0 * 9.81], atol=1e-5)
    assert hung["plate"][-1] > 0.0


def test_arms_bend_as_the_full_model():
    """A steady force at the mean of one tip, held at the other: the displacement of the whole finite element model."""
    model = io.load_model(FOLDER / "arms.toml", {"frequency": 1e-9})
    fe = fem.read_deck(deck("arms"), units=UNITS, show=False)
    tip = fe.reference_points["Right_tip"]
    held = fe.reference_points["Left_tip"].node
    load = np.zeros((len(fe.nodes), 6, 1))
    load[tip.node, 2, 0] = 200.0  # the coupling spreads it over the face
    found = fem.static(fe, fe.forces(load)[:, 0], fixed=[held])
    moved = fe.field(found)[tip.node, 2, 0]
    data = model.body("arms").data
    marker = data.marker_names.index("Right_tip")
    clamp = data.marker_names.index("Left_tip")
    # statics of the reduced body, free in its frame: force at one tip, reaction at the other
    six = lambda k: np.vstack([data.marker_translations[k], data.marker_rotations[k]])  # noqa: E731
    force = np.array([0, 0, 200.0, 0, 0, 0])
    arm = data.marker_positions[marker] - data.marker_positions[clamp]
    back = -np.concatenate([force[:3], np.cross(arm, force[:3])])
    eta = np.linalg.solve(data.stiffness, six(marker).T @ force + six(clamp).T @ back)
    seen, base = six(marker) @ eta, six(clamp) @ eta
    bent = seen[:3] - base[:3] - np.cross(base[3:], arm)
    assert bent[2] == pytest.approx(moved, rel=1e-6)
