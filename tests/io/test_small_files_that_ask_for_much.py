"""Small model files with one number or word that asks for too much, or has no value: refused at once, by name."""

import pytest
from fuzz.data_files import reduced

import flexmb as fmb
from flexmb import fem
from flexmb.errors import FlexmbError

HINGES = """
[[body]]
kind = "Ground"
[[body]]
kind = "RigidBody"
name = "b"
mass = 1
inertia = [1.0, 1.0, 1.0]
[[body]]
kind = "RigidBody"
name = "c"
mass = 1
inertia = [1.0, 1.0, 2.0]
[[joint]]
kind = "Revolute"
name = "A"
markers = ["ground.origin", "b.center"]
[[joint]]
kind = "Revolute"
name = "B"
markers = ["b.center", "c.center"]
[[joint]]
kind = "Prismatic"
name = "slide"
markers = ["ground.origin", "c.center"]
"""
ROPE = """
[[body]]
kind = "AncfCable"
name = "rope"
points = [[0, 0, 0], [1.0, 0, 0]]
elements = 8
section = { kind = "Section.solid_circle", diameter = 0.02 }
material = { kind = "Material", young = 1e8, poisson = 0.3, density = 1000.0 }
"""
SHEET = """
[[body]]
kind = "AncfPlate"
name = "sheet"
points = [[[0, 0, 0], [0, 1, 0]], [[2, 0, 0], [2, 1, 0]]]
elements = [2, 2]
thickness = 0.01
material = { kind = "Material", young = 1e8, poisson = 0.3, density = 1000.0 }
"""
SHAPE = '{{ kind = "Section", area = 1, inertia_y = 1, inertia_z = 1, torsion = 1, shape = {} }}'
CIRCLE = '{ kind = "Section.solid_circle", diameter = 0.02 }'
COATED = """
[[body]]
kind = "AncfCable"
name = "rope"
points = [[0, 0, 0], [1.0, 0, 0]]
elements = 4
section = {{ kind = "Section.solid_circle", diameter = 0.02 }}
material = {{ kind = "Material", young = 1e8, poisson = 0.3, density = 1000.0 }}
skins = {{ coat = {{ kind = 'Skin', spacing = {}, radius = {} }} }}
"""
PATH = """
[[joint]]
kind = "PointOnPath"
name = "path"
markers = ["ground.A", "b.center"]
through = ["ground.B", "ground.C"]
"""
MUSCLE = """
[[force]]
kind = "Muscle"
name = "pull"
through = ["ground.A", "ground.B", "b.center"]
excitation = 1
strength = 900.0
fibre = 0.2
tendon = 1.0
"""
PLACES = 'kind = "Ground"\nmarkers = {{ A = [{}, 0, 0], B = [1, 0, 0], C = [1, 1, 0] }}'.format
COUPLED = '[[joint]]\nkind = "{}"\nname = "part"\njoints = ["A", "slide"]\nmarkers = {}\n{} = 0.25\n'


@pytest.mark.parametrize(
    ("text", "change", "words"),
    [
        (ROPE, ("elements = 8", "elements = 583428"), "elements = 583428. Expected: a whole number from 1 to 100000"),
        (ROPE, ("elements = 8", "elements = 9223372036854775807"), "a whole number from 1 to 100000"),
        (SHEET, ("[2, 2]", "[2147483648, 2]"), "at most 40000 elements"),
        (SHEET, ("[2, 2]", "[201, 200]"), "at most 40000 elements"),
        (ROPE, (CIRCLE, SHAPE.format('["tube", 0.02, 0.002]')), "shape = ('tube', 0.02, 0.002)"),
        (ROPE, (CIRCLE, SHAPE.format('["between", 0.02, 0.002, 0.3]')), "Expected: the name of a constructor"),
        (HINGES + COUPLED, ("{}", "Coupler", "1.7e308", "ratio"), "markers = 1.7e+308. Expected: two names"),
        (HINGES + COUPLED, ("{}", "RackAndPinion", '"= t"', "radius"), "Expected: two names"),
        (
            HINGES + '[[joint]]\nkind = "Drive"\nname = "d"\njoint = "A"\nangle = 1\nmarkers = 7\n',
            ("mass = 1", "mass = 1"),
            "markers = 7. Expected: two names",
        ),
        (
            HINGES
            + '[[joint]]\nkind = "Rolling"\nname = "part"\nmarkers = ["ground.origin", "b.center"]\nradius = 1\n',
            ("[1.0, 1.0, 1.0]", "[1.0, 1.0, 0.0]"),
            "part: NoSlip[1] has no value",
        ),
        (
            HINGES + COUPLED.format("RackAndPinion", '["", ""]', "radius"),
            ("mass = 1\ninertia = [1.0, 1.0, 2.0]", "mass = 1.7e308\ninertia = [1.0, 1.0, 2.0]"),
            "divided by the roots of the masses",
        ),
        (COATED, ("{}", "0.1", "2147483648"), "points. Expected: 1 to 1000000 points"),
        (COATED, ("{}", "1e-300", "1e300"), "skin coat of 1e+300 points"),
        (
            SHEET,
            ("[2, 2]", "[2, 2]\nskins = { coat = { kind = 'Skin', spacing = 1e-308 } }"),
            "skin coat of inf points",
        ),
        (HINGES + PATH, ('kind = "Ground"', PLACES("1e300")), "coordinate 1e+300 m"),
        (HINGES + MUSCLE, ('kind = "Ground"', PLACES("1.7e308")), "coordinate 1.7e+308 m"),
    ],
)
def test_refused(tmp_path, text, change, words):
    old, *new = change
    text = text.format(*new) if old == "{}" else text.replace(old, *new)
    (tmp_path / "model.toml").write_text(text)
    with pytest.raises(FlexmbError) as caught:
        fmb.check(fmb.load_model(tmp_path / "model.toml"))
    assert words in str(caught.value)


def test_all_bodies_together(monkeypatch):
    """Each body within its limit, all of them not."""
    monkeypatch.setattr("flexmb.system.layout.MOST", 50)
    section, material = fem.Section.solid_circle(0.01), fmb.Material(young=1e9, poisson=0.3, density=1e3)
    ropes = [
        fmb.AncfCable(f"rope {k}", points=((0, k, 0), (1, k, 0)), elements=4, section=section, material=material)
        for k in range(2)
    ]
    fmb.check(fmb.Model(bodies=[fmb.Ground(), ropes[0]]))
    with pytest.raises(FlexmbError, match=r"60 velocities. Expected: at most 50. Use fewer elements"):
        fmb.check(fmb.Model(bodies=[fmb.Ground(), *ropes]))


@pytest.mark.parametrize("modes", [2**31, 2**62, 10**300])
def test_more_modes_than_there_are(modes):
    """The number is compared before so many indices are made."""
    with pytest.raises(FlexmbError, match=r"Body 'part': modes = \d+\. Expected: a whole number of modes up to"):
        fmb.FloatingBody("part", data=reduced(), modes=modes)
