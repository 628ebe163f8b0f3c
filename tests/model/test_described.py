"""Misspelt, missing and unnamed fields, flags for numbers, and objects of the wrong kind are told as such."""

import inspect

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import FlexmbError, MeshError, ModelError, ReductionError
from flexmb.results import recover

GOOD = {"mass": 1.0, "inertia": (1, 1, 1)}
ENDS = ("ground.origin", "b.center")
STEEL = fmb.MATERIALS["steel"]
TUBE = fem.Section.tube(diameter=0.02, wall=0.002)
LINE = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]


def beam():
    return fem.frame(points=LINE, section=TUBE, material=STEEL)


def model():
    return fmb.Model(bodies=[fmb.Ground(), fmb.RigidBody("b", **GOOD)])


POINT = fmb.Model(bodies=[fmb.PointMass("m", mass=1.0)])


def rope(**fields):
    return fmb.AncfCable(
        "r", **{"points": LINE, "elements": 2, "section": fem.Section.solid_circle(0.01), "material": STEEL, **fields}
    )


def blade(**fields):
    return fmb.AncfBeam("b", **{"points": LINE, "elements": 2, "section": TUBE, "material": STEEL, **fields})


def plate(**fields):
    return fmb.AncfPlate.rectangle(
        "p", **{"edges": (1.0, 1.0), "elements": (1, 1), "thickness": 0.01, "material": STEEL, **fields}
    )


FIELDS = [
    (lambda: fmb.RigidBody("b", mas=3, inertia=(1, 1, 1)), "RigidBody 'b': there is no field 'mas'", "mean 'mass'"),
    (lambda: fmb.RigidBody("b", mass=3), "the field 'inertia' is missing", "Give inertia a value"),
    (lambda: fmb.RigidBody(), "'name' and 'mass' and 'inertia' is missing", "Give name a value"),
    (lambda: fmb.RigidBody("b", 3, (1, 1, 1)), "3 values without names", "Write mass=..."),
    (lambda: fmb.RigidBody.rod("b", lenght=1, mass=1), "no field 'lenght'", "mean 'length'"),
    (lambda: fmb.RigidBody.rod("b", mass=1), "'length' is missing", "Give length a value"),
    (lambda: fmb.RigidBody.rod("b", length="long", mass=1), "length = 'long'", "Give length a value"),
    (lambda: fmb.RigidBody.box("b", size=(1, 1, 1), density=0.0), "density = 0.0", "Give density a value"),
    (lambda: fmb.Revolute("b", marker=ENDS), "no field 'marker'", "mean 'markers'"),
    (lambda: fmb.Revolute("b", markers=None), "markers = None", "Write markers="),
    (lambda: fmb.SpringDamper("s", markers=ENDS, stifness=1), "no field 'stifness'", "mean 'stiffness'"),
    (lambda: fmb.Position("p", markr="b.center"), "no field 'markr'", "mean 'marker'"),
    (lambda: fmb.Model(body=[]), "Model: there is no field 'body'", "mean 'bodies'"),
    (lambda: fmb.Pose(rot=(0, 0, 1)), "Pose: there is no field 'rot'", "Correct the field's name"),
    (lambda: fmb.Material(yong=1, poisson=0.3, density=1), "Material: there is no field 'yong'", "mean 'young'"),
    (lambda: fmb.IDA(rtoll=1e-6), "IDA: there is no field 'rtoll'", "mean 'rtol'"),
    (lambda: fmb.IDA(rtol="small"), "rtol = 'small'", "Leave rtol out"),
    (lambda: fmb.GeneralizedAlpha(rtol="small"), "rtol = 'small'", "Leave rtol out"),
    (lambda: fmb.GeneralizedAlpha(rho_inf="0.8"), "rho_inf = '0.8'", "Use 0.8"),
    (lambda: fmb.GeneralizedAlpha(rho=0.8), "no field 'rho'", "rho_inf"),
    (lambda: fmb.Release("strut", 3, 4), "3 values without names", "Remove the others"),
    (lambda: fmb.LoadSteps(24), "1 value without a name. Expected: a name for each", "Write steps=24"),
    (lambda: fmb.Box((1, 1, 1), colour="red"), "there is no field 'colour'", "remove it"),
]
VALUES = [
    (lambda: fmb.RigidBody("b", mass=True, inertia=(1, 1, 1)), "mass = True", "Give mass a value"),
    (lambda: fmb.RigidBody("b", mass=1, inertia=(True, 1, 1)), "inertia = (True, 1, 1)", "Write inertia="),
    (lambda: fmb.RigidBody("b", mass=1, inertia="round"), "inertia = 'round'", "Write inertia="),
    (lambda: fmb.RigidBody("b", **GOOD, at=(0, 0, False)), "at = (0, 0, False)", "Write at ="),
    (lambda: fmb.SpringDamper("s", markers=ENDS, stiffness=True), "stiffness = True", "Give stiffness a value"),
    (lambda: fmb.Material(young=True, poisson=0.3, density=1), "young = True", "SI units"),
    (lambda: fmb.Material(young="210e9", poisson=0.3, density=1), "young = '210e9'", "SI units"),
    (lambda: fmb.RigidBody("b", **GOOD, markers={"A", "B"}), "markers = {", "Write markers={"),
    (lambda: fmb.Ground(markers=[(0, 0, 0)]), "markers = [(0, 0, 0)]", "Write markers={"),
    (lambda: fmb.Model(bodies=fmb.RigidBody("b", **GOOD)), "bodies = RigidBody", "Write bodies=[...]"),
    (lambda: fmb.Model(bodies=None), "bodies = None", "Write bodies=[...]"),
    (lambda: fmb.Model(bodies=[fmb.Ground(), fmb.Ground("floor")]), "called 'floor'", "one Ground(markers=...)"),
    (lambda: fmb.Model(bodies=[fmb.RigidBody("ground", **GOOD)]), "a RigidBody called 'ground'", "Rename the body"),
    (lambda: fmb.table([0, 1], [0, float("nan")]), "y has the entry nan at place 1", "Write y ="),
    (lambda: fmb.simulate(model(), 1.0, samples="many"), "samples = 'many'", "samples=1001"),
    (lambda: fmb.simulate(model(), 1.0, samples=2.5), "samples = 2.5", "samples=1001"),
    (lambda: fmb.simulate(model(), 1.0, samples=["a", "b"]), "do not increase", "Sort the times"),
    (lambda: fmb.simulate(model(), "1"), "t_end = '1'", "Give t_end in seconds"),
    (lambda: fmb.simulate(model(), 1.0, integrator="IDA"), "integrator = 'IDA'", "integrator=flexmb.IDA()"),
    (lambda: fmb.simulate(model(), 1.0, integrator=fmb.IDA), "integrator = 'IDA'", "integrator=flexmb.IDA()"),
    (lambda: fmb.simulate(model(), 1.0, integrator="Gen"), "integrator = 'Gen'", "flexmb.GeneralizedAlpha()"),
    (lambda: fmb.simulate(model(), 1.0, formulation=fmb.Recursive), "formulation = ", "Give an object"),
    (lambda: fmb.accelerations(model(), formulation="Kane"), "formulation = 'Kane'", "Give an object"),
    (lambda: fmb.simulate(model(), 1.0, start="rest"), "start = 'rest'", "Leave it out"),
    (lambda: fmb.check(None), "nothing (None)", "Give a flexmb.Model"),
    (lambda: fmb.simulate("model.toml", 1.0), "the text 'model.toml'", "flexmb.load_model"),
    (lambda: fmb.linearize(model(), about="rest"), "a state of the class str", ".final"),
    (lambda: fmb.statics(model(), state=3), "a state of the class int", ".final"),
    (lambda: fmb.accelerations(model(), fmb.statics(POINT)), "3 velocities", "of this model"),
    (lambda: fmb.statics(model(), t="1"), "t = '1'", "Write t=1.0"),
    (lambda: fmb.statics(model(), t=float("nan"), path=fmb.ArcLength()), "t = nan", "Write t=1.0"),
    (lambda: fmb.statics(model(), iterations=0), "iterations = 0", "Leave iterations out"),
    (lambda: fmb.statics(model(), iterations=2.5), "iterations = 2.5", "Leave iterations out"),
    (lambda: fmb.statics(model(), tolerance=-1.0), "tolerance = -1.0", "Leave tolerance out"),
    (lambda: recover.line_forces(rope(), rope().initial_state()[0], 2.0), "fractions = 2.0", "linspace"),
    (lambda: recover.line_forces(rope(), np.zeros(5), 0.5), "coordinates of shape (1, 5)", "series"),
    (lambda: fmb.linearize(fmb.Model), "the class Model itself", "Give a flexmb.Model"),
]
ELASTIC = [
    (lambda: fmb.RigidBody("b", **GOOD, rotation="x"), "rotation = 'x' is no", "Pose.axes"),
    (
        lambda: fmb.RigidBody("b", **GOOD, rotation=(0, float("nan"), 0)),
        "Body 'b': rotation = (0, nan, 0)",
        "Pose.axes",
    ),
    (lambda: fmb.Pose(rotation=0.3), "Pose: rotation = 0.3", "Pose.axes"),
    (lambda: rope(markers={"m": (0.5, 1.2)}), "Body 'r': rotation of marker m = 1.2", "Pose.axes"),
    (lambda: rope(straight="false"), "straight = 'false'", "Leave straight out for False"),
    (lambda: rope(closed=1), "closed = 1", "Leave closed out"),
    (lambda: rope(initial_strain="1e-3"), "initial_strain = '1e-3'", "Write initial_strain="),
    (lambda: rope(lumped_masses=2.0), "lumped mass 2.0", "Write lumped_masses="),
    (lambda: rope(stretches=np.zeros(2)), "stretches = [0., 0.]", "Write stretches="),
    (lambda: rope(tangents="xy"), "tangents = 'xy'", "Write tangents="),
    (lambda: blade(orientation="up"), "orientation = 'up'", "Give the direction"),
    (lambda: blade(rotary_inertia="none"), "rotary_inertia = 'none'", "Leave rotary_inertia out"),
    (lambda: plate(shear="yes"), "shear = 'yes'", "Leave shear out for False"),
    (lambda: plate(markers={"m": ((0.5, 0.5), "x")}), "Body 'p': rotation of marker m = 'x'", "Pose.axes"),
    (lambda: plate(lumped_masses=2.0), "lumped mass 2.0", "Write lumped_masses="),
    (lambda: plate(initial_strain=None), "initial_strain = None", "Write initial_strain="),
    (lambda: fmb.GearPair("g", markers=ENDS, radii=(0.1, "x")), "radii = (0.1, 'x')", "Give the pitch radii"),
    (lambda: fmb.Recursive(cut=3), "cut = 3", "Write cut="),
    (
        lambda: fmb.Pressure("w", load="p.pressure", amount=1.0, freedom="turn"),
        "freedom = 'turn' without",
        "leave freedom out",
    ),
    (
        lambda: fmb.Model(bodies=[rope()], sensors=[fmb.SectionForces("s", body=3)]),
        "body = 3. Expected: a text",
        "Write body=",
    ),
    (
        lambda: fmb.Model(bodies=[rope()], sensors=[fmb.SectionForces("s", body=["r"])]),
        "body = ['r']. Expected: a text",
        "Write body=",
    ),
]
OFFLINE = [
    (lambda: fem.solid(None, STEEL), MeshError, "nothing (None)", "fem.read_mesh"),
    (lambda: fem.read_mesh(None), MeshError, "the path None", "Write fem.read_mesh"),
    (lambda: fem.frame(points=LINE, section=None, material=STEEL), MeshError, "section: nothing", "Section.tube"),
    (lambda: fem.frame(points=LINE, section=TUBE, material="steel"), MeshError, "the text 'steel'", "Material("),
    (lambda: fem.Section.solid_circle(0.0), MeshError, "diameter = 0.0 m", "in metres"),
    (lambda: fem.Section.rectangle("2 cm", 0.01), MeshError, "width = '2 cm' m", "in metres"),
    (lambda: fem.Section.values(None, 1.0, 1.0, 1.0), MeshError, "area = None m2", "in metres"),
    (
        lambda: reduction.reduce(beam(), interfaces=["start"]),
        ReductionError,
        "interfaces = ['start']",
        "Write interfaces={",
    ),
    (
        lambda: reduction.reduce(beam(), interfaces="start"),
        ReductionError,
        "interfaces = 'start'",
        "Write interfaces={",
    ),
    (
        lambda: reduction.reduce(beam(), interfaces={"a": "start"}, stations=[1]),
        ReductionError,
        "stations = [1]",
        "mid",
    ),
    (lambda: reduction.reduce(LINE, interfaces={"a": "start"}), ReductionError, "class list", "fem.solid(mesh"),
    (lambda: fmb.write_vtk(None, "x.pvd"), FlexmbError, "nothing (None)", "flexmb.simulate returns"),
]


@pytest.mark.parametrize(
    ("make", "found", "remedy"), FIELDS + VALUES + ELASTIC, ids=[case[1] for case in FIELDS + VALUES + ELASTIC]
)
def test_descriptions(make, found, remedy):
    with pytest.raises(ModelError) as caught:
        make()
    assert found in str(caught.value)
    assert remedy in str(caught.value)
    assert all((caught.value.part, caught.value.found, caught.value.expected, caught.value.remedy))


@pytest.mark.parametrize(("make", "kind", "found", "remedy"), OFFLINE, ids=[case[2] for case in OFFLINE])
def test_offline(make, kind, found, remedy):
    with pytest.raises(kind) as caught:
        make()
    assert found in str(caught.value)
    assert remedy in str(caught.value)


@pytest.mark.parametrize("material", [None, "steel", {"nope": STEEL}, {"conrod": None}])
def test_materials_of_a_mesh(material):
    mesh = fem.read_mesh("meshes/conrod.msh")
    with pytest.raises(MeshError) as caught:
        fem.solid(mesh, material)
    text = str(caught.value)
    if isinstance(material, dict) and "nope" in material:
        assert "a material is given for the cell set 'nope', which does not exist" in text
        assert "sets with solid cells: conrod." in text
    else:
        assert "Material(young=210e9, poisson=0.3, density=7850.0)" in text


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        ({"ramps": {"rate": 1}}, "Did you mean 'ramp'?"),
        ({"rate": 1}, "Write angle = { ramp = { rate = 1.0 } }"),
        ("2*t", 'Write angle = "= 0.5*t" for an expression'),
        ("valve", 'Write angle = "= valve" for a signal or parameter of this name, "= 0.5*t" for an expression'),
    ],
)
def test_what_looks_like_a_signal(value, remedy):
    with pytest.raises(ModelError, match=r"a signal: a number, a sensor, ramp") as caught:
        fmb.Drive("motor", joint="A", angle=value)
    assert remedy in str(caught.value)


def test_numbers_of_numpy_are_numbers():
    body = fmb.RigidBody("b", mass=np.float64(2.0), inertia=np.ones(3), at=np.zeros(3))
    assert body.mass == 2.0
    assert fmb.simulate(fmb.Model(bodies=[fmb.Ground(), body]), np.float64(0.1), samples=np.int64(3)).t[-1] == 0.1


def test_constructors_still_show_their_parameters():
    assert list(inspect.signature(fmb.RigidBody).parameters)[:2] == ["name", "markers"]
    assert "length" in inspect.signature(fmb.RigidBody.rod).parameters


def test_an_error_inside_a_constructor_is_not_hidden():
    class Odd(fmb.RigidBody):
        def marker_poses(self):
            raise TypeError("inside")

    with pytest.raises(TypeError, match="inside"):
        fmb.Model(bodies=[Odd("b", **GOOD)]).marker_names()


@pytest.mark.parametrize(
    ("expected", "printed"),
    [
        ("a number > 0", "P: f. Expected: a number > 0. R."),
        ("The model has: a, b", "P: f. The model has: a, b. R."),
        ("ModalNeutralData", "P: f. Expected: ModalNeutralData. R."),
        ("", "P: f. R."),
    ],
)
def test_every_sentence_of_a_message_begins_as_one(expected, printed):
    assert str(FlexmbError("P", found="f", expected=expected, remedy="R")) == printed


def test_a_body_in_the_place_of_a_marker():
    model = fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("load", mass=1.0)])
    with pytest.raises(ModelError, match=r"marker 'load' names a body without its marker.*Write 'load.center'"):
        model.marker("load")
