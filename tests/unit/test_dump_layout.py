"""Dumps on narrow terminals: no line is longer than the terminal, and every element is still there."""

from __future__ import annotations

import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from snhc.analyzer.dump import TreeOptions, dump_tree
from snhc.analyzer.dump_layout import WIDE, layout_for
from snhc.analyzer.parts import Parts
from snhc.analyzer.query import Query
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import Options, trace_stream

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
STREAMS = sorted(
    path
    for kind in ("fba", "neg", "dct", "mesh")
    for path in [*(SAMPLES / kind).glob("*/input.fba"), *(SAMPLES / kind).glob("*/input.m2d")]
    if path.read_bytes().startswith(b"\0\0\1")
)[::6]
SPAN = re.compile(r"^\[\d+, \d+\)", re.MULTILINE)
COMMAND = [sys.executable, "-m", "snhc.conformance.cli", "dump", "--no-pager"]


def shown(data: bytes, columns: int | None, query: str = "", symbols: bool = False) -> str:
    parts = Parts(trace_stream(data, Options(), symbols=symbols))
    options = TreeOptions(symbols=symbols, layout=layout_for(columns))
    return "".join(dump_tree(parts, BytesSource(data), options, Query(query) if query else None))


@pytest.mark.parametrize("path", STREAMS, ids=lambda path: path.parent.name)
def test_no_line_is_longer_than_the_terminal_and_no_span_is_missing(path: Path) -> None:
    data = path.read_bytes()
    wide = shown(data, None)
    for columns in (40, 60, 69, 70, 80, 100, 109, 110, 132, 400):
        text = shown(data, columns)
        assert max(map(len, text.splitlines())) <= columns
        assert SPAN.findall(text) == SPAN.findall(wide)
    assert shown(data, 400).splitlines()[0] == wide.splitlines()[0]


@pytest.mark.parametrize("columns", (60, 80, 120))
def test_symbols_and_queries_fit_too(columns: int) -> None:
    assert max(map(len, shown(WORKED, columns, symbols=True).splitlines())) <= columns
    taken = shown(WORKED, columns, "name == 'fap_mask_type'")
    assert max(map(len, taken.splitlines())) <= columns
    # What was asked for is shown whole: folded, not cut.
    assert taken.count("fap_mask_type") == 10
    whole = [line.split("plane[", 1)[1].split() for line in shown(WORKED, None, "kind == 'segment'").splitlines()[1:]]
    folded = shown(WORKED, columns, "kind == 'segment'").split()
    assert all(word in folded for words in whole for word in words[1:])


def test_messages_are_folded_and_elements_cut_between_words() -> None:
    data = (SAMPLES / "fba").glob("*/input.fba")
    text = shown(next(iter(sorted(data))).read_bytes(), 60)
    words = " ".join(text.split())
    assert "no-sequence-header: the SYS-7 stream begins without visual_object_sequence" in words
    cut = [line for line in text.splitlines() if "..." in line and "fap_mask_type = 2" in line]
    assert all(line.endswith("fap_mask_type = 2 (mask; the ... FBA-10") for line in cut)


def test_the_bits_of_a_symbol_segment_are_all_there() -> None:
    def bits(text: str) -> str:
        return "".join(re.findall(r"^\[\d+, \d+\) +([01]{2,64})$", text, re.MULTILINE))

    assert bits(shown(WORKED, 60, symbols=True)) == bits(shown(WORKED, None, symbols=True)) != ""


def test_numbers_that_grow_longer_move_the_column_once() -> None:
    data = WORKED[:-4] + b"".join(bytes.fromhex("000001bb") + b"\x07" for _ in range(30_000)) + WORKED[-4:]
    rules = [line.index("FBA-") for line in shown(data, 80).splitlines() if "FBA-" in line]
    assert set(rules) == {74}


def on_terminal(columns: int, path: Path) -> str:
    """What a terminal of so many columns is sent."""
    import fcntl
    import pty
    import termios

    main, side = pty.openpty()
    fcntl.ioctl(side, termios.TIOCSWINSZ, struct.pack("HHHH", 500, columns, 0, 0))
    environment = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES")}
    process = subprocess.Popen(
        [*COMMAND, str(path)], stdin=side, stdout=side, stderr=subprocess.DEVNULL, env={**environment, "NO_COLOR": "1"}
    )
    os.close(side)
    out = b""
    try:
        while data := os.read(main, 1 << 16):
            out += data
    except OSError:
        pass  # how a terminal says that nobody writes to it any more
    os.close(main)
    assert process.wait(60) == 0
    return out.decode().replace("\r\n", "\n")


@pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")
def test_a_terminal_gets_its_width_and_a_pipe_always_the_same(tmp_path: Path) -> None:
    path = tmp_path / "x.fba"
    path.write_bytes(WORKED)
    for columns in (60, 80, 140):
        assert on_terminal(columns, path) == shown(WORKED, columns)
    for columns in ("60", "80"):
        environment = {**os.environ, "COLUMNS": columns}
        piped = subprocess.run([*COMMAND, str(path)], capture_output=True, check=True, env=environment, timeout=60)
        assert piped.stdout.decode() == shown(WORKED, None)
    assert layout_for(None) is WIDE
