"""Imports between rooms point upwards, never sideways between kinds, never past what a room must not know."""

from graphlib import CycleError, TopologicalSorter

import pytest
from architecture.rooms import MAY_CALL, MAY_KNOW, MAY_USE_THE_FACE, MUST_NOT_KNOW
from architecture.sources import FILES, PACKAGE, ROOT, dotted, for_each, imports, name, room


def covers(entries, module):
    """Is `module` ("math.kernel") one of the entries or inside one of them?"""
    return any(module == entry or module.startswith(entry + ".") for entry in entries)


def allowed(here, target):
    if target == "":
        return here in MAY_USE_THE_FACE
    if target.split(".")[0] == here or target in ("errors", "told"):
        return True
    known = covers(MAY_KNOW[here], target) and not covers(MUST_NOT_KNOW.get(here, ()), target)
    return known or target in MAY_CALL.get(here, ())


@for_each(FILES)
def test_imports_point_upwards(path):
    here = room(path)
    if here == "":
        return  # the face of the package assembles the public names from every room
    assert here in MAY_KNOW, f"{name(path)} is in no room of docs/architecture.md"
    wrong = [
        f"{name(path)}:{line} imports {module}"
        for module, line in imports(path)
        if module.split(".")[0] == "flexmb" and not allowed(here, module.removeprefix("flexmb").lstrip("."))
    ]
    assert not wrong, f"'{here}' may know {MAY_KNOW[here]}:\n" + "\n".join(wrong)


def test_order_is_acyclic():
    """Each room knows only rooms above it, so no circle can close."""
    order = list(MAY_KNOW)
    for here, targets in MAY_KNOW.items():
        for target in targets + MAY_CALL.get(here, ()):
            assert order.index(target.split(".")[0]) <= order.index(here)


def circle(graph):
    """Return modules that import each other, or nothing; `graph`: what each module imports."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_file_imports_itself_through_others():
    """Not within a room either, nor inside functions: of two files one can be read without the other."""
    graph = {dotted(path): {module for module, _ in imports(path)} - {dotted(path)} for path in FILES}
    assert len(graph) == len(FILES)
    assert not circle(graph), " -> ".join(circle(graph))
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}})


def test_every_room_is_described():
    """The page names every room, and every room's door says in a sentence what it is."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    missing = [here for here in MAY_KNOW if f"`{here}" not in page]
    assert not missing, f"docs/architecture.md does not name {missing}"


@pytest.mark.parametrize("here", [entry for entry in MAY_KNOW if (PACKAGE / entry).is_dir()])
def test_kinds_are_no_neighbours(here):
    """Bodies, joints, forces and sensors never know one another: N + M, not N x M."""
    kinds = {"bodies", "joints", "forces", "sensors"}
    if here in kinds:
        assert not (kinds - {here}) & {target.split(".")[0] for target in MAY_KNOW[here]}
