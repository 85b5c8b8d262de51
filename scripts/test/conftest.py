"""What several tests of the scripts have in common."""

from __future__ import annotations

import pytest
import update_world


@pytest.fixture(scope="session")
def first(tmp_path_factory):
    """A computer with version 1.0, which no test changes."""
    return update_world.make_world(tmp_path_factory.mktemp("update"))


@pytest.fixture
def world(first, tmp_path):
    """A copy of it."""
    return first.copy(tmp_path / "world")
