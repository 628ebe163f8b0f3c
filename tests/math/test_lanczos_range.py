"""Matrices whose products leave the range of numbers are refused by name."""

import numpy as np
import pytest

from flexmb.errors import FlexmbError
from flexmb.math.lanczos import lowest_modes


@pytest.mark.parametrize("stiffness", [1e-200, 0.0])
def test_products_beyond_the_range_of_numbers(stiffness):
    with np.errstate(all="ignore"), pytest.raises(FlexmbError, match="beyond the range of numbers"):
        lowest_modes(lambda x: x / np.float64(stiffness), lambda x: x, 20, 3)
