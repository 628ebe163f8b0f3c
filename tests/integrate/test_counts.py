"""Numbers of a run in several parts."""

from flexmb.integrate.runs.counts import together


def test_counts_add_up_and_the_most_is_the_most():
    before = {"steps": 3, "most contacts": 8, "largest residual of contacts [m/s]": 1e-9}
    after = {"steps": 4, "most contacts": 5, "largest residual of contacts [m/s]": 2e-9, "sweeps": 7}
    assert together(before, after) == {
        "steps": 7,
        "most contacts": 8,
        "largest residual of contacts [m/s]": 2e-9,
        "sweeps": 7,
    }
    assert together({}, after) == after


def test_ways_of_factorising_are_told_once_each():
    tree, loop = {"elimination": "recursion"}, {"elimination": "sparse order"}
    both = {"elimination": "recursion; then sparse order"}
    assert together({}, tree) == together(tree, tree) == tree
    assert together(tree, loop) == together(both, tree) == together(both, both) == both


def test_numbers_by_part_are_the_largest():
    before, after = {"errors": {"a": 0.1, "b": 0.2}}, {"errors": {"b": 0.1, "c": 0.3}}
    assert together(before, after) == {"errors": {"a": 0.1, "b": 0.2, "c": 0.3}}


def test_what_is_not_known_of_one_part_is_not_known_of_both():
    share, unknown = {"errors added up": 0.01}, {"errors added up": "not estimated"}
    assert together(share, unknown) == together(unknown, share) == together(unknown, unknown) == unknown
