"""Bodies that stay connected when one is taken out: searched once, beside a search of every case."""

import pytest

from flexmb.model.connections import Separations, reached


def graph(rng, n: int, links: int) -> dict[str, set[str]]:
    connected: dict[str, set[str]] = {f"b{k}": set() for k in range(n)}
    for a, b in rng.integers(n, size=(links, 2)):
        if a != b:
            connected[f"b{a}"].add(f"b{b}")
            connected[f"b{b}"].add(f"b{a}")
    return connected


@pytest.mark.parametrize("density", [0.5, 1.0, 1.5, 3.0])
def test_parts_are_what_can_be_reached(density, rng):
    for n in (1, 2, 5, 9, 14):
        for _ in range(20):
            connected = graph(rng, n, int(density * n))
            parts = Separations(connected)
            for without in connected:
                rest = [name for name in connected if name != without]
                for name in rest:
                    known = reached(connected, [name], without=without)
                    own = parts.part(without, name)
                    assert known == {other for other in rest if parts.part(without, other) == own}


def test_a_long_chain_needs_no_deep_recursion():
    n = 20_000
    connected = {f"b{k}": {f"b{j}" for j in (k - 1, k + 1) if 0 <= j < n} for k in range(n)}
    parts = Separations(connected)
    assert parts.part("b100", "b99") == parts.part("b100", "b0") != parts.part("b100", "b101")
    assert parts.part("b100", "b101") == parts.part("b100", f"b{n - 1}")
