"""Every block and every force with states in a model file: read, run, linear, written and read again, all the same.

What the file says is compared with the same block made in Python.
"""

import numpy as np
import pytest

import flexmb as fmb

STAGE = """
[[body]]
kind = "Ground"
markers = { x = { at = [0, 0, 0], z = [1, 0, 0] }, wall = [-0.3, 0, 0] }

[[body]]
kind = "RigidBody"
name = "cart"
mass = 2.0
inertia = [1, 1, 1]
at = [0.3, 0, 0]
velocity = [0.1, 0, 0]
markers = { x = { at = [0, 0, 0], z = [1, 0, 0] } }

[[joint]]
kind = "Prismatic"
name = "rail"
markers = ["ground.x", "cart.x"]

[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.wall", "cart.center"]
length = 0.5
stiffness = 50.0
damping = 2.0

[[sensor]]
kind = "JointCoordinate"
name = "x"
joint = "rail"
"""
X, V = fmb.measured("x"), fmb.measured("x", rate=True)
BLOCKS = {
    "measured": ('{ measured = "x" }', X),
    "measured rate": ('{ measured = { of = "x", rate = true } }', V),
    "formula": (
        '{ formula = { text = "-k*x + rate(x)", over = { x = "x" }, parameters = { k = 3.0 } } }',
        fmb.formula("-k*x + rate(x)", over={"x": "x"}, k=3.0),
    ),
    "sum": ('{ sum = [{ measured = "x" }, 2.0] }', X + 2.0),
    "product": ('{ product = [-2.0, { measured = "x" }] }', -2.0 * X),
    "lag": ('{ lag = { of = { measured = "x" }, time = 0.05, start = 0.1 } }', fmb.Lag(X, time=0.05, start=0.1)),
    "delay": ('{ delay = { of = { measured = "x" }, time = 0.05, order = 2 } }', fmb.Delay(X, time=0.05, order=2)),
    "integral": (
        '{ integral = { of = { measured = "x" }, gain = -2.0, limits = [-1.0, 1.0] } }',
        fmb.Integral(X, gain=-2.0, limits=(-1.0, 1.0)),
    ),
    "pid": (
        '{ pid = { of = { product = [-1.0, { measured = "x" }] }, kp = 4.0, ki = 2.0, kd = 1.0, filter = 0.02 } }',
        fmb.Pid(-1.0 * X, kp=4.0, ki=2.0, kd=1.0, filter=0.02),
    ),
    "transfer_function": (
        '{ transfer_function = { of = { measured = "x" }, numerator = [1.0, 2.0], denominator = [0.1, 1.0, 3.0] } }',
        fmb.TransferFunction(X, numerator=[1.0, 2.0], denominator=[0.1, 1.0, 3.0]),
    ),
    "state_space": (
        '{ state_space = { of = [{ measured = "x" }, { measured = { of = "x", rate = true } }], A = [[-3.0]], '
        "B = [[1.0, 2.0]], C = [[2.0]], D = [[0.0, 0.5]] } }",
        fmb.StateSpace([X, V], A=[[-3.0]], B=[[1.0, 2.0]], C=[[2.0]], D=[[0.0, 0.5]]),
    ),
    "limit": ('{ limit = { of = { measured = "x" }, limits = [-0.1, 0.2] } }', fmb.Limit(X, limits=(-0.1, 0.2))),
    "dead_zone": (
        '{ dead_zone = { of = { measured = "x" }, limits = [-0.1, 0.2] } }',
        fmb.DeadZone(X, limits=(-0.1, 0.2)),
    ),
    "rate_limit": (
        '{ rate_limit = { of = { measured = "x" }, limits = [-1.0, 2.0], time = 0.01 } }',
        fmb.RateLimit(X, limits=(-1.0, 2.0), time=0.01),
    ),
    "table": (
        '{ table = { x = [-1.0, 0.0, 2.0], y = [3.0, 0.0, -1.0], of = { measured = "x" }, kind = "linear" } }',
        fmb.table([-1.0, 0.0, 2.0], [3.0, 0.0, -1.0], of=X, kind="linear"),
    ),
    "table2": (
        "{ table2 = { x = [-1.0, 2.0], y = [-9.0, 9.0], z = [[1.0, 2.0], [0.0, -3.0]], "
        'of = [{ measured = "x" }, { measured = { of = "x", rate = true } }], kind = "linear" } }',
        fmb.table2([-1.0, 2.0], [-9.0, 9.0], [[1.0, 2.0], [0.0, -3.0]], of=(X, V), kind="linear"),
    ),
    "input": ('{ input = { name = "push", value = 0.7 } }', fmb.input("push", 0.7)),
}
HELD = {
    "relay": (
        '{ relay = { of = { measured = "x" }, limits = [0.0, 0.31], values = [1.0, -1.0] } }',
        fmb.Relay(X, limits=(0.0, 0.31), values=(1.0, -1.0)),
    ),
    "quantiser": (
        '{ quantiser = { of = { measured = "x" }, step = 0.05, hysteresis = 0.01 } }',
        fmb.Quantiser(X, step=0.05, hysteresis=0.01),
    ),
    "sampled": (
        '{ sampled = { of = { measured = "x" }, period = 0.02, offset = 0.01 } }',
        fmb.Sampled(X, period=0.02, offset=0.01),
    ),
    "sampled_state_space": (
        '{ sampled_state_space = { of = { measured = "x" }, A = [[0.5]], B = [[1.0]], C = [[2.0]], D = [[0.1]], '
        "period = 0.02 } }",
        fmb.SampledStateSpace(X, A=[[0.5]], B=[[1.0]], C=[[2.0]], D=[[0.1]], period=0.02),
    ),
}
BETWEEN = ("ground.wall", "cart.center")
FORCES = {
    "DcMotor": (
        'joint = "rail"\nvoltage = { measured = "x" }\nresistance = 1.0\ninductance = 1e-3\n'
        "constant = 0.1\nratio = 50.0",
        fmb.DcMotor("f", joint="rail", voltage=X, resistance=1.0, inductance=1e-3, constant=0.1, ratio=50.0),
    ),
    "HydraulicCylinder": (
        'markers = ["ground.wall", "cart.center"]\nvalve = { measured = "x" }\nareas = [2e-5, 1.2e-5]\nstroke = 1.0\n'
        "dead_volume = 1e-6\nsupply = 2e6\nrated_flow = 1e-5",
        fmb.HydraulicCylinder(
            "f",
            markers=BETWEEN,
            valve=X,
            areas=(2e-5, 1.2e-5),
            stroke=1.0,
            dead_volume=1e-6,
            supply=2e6,
            rated_flow=1e-5,
        ),
    ),
    "MaxwellDamper": (
        'joint = "rail"\nbranches = [[200.0, 0.01], [50.0, 0.3]]',
        fmb.MaxwellDamper("f", joint="rail", branches=((200.0, 0.01), (50.0, 0.3))),
    ),
    "LuGre": (
        'joint = "rail"\nstiffness = 1e3\ndamping = 10.0\nviscous = 0.4\nmoving = 1.0\nstanding = 1.5\nstribeck = 0.01',
        lambda: fmb.LuGre(
            "f", joint="rail", stiffness=1e3, damping=10.0, viscous=0.4, moving=1.0, standing=1.5, stribeck=0.01
        ),
    ),
    "Muscle": (
        'through = ["ground.wall", "cart.center"]\nexcitation = 0.4\nstrength = 9.0\nfibre = 0.3\ntendon = 0.3',
        fmb.Muscle("f", through=BETWEEN, excitation=0.4, strength=9.0, fibre=0.3, tendon=0.3),
    ),
    "Airload": (
        'marker = "cart.center"\nchord = 0.3\nspan = 0.5\nwind = [5.0, 0, 0.5]',
        fmb.Airload("f", marker="cart.center", chord=0.3, span=0.5, wind=(5.0, 0, 0.5)),
    ),
}


def from_file(folder, part: str) -> fmb.Model:
    path = folder / "model.toml"
    path.write_text(STAGE + part)
    return fmb.load_model(path)


def pushed(folder, text: str, signal):
    """Return a cart pushed by a block as read from a file, and as made in Python."""
    read = from_file(folder, f'\n[[force]]\nkind = "Actuator"\nname = "push"\njoint = "rail"\neffort = {text}\n')
    return read, same_stage(folder, fmb.Actuator("push", joint="rail", effort=signal))


def same_stage(folder, force) -> fmb.Model:
    stage = from_file(folder, "")
    return stage.with_parts(forces=[force])


def all_the_same(folder, read: fmb.Model, made: fmb.Model, smooth: bool = True) -> None:
    again = fmb.load_model(fmb.save_model(read, folder / "again.toml"))
    assert fmb.model_text(again) == fmb.model_text(read)
    runs = [fmb.simulate(one, 0.2, samples=6) for one in (read, again, made)]
    still = fmb.simulate(from_file(folder, ""), 0.2, samples=6)
    assert np.abs(runs[0]["x"] - still["x"]).max() > 1e-6  # the part acts
    for run in runs[1:]:
        assert np.array_equal(run["x"], runs[0]["x"])
    if smooth:
        plants = [fmb.linearize(one).eigenvalues for one in (read, again, made)]
        assert np.array_equal(plants[0], plants[1])
        assert np.array_equal(plants[0], plants[2])
        assert np.any(plants[0] != 0.0)
    else:
        with pytest.raises(fmb.FlexmbError, match="push"):
            fmb.linearize(read)


@pytest.mark.parametrize("word", [*BLOCKS, *HELD])
def test_blocks(tmp_path, word):
    text, signal = {**BLOCKS, **HELD}[word]
    all_the_same(tmp_path, *pushed(tmp_path, text, signal), smooth=word in BLOCKS)


@pytest.mark.parametrize("kind", FORCES)
def test_forces_with_states(tmp_path, kind):
    text, force = FORCES[kind]
    read = from_file(tmp_path, f'\n[[force]]\nkind = "{kind}"\nname = "f"\n{text}\n')
    all_the_same(tmp_path, read, same_stage(tmp_path, force() if callable(force) else force))
