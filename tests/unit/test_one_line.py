"""Errors are one printable line, whatever an input holds. Rules: CNF-7."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.errors import InputFormat, one_line


@given(st.text(st.characters(codec=None)))
def test_nothing_breaks_the_line(text: str) -> None:
    shown = one_line(text)
    assert shown.isprintable()
    shown.encode()
    assert one_line(shown) == shown
    if text.isprintable():
        assert shown == text
    assert InputFormat("CNF-2", "word", value=text, allowed="x").message.isprintable()


def test_what_is_escaped() -> None:
    assert one_line("a\n\x1b[31mé\udc80") == "a\\n\\x1b[31mé\\udc80"
