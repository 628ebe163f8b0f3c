"""The seed of the random mechanisms is that of all random tests: --seed N."""

import pytest


@pytest.fixture
def seed(request) -> int:
    """Return the first seed of this run."""
    return request.config.getoption("seed")
