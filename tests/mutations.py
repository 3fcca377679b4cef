"""Hypothesis strategy: a valid text, damaged in a few places the way editors, transfers and attackers damage files."""

from __future__ import annotations

from hypothesis import strategies as st

TOKENS = (
    "nan", "-inf", "1e999", "-0.0", "0", "-1", "9" * 400, "true", '""', '"x"', '"1 m"', '"90 deg"', "[]", "[[", "]]",
    "{}", "{", "=", "\n", "\x00", "\ud800", "é", "<", ">", "/>", "&lt;", "&x;", "<!DOCTYPE a>", "base", "tool",
    "[" * 300,
    "a." * 80 + "a", "2020-01-01", "'''", '"""', "#", "${x}", "<a>" * 70, "1_0", "0x" + "f" * 400, "\r", "\ufeff",
)  # fmt: skip


@st.composite
def damaged(draw: st.DrawFn, text: str, longest: int = 40) -> str:
    """Apply one to four edits: cut a piece out, put a token in, replace a piece by a token, repeat a piece, cut off."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, longest)))
        piece = draw(st.one_of(st.just(""), st.sampled_from(TOKENS), st.just(text[start:end] * 2), st.text(max_size=5)))
        text = text[:start] + piece + text[end if draw(st.integers(0, 15)) else len(text) :]
    return text
