"""What flexible links keep between their passes: little, so that long chains stay in near memory, and nothing twice."""

import numpy as np
import pytest
from tree.models import flexible_chain, loops
from tree.test_links import linked

from flexmb.system import assemble
from flexmb.tree.flexible.tables import LINE, wide_places
from flexmb.tree.rigid.places import BEND, FIXED, LINK, MOUNT, SINGLE


def flexible_links(model):
    """Return the tables of the links of a model, and its flexible ones."""
    tree = linked(*assemble(model))[0].links
    return tree, tree.flexible


@pytest.mark.parametrize("n", [2, 7])
def test_an_open_chain_keeps_no_matrices(n):
    """Matrices of one body serve all: only columns K^-1 L and place of each body are needed on the way back."""
    _, flexible = flexible_links(flexible_chain(n))
    assert len(flexible.bodies) == n
    for name in ("K", "B", "E", "loaded"):
        assert len(getattr(flexible, name)) == 1, name
    assert len(flexible.wide) <= 3
    assert len(flexible.L) == n


def test_loops_find_the_factors_of_every_body():
    tree, flexible = flexible_links(loops())
    assert len(tree.closing.equations)
    assert len(flexible.K) == len(flexible.B) == len(flexible.bodies)
    assert len(flexible.E) == len(flexible.loaded) == len(flexible.places) > 1
    wide = flexible.wide_of[(flexible.wide_of >= 0) & (tree.links["kind"] != BEND)]
    assert len(set(wide)) == len(wide)


def test_equal_bodies_share_their_constants():
    """Parts of a chain are equal: modes and integrals stand once, however long it is."""
    few, many = (flexible_links(flexible_chain(n))[1] for n in (3, 9))
    assert len(many.constants) == len(few.constants)
    assert len(many.shapes) == len(few.shapes)


def test_eights_do_not_lie_in_two_lines():
    """Rows of eight numbers begin where a line of memory begins; read across two lines they take twice as long."""
    _, flexible = flexible_links(flexible_chain(3))
    for name in ("constants", "shapes", "rises", "E", "loaded", "L", "K", "B", "eta", "scratch", "P", "moved", "zeros"):
        assert getattr(flexible, name).ctypes.data % LINE == 0, name
    assert all(row["constants"] % 8 == 0 for row in flexible.bodies)


def drawn(rng, count: int):
    """Return links of a random tree in the order of its levels: joints, frames of bodies, their markers."""
    links = np.zeros(count, LINK)
    for k in range(count):
        parent = int(rng.integers(-1, k)) if k else -1
        links[k]["parent"], links[k]["kind"] = parent, rng.choice([SINGLE, FIXED])
        if parent >= 0 and links[parent]["kind"] == BEND:
            links[k]["kind"] = MOUNT
        elif rng.uniform() < 0.4:
            links[k]["kind"] = BEND
    return links


@pytest.mark.parametrize("seed", range(40))
def test_inertias_that_are_needed_do_not_share_a_place(seed):
    """Walk from the leaves as the pass does: what is given must still be there when it is taken."""
    rng = np.random.default_rng(seed)
    links = drawn(rng, int(rng.integers(2, 60)))
    count = len(links)
    carries = (links["kind"] == BEND) | (rng.uniform(size=count) < 0.1)
    for k in range(count - 1, -1, -1):
        if carries[k] and links[k]["parent"] >= 0:
            carries[links[k]["parent"]] = True
    kept = rng.uniform(size=count) < 0.2
    places = wide_places(links, carries, kept)
    np.testing.assert_array_equal(places >= 0, carries)
    holds: dict[int, int] = {}  # place: the link whose inertia stands there

    def gives(k: int, to: int) -> None:
        if to >= 0:
            assert holds.get(places[to], to) == to, "another inertia is still needed"
            holds[places[to]] = to

    for k in range(count - 1, -1, -1):
        if not carries[k] or links[k]["kind"] == MOUNT:
            continue
        own = [k]
        if links[k]["kind"] == BEND:
            own = [n for n in range(count) if links[n]["kind"] == MOUNT and carries[n] and links[n]["parent"] == k]
        for n in own:
            gives(-1, n)
        if links[k]["kind"] == BEND:
            for n in own:
                if not kept[n]:
                    holds.pop(places[n])
        gives(k, int(links[k]["parent"]))
        if links[k]["kind"] != BEND and not kept[k]:
            holds.pop(places[k])
    assert len({places[k] for k in np.flatnonzero(kept & carries & (links["kind"] != BEND))}) == np.sum(
        kept & carries & (links["kind"] != BEND)
    )
