"""Rows are filled by field name: from what a part gives, else from its own fields."""

from types import SimpleNamespace

import numpy as np
import pytest

from flexmb.model.table import Table

INNER = np.dtype([("kind", np.int64), ("sign", float)], align=True)
TABLE = Table("Sample", np.dtype([("x", INNER), ("stiffness", float), ("pair", np.int64)], align=True), {})


def test_given_fields_go_first_and_others_are_those_of_the_part():
    part = SimpleNamespace(stiffness=3.0, pair=7)
    row = np.array([TABLE.filled(part, {"pair": 2, "x": {"sign": -1.0, "kind": 1}})], TABLE.row)[0]
    assert (row["pair"], row["stiffness"], row["x"]["kind"], row["x"]["sign"]) == (2, 3.0, 1, -1.0)


def test_names_that_the_row_does_not_have_are_refused():
    with pytest.raises(TypeError, match="rows of Sample have no pairs"):
        TABLE.filled(SimpleNamespace(stiffness=3.0, pair=7), {"x": {"sign": 1.0, "kind": 0}, "pairs": 2})


def test_a_field_that_nobody_has_is_missing():
    with pytest.raises(AttributeError, match="stiffness"):
        TABLE.filled(SimpleNamespace(), {"pair": 2, "x": {"sign": 1.0, "kind": 0}})
