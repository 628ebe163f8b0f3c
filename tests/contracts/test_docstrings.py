"""The docstring of every public kind names each of its fields, with shape and unit where it is a quantity."""

import inspect
import re
import sys
from dataclasses import fields
from importlib import import_module
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
UNIT = re.compile(r"(?<!\w)(kg|m|m2|s|Hz|rad|N|J|W|Pa|K|V|A|ohm|H|-)(?!\w)")
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


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Return the text of the reference page of joints as it is built, and the folder of its drawings."""
    docs = Path(__file__).parents[2] / "docs"
    sys.path[:0] = [str(docs), str(docs / "images")]
    draw_joints, joint_entries = import_module("draw_joints"), import_module("joint_entries")
    del sys.path[:2]
    source = [(docs / "reference" / "joints.md").read_text("utf-8")]
    joint_entries.fill(None, "reference/joints", source)
    folder = tmp_path_factory.mktemp("joints")
    draw_joints.draw(folder)
    return source[0], folder


@pytest.mark.parametrize("name", joints.KINDS)
def test_every_joint_has_a_drawing_and_an_entry(name, page):
    """Both are made from the kinds when the pages are built."""
    text, folder = page
    picture = (folder / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) < 20_000
    assert text.count(f"![{name}](../images/joints/{name}.png)") == 1
    assert text.count(f".. autoclass:: flexmb.joints.{name}\n") == 1
