"""The docstring of every public kind names each of its fields, with shape and unit where it is a quantity."""

import inspect
import re
from dataclasses import fields
from pathlib import Path

import pytest

from flexmb import bodies, constraints, forces, joints, sensors
from flexmb.integrate import IDA, GeneralizedAlpha

CLASSES = {
    **{
        f"{room.__name__.rpartition('.')[2]}.{name}": kind
        for room in (bodies, joints, forces, sensors)
        for name, kind in room.KINDS.items()
    },
    **{f"constraints.{kind.__name__}": kind for kind in constraints.EQUATIONS},
    "integrate.GeneralizedAlpha": GeneralizedAlpha,
    "integrate.IDA": IDA,
}
ENTRY = re.compile(r"^(?P<names>\w+(?:, \w+)*) : (?P<type>.+)$", re.MULTILINE)
UNIT = re.compile(r"(?<!\w)(kg|m|m2|s|Hz|rad|N|J|W|Pa|K|-)(?!\w)")
QUANTITY = re.compile(r"\bfloat\b|\bsignals?\b|\(3,\)|\(n")


def entries(kind) -> dict[str, str]:
    """Return name: type of every entry of the section Parameters."""
    found = {}
    for match in ENTRY.finditer(inspect.cleandoc(kind.__doc__)):
        found.update(dict.fromkeys(match["names"].split(", "), match["type"]))
    return found


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_is_described(name):
    kind = CLASSES[name]
    own = {f.name for f in fields(kind) if f.init}
    if (
        getattr(kind, "prescribes", False)
        or getattr(kind, "couples", False)
        or kind.__name__ in ("FloatingBody", "PointMass")
    ):
        own.discard("markers")
    missing = own - set(entries(kind)) - {"name"}
    assert not missing, f"{kind.__name__} does not describe {sorted(missing)}"


@pytest.mark.parametrize("name", CLASSES)
def test_quantities_have_a_unit(name):
    for field, text in entries(CLASSES[name]).items():
        if QUANTITY.search(text):
            assert UNIT.search(text), f"{name}.{field}: '{text}' has no unit"


@pytest.mark.parametrize("name", CLASSES)
def test_first_sentence_says_what_it_does(name):
    first = inspect.cleandoc(CLASSES[name].__doc__).splitlines()[0]
    assert len(first) > 15
    assert first.endswith((".", ":")), first


@pytest.mark.parametrize("name", joints.KINDS)
def test_every_joint_has_a_drawing_and_an_entry(name):
    """The pictures are made by docs/images/draw_joints.py."""
    docs = Path(__file__).parents[2] / "docs"
    picture = (docs / "images" / "joints" / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) < 20_000
    page = (docs / "reference" / "joints.md").read_text("utf-8")
    assert f"![{name}](../images/joints/{name}.png)" in page
    assert f".. autoclass:: flexmb.joints.{name}\n" in page
