"""The arm on which the functions of the compiled core are tried."""

from __future__ import annotations

import pytest

import ravengc as rg


@pytest.fixture(scope="session")
def panda() -> rg.Robot:
    """A robot that nobody changes."""
    return rg.load("panda")


@pytest.fixture
def robot() -> rg.Robot:
    """A robot to change."""
    return rg.load("panda")
