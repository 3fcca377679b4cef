"""What is written as TOML is read back the same, to the last bit, on one line of printable characters."""

from __future__ import annotations

import tomllib
from math import isnan
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from ravengc.config.toml_values import toml_value

texts = st.text(st.characters(exclude_categories=["Cs"]))
values = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | texts,
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=12,
)


@given(value=values)
def test_what_is_written_is_read_back(value: Any) -> None:
    written = toml_value(value)
    found = tomllib.loads(f"key = {written}")["key"]
    assert repr(found) == repr(value)  # -0.0 and True stay what they are
    assert written.isprintable()


def test_what_is_no_number_stays_none() -> None:
    assert isnan(tomllib.loads(f"key = {toml_value(float('nan'))}")["key"])
