"""Model files: what they may hold, and that saving and loading gives the same model."""

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb import io
from flexmb.bodies import Ground, RigidBody
from flexmb.forces import PointLoad, SpringDamper
from flexmb.io.field_values import same
from flexmb.joints import Drive, Revolute, Rod
from flexmb.model.model import Model
from flexmb.model.pose import Pose
from flexmb.model.signal import expression
from flexmb.model.simple_signals import harmonic, ramp, step
from flexmb.model.table_signal import table
from flexmb.sensors import Position, Reaction

CRANK = """
name = "crank"
gravity = [0, 0, -9.81]

[parameters]
radius = 0.05
rate = "= 60/radius*0.025"          # 30 rad/s
blade = ["= radius", 0, 0.1]
which = "crank"

[[body]]
kind = "Ground"
markers = { A = { at = [0.1, 0, 0], z = [1, 0, 0] }, ramp = { at = [0, 0, "= 2*radius"] } }

[[body]]
kind = "RigidBody"
name = "= which"
mass = 0.16
inertia = [1e-5, 1.3e-4, 1.3e-4]
at = [0.1, "= radius", 0]
rotation = [0, "= 90*deg", 0]
[body.markers]
A = { at = [0, "= -radius", 0], rotation = [0, "= 90*deg", 0] }
tip = "= blade"

[[joint]]
kind = "Revolute"
name = "A"
markers = ["ground.A", "crank.A"]

[[joint]]
kind = "Drive"
name = "motor"
joint = "A"
angle = { ramp = { rate = "= rate", rise = 0.2 } }

[[force]]
kind = "PointLoad"
name = "push"
marker = "crank.tip"
force = [0, "= 3*sin(rate*t)", { sum = [
    { step = { value = 2, rise = 0.1 } },
    { table = { x = [0, 1], y = [0, 5], kind = "linear" } },
] }]

[[sensor]]
kind = "Reaction"
name = "bearing"
joint = "A"

[simulation]
t_end = "= 2*pi/rate"
samples = 101
"""


@pytest.fixture
def write(tmp_path):
    def file(text, name="crank.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return file


def assert_same(a, b):
    """The same parts with the same fields, and nothing else."""
    assert same(a.gravity, b.gravity)
    assert a.name == b.name
    assert dict(a.parameters) == dict(b.parameters)
    for family in ("bodies", "joints", "forces", "sensors", "events"):
        for one, other in zip(getattr(a, family), getattr(b, family), strict=True):
            assert type(one) is type(other)
            for field, value in one.fields().items():
                assert same(value, other.fields()[field]), f"{one.title}: {field}"


def test_load(write):
    model = io.load_model(write(CRANK))
    crank = model.body("crank")
    assert model.name == "crank"
    assert model.gravity == (0.0, 0.0, -9.81)
    assert model.parameters == {"radius": 0.05, "rate": 30.0, "blade": (0.05, 0, 0.1), "which": "crank"}
    assert crank.at == (0.1, 0.05, 0.0)
    assert crank.marker_poses()["tip"].at == (0.05, 0.0, 0.1)
    assert crank.marker_poses()["A"].matrix @ [1, 0, 0] == pytest.approx([0, 0, -1], abs=MACHINE)
    assert model.body("ground").marker_poses()["A"].matrix[:, 2].tolist() == [1, 0, 0]
    assert model.body("ground").marker_poses()["ramp"].at == (0, 0, 0.1)
    assert same(model.joint("motor").angle, ramp(rate=30.0, rise=0.2))
    x, y, z = model.force("push").force
    assert x.value == 0.0
    assert same(y, expression("3*sin(rate*t)", rate=30.0))
    assert same(z, step(value=2, rise=0.1) + table([0, 1], [0, 5], kind="linear"))
    assert model.sensors[0].joint == "A"


def test_parameters_are_set(write):
    path = write(CRANK)
    model = io.load_model(path, {"radius": 0.1, "which": "arm"} | {"which": "crank"})
    assert model.body("crank").at == (0.1, 0.1, 0.0)
    assert model.parameters["rate"] == pytest.approx(15.0)
    assert io.load_model(path, {"rate": 7}).joint("motor").angle.rate == 7.0


def test_simulation(write):
    path = write(CRANK)
    settings = io.load_simulation(path)
    assert (settings.t_end, settings.samples, settings.integrator) == (
        pytest.approx(2 * np.pi / 30),
        101,
        None,
    )
    assert io.load_simulation(path, {"rate": 1.0}, t_end=3.0, samples=11).keywords() == {
        "t_end": 3.0,
        "samples": 11,
    }
    assert io.load_simulation(write("name = 'x'"), t_end=2).keywords() == {"t_end": 2.0}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('"Recursive"', fmb.Recursive()),
        ('{ kind = "Recursive", cut = ["B"] }', fmb.Recursive(cut=("B",))),
        ('{ kind = "Baumgarte", alpha = "= rate", formulation = { kind = "NullSpace" } }', None),
    ],
)
def test_formulations(write, tmp_path, text, expected):
    """What `save_model` writes of an integrator in joint coordinates can be read again."""
    path = write(CRANK + f'integrator = {{ kind = "Explicit", formulation = {text} }}\n')
    settings = io.load_simulation(path)
    assert settings.integrator.formulation == (expected or fmb.Baumgarte(fmb.NullSpace(), alpha=30.0))
    saved = io.save_model(io.load_model(path), tmp_path / "saved.toml", settings)
    assert io.load_simulation(saved).integrator == settings.integrator


def test_unknown_formulation(write):
    path = write(CRANK + 'integrator = { kind = "Explicit", formulation = "recursive" }\n')
    with pytest.raises(fmb.ModelError, match=r"integrator\.formulation: kind = 'recursive'.*One of: .*Did you mean"):
        io.load_simulation(path)


@pytest.mark.parametrize(
    "text", ['"GeneralizedAlpha"', '{ kind = "GeneralizedAlpha", rho_inf = 0.5, step = "= 1/rate" }']
)
def test_integrators(write, tmp_path, text):
    path = write(CRANK + f"integrator = {text}\n")
    settings = io.load_simulation(path)
    assert type(settings.integrator).__name__ == "GeneralizedAlpha"
    assert settings.integrator.rho_inf == (0.5 if "rho" in text else 0.8)
    assert settings.integrator.step == (pytest.approx(1 / 30) if "step" in text else None)
    saved = io.save_model(io.load_model(path), tmp_path / "saved.toml", settings)
    assert io.load_simulation(saved).integrator == settings.integrator


def everything():
    return Model(
        name="everything",
        gravity=(0, 0, -9.81),
        parameters={"span": 1.5, "file": "x", "list": (1.0, 2.0)},
        bodies=[
            Ground(markers={"A": (0, 0, 0), "B": Pose.axes((0.1, 0.2, 0.3), x=(1, 2, 3), z=(3, 0, -1))}),
            RigidBody(
                "b",
                mass=2.0,
                inertia=((1, 0.1, 0), (0.1, 1, 0), (0, 0, 1)),
                at=(0.1, 0.2, 0.3),
                rotation=(0.1, -0.2, 0.3),
                velocity=(1e-3, 2, 1 / 3),
                angular_velocity=(0, 0, 1),
                markers={"A": Pose((0, 1, 0), (0.1, 0, 0))},
            ),
            RigidBody("c", mass=2.0, inertia=(1, 1, 1), center_of_mass=(0.1, 0, 0), markers={"A": (0, 1, 0)}),
        ],
        joints=[
            Revolute("A", markers=("ground.B", "b.A")),
            Drive("motor", joint="A", angle=harmonic(amplitude=1, frequency=2)),
            Rod("link", markers=("b.center", "c.A"), length=0.3),
        ],
        forces=[
            SpringDamper("spring", markers=("ground.A", "c.A"), stiffness=1e3, damping=0.1),
            PointLoad(
                "load",
                marker="c.A",
                force=(expression("a*t", a=2), 3, ramp(rate=1.0) * table([0, 1], [1, 2])),
                axes="b.A",
            ),
        ],
        sensors=[Position("p", marker="c.A"), Reaction("r", joint="A")],
    )


def test_save_and_load_give_the_same_model(tmp_path):
    model = everything()
    settings = io.Simulation(t_end=0.1, samples=11)
    path = io.save_model(model, tmp_path / "run" / "model.toml", settings)
    assert_same(io.load_model(path), model)
    assert io.load_simulation(path).keywords() == settings.keywords()
    again = io.save_model(io.load_model(path), tmp_path / "again.toml", settings)
    assert again.read_text() == path.read_text()


def test_model_as_text():
    model = everything()
    assert_same(io.read_model_text(io.model_text(model)), model)


def test_expressions_are_evaluated_when_saved(write, tmp_path):
    model = io.load_model(write(CRANK), {"radius": 0.1})
    saved = io.save_model(model, tmp_path / "resolved.toml")
    assert_same(io.load_model(saved), model)
    assert "= blade" not in saved.read_text()


def test_text_with_every_kind_of_character(tmp_path):
    name = 'Klappe "2" \\ Größe\n\t#'
    model = Model(name=name, bodies=[Ground(markers={"a b": (0, 0, 0), "ä": (0, 0, 1)})])
    assert_same(io.load_model(io.save_model(model, tmp_path / "m.toml")), model)


def test_numbers_keep_every_digit(tmp_path, rng):
    markers = {
        f"m{k}": tuple(x) for k, x in enumerate(rng.normal(size=(50, 3)) * 10.0 ** rng.integers(-20, 20, (50, 1)))
    }
    model = Model(bodies=[Ground(markers=markers)])
    assert_same(io.load_model(io.save_model(model, tmp_path / "m.toml")), model)


def test_constructors_of_kinds(write):
    text = """
    [[body]]
    kind = "RigidBody.sphere"
    name = "ball"
    radius = 0.1
    density = 7850
    """
    assert io.load_model(write(text)).body("ball").mass == pytest.approx(4 / 3 * np.pi * 1e-3 * 7850)


def test_what_a_file_cannot_hold(tmp_path):
    from flexmb.errors import ModelError

    model = Model(bodies=[Ground()], parameters={"f": 1.0}).with_parts(sensors=[Position("p", marker="ground.origin")])
    object.__setattr__(model.sensors[0], "marker", lambda: 0)
    with pytest.raises(
        ModelError,
        match=r"Sensor 'p'.marker: a value of type function\. Expected: numbers, text.*cannot hold Python objects",
    ):
        io.save_model(model, tmp_path / "m.toml")
