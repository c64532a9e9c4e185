"""Long inputs that are the same all over: what they cost is as their length, and what is said of them is short."""

from __future__ import annotations

import io
import json
import signal
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from snhc.conformance import ledger
from snhc.conformance.candidate import Malformed, csv_rows, ndjson
from snhc.conformance.compare import fell_over, said, span
from snhc.conformance.filters import MOST_GLOB, selector
from snhc.reference_impl.bitstream.errors import MOST_SHOWN, InputFormat, SnhcError
from snhc.reference_impl.documents.bt_text import Token, parse_nodes
from snhc.reference_impl.face.fap_text import read_fap
from snhc.reference_impl.systems.output import CSV_COLUMNS

LONG = 400_000
HEADER = b"2.1 name 25 1\n" + b"0 " * 2 + b"1 " * 4 + b"0 " * 62 + b"\n0 "
KNOWN = '[[known]]\nvectors = "{}"\nadapter = "{}"\nreason = "x"\nlink = "{}"\nexpires = 2030-01-01\n'


@contextmanager
def at_once() -> Iterator[None]:
    """Ten seconds; what is square in its length takes minutes."""

    def stuck(*_: object) -> None:
        pytest.fail("takes more than its length")

    before = signal.signal(signal.SIGALRM, stuck)
    signal.alarm(10)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def refused(read: Callable[[], object]) -> str:
    with at_once(), pytest.raises((SnhcError, Malformed)) as raised:
        read()
    words = str(raised.value)
    assert len(words) < 3 * MOST_SHOWN and "\n" not in words
    return words


@pytest.mark.parametrize("token", (b"1e" + b"0" * LONG + b"x", b"1." + b"1" * LONG + b"x", b"1" * LONG + b"x"))
def test_a_long_number_that_is_none(token: bytes) -> None:
    assert "value 1 of the line" in refused(lambda: read_fap(io.BytesIO(HEADER + token + b" 2 3 4\n")))
    assert "frame rate" in refused(lambda: read_fap(io.BytesIO(b"2.1 name " + token + b" 1\n")))


def test_exponents_with_zeros_before_them_are_read() -> None:
    text = HEADER + b"1e" + b"0" * LONG + b"2 2e000 30e-001 -4E+01\n"
    with at_once():
        assert read_fap(io.BytesIO(text)).frames[0].values[2:6] == [100, 2, 3, -40]


@pytest.mark.parametrize(
    ("vectors", "adapter"), (("[" * LONG, "*"), ("*", "[" * LONG), ("fap.*|" + "a" * (MOST_GLOB + 1), "*"))
)
def test_patterns_of_a_ledger_are_short(vectors: str, adapter: str, tmp_path: Path) -> None:
    path = tmp_path / "known.toml"
    path.write_text(KNOWN.format(vectors, adapter, "https://x"))
    assert "patterns of at most" in refused(lambda: ledger.load(path).entries[0].fits("x", "fap.x"))
    path.write_text(KNOWN.format("|".join(["a" * MOST_GLOB] * 1000), "*", "https://x"))
    with at_once():
        assert not ledger.load(path).entries[0].fits("x", "fap.x")


def test_patterns_of_a_filter_are_short() -> None:
    assert "patterns of at most" in refused(lambda: selector("id=fap.*|" + "[" * LONG))
    selector("|".join(["a" * MOST_GLOB] * 1000))


def test_what_is_said_of_a_long_value_is_short(tmp_path: Path) -> None:
    path = tmp_path / "known.toml"
    path.write_text(KNOWN.format("*", "*", "a" * LONG))
    assert "link" in refused(lambda: ledger.load(path))
    head = b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n'
    frame = {
        "index": 0, "time": "0/1", "intra": True, "faps": [None] * 68, "viseme": None, "expression": None,
        "state": "U" * 68,
    }  # fmt: skip
    ndjson(head + json.dumps(frame).encode())
    for key in ("index", "time", "intra"):
        for value in ("x" * LONG, [[0] * 1000] * 100, {"y" * LONG: 1}):
            text = head + json.dumps({**frame, key: value}).encode()
            assert key in refused(partial(ndjson, text))
    faps = [*[None] * 67, "x" * LONG]
    assert "FAP 68" in refused(lambda: ndjson(head + json.dumps({**frame, "faps": faps}).encode()))
    refused(lambda: ndjson(head.replace(b":1,", b':"' + b"1" * LONG + b'",')))
    rows = ",".join(CSV_COLUMNS).encode() + b"\n" + b"9" * 100_000 + b"," * (len(CSV_COLUMNS) - 1)
    assert "index" in refused(lambda: csv_rows(rows))
    refused(lambda: span({"bits": ["x" * LONG]}))


@pytest.mark.parametrize("inside", ("x" * LONG, "\\x" * LONG, '\\"' * LONG))
@pytest.mark.parametrize("end", ("", '" }'))
def test_long_strings_of_node_text_take_a_few_times_their_length(inside: str, end: str) -> None:
    text = 'a { b "' + inside + end
    tracemalloc.start()
    try:
        with at_once():
            if end:
                (value,) = parse_nodes(text)[0].fields["b"]
                assert isinstance(value, Token) and len(value.text) == LONG
            else:
                refused(lambda: parse_nodes(text))
        assert tracemalloc.get_traced_memory()[1] < 8 * len(text)
    finally:
        tracemalloc.stop()


def test_an_error_keeps_both_ends_of_what_it_shows() -> None:
    error = InputFormat("CNF-7", "name", value="<" + "x" * LONG + ">", allowed="less")
    assert "=<xxx" in str(error) and "xxx>: allowed less (CNF-7)" in str(error)
    assert len(str(InputFormat("CNF-7", "n", value="x" * MOST_SHOWN))) > MOST_SHOWN, "what is short is shown whole"


@pytest.mark.parametrize(
    "part", (b": line 1: ", b"x: line 1: \n", b"==1==\n\n", b"ERROR: aSanitizer", b'{"a":', b"{\n")
)
def test_standard_error_of_any_kind(part: bytes) -> None:
    text = part * (LONG // len(part))
    with at_once():
        assert not fell_over(text)
        assert said(text) == {}
