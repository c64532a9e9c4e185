"""Sources of bytes: memory, files by position, pipes spooled as far as asked (CNF-19, CNF-22)."""

from __future__ import annotations

import io
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, cast

import pytest
from fba_helpers import SAMPLES, decoded, traced
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.source import (
    BytesSource,
    FileSource,
    PipeSource,
    Source,
    SourceChanged,
    open_source,
)
from snhc.reference_impl.systems.stream import decode_planes

DATA = bytes(i * 7 & 0xFF for i in range(200_000))
SAMPLE = (SAMPLES / "fba" / "fba-11-00013" / "input.fba").read_bytes()


class Trickle(io.RawIOBase):
    """A pipe that hands over a few bytes at a time; counts them."""

    def __init__(self, data: bytes, step: int) -> None:
        self._data = data
        self._step = step
        self.given = 0

    def readable(self) -> bool:
        return True

    def read1(self, count: int = -1) -> bytes:
        out = self._data[self.given : self.given + self._step]
        self.given += len(out)
        return out


def _file(tmp_path: Path, data: bytes) -> BinaryIO:
    path = tmp_path / "data"
    path.write_bytes(data)
    return path.open("rb")


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    asked=st.lists(st.tuples(st.integers(0, 210_000), st.integers(0, 70_000)), max_size=8), step=st.integers(50, 9_999)
)
def test_all_sources_are_alike(tmp_path: Path, asked: list[tuple[int, int]], step: int) -> None:
    with _file(tmp_path, DATA) as file:
        sources: list[Source] = [
            BytesSource(DATA), FileSource(file), PipeSource(cast(BinaryIO, Trickle(DATA, step))),
            PipeSource(io.BytesIO(DATA)),
        ]  # fmt: skip
        for offset, count in asked:
            for source in sources:
                assert source.read_at(offset, count) == DATA[offset : offset + count]
        for source in sources:
            assert source.size() == len(DATA)
            assert source.read_at(len(DATA), 5) == b""


def test_a_pipe_is_not_read_further_than_asked() -> None:
    pipe = Trickle(DATA, 1_000)
    source = PipeSource(cast(BinaryIO, pipe))
    source.read_at(0, 10_000)
    assert pipe.given == 10_000
    source.read_at(5_000, 100)
    assert pipe.given == 10_000


def test_a_pipe_without_read1() -> None:
    class Plain:
        def __init__(self) -> None:
            self._file = io.BytesIO(DATA)

        def read(self, count: int) -> bytes:
            return self._file.read(count)

    assert PipeSource(cast(BinaryIO, Plain())).read_at(100_000, 10) == DATA[100_000:100_010]


def test_a_file_that_shrinks_is_an_io_error(tmp_path: Path) -> None:
    with _file(tmp_path, DATA) as file:
        source = FileSource(file)
        os.truncate(tmp_path / "data", 1_000)
        assert source.read_at(0, 1_000) == DATA[:1_000]
        with pytest.raises(SourceChanged) as caught:
            source.read_at(500, 1_000)
        assert isinstance(caught.value, OSError)
        assert "1000" in str(caught.value)


def test_which_source_for_what(tmp_path: Path) -> None:
    with _file(tmp_path, DATA) as file:
        assert isinstance(open_source(file), FileSource)
        file.seek(10)
        # Partly consumed: goes on from where it is, like a pipe.
        source = open_source(file)
        assert isinstance(source, PipeSource)
        assert source.read_at(0, 5) == DATA[10:15]
    source = open_source(io.BytesIO(DATA))
    assert isinstance(source, PipeSource)
    assert source.size() == len(DATA)


@pytest.mark.parametrize("step", [1, 7, 4_096])
def test_streams_decode_alike_from_any_source(tmp_path: Path, step: int) -> None:
    wanted = decoded(SAMPLE)
    make: list[Callable[[], Source]] = [lambda: PipeSource(cast(BinaryIO, Trickle(SAMPLE, step)))]
    with _file(tmp_path, SAMPLE) as file:
        make.append(lambda: FileSource(file))
        for source in make:
            assert decoded(source()) == wanted
            assert traced(source()) == traced(SAMPLE)


def test_planes_come_out_before_a_pipe_ends() -> None:
    """A live producer: the first planes are given out while the pipe is still open (CNF-22)."""
    # A segment's look-ahead wants 2 KiB of data before its plane comes out.
    reading, writing = os.pipe()
    stream = SAMPLE[:-4]
    got = threading.Event()

    def produce() -> None:
        with os.fdopen(writing, "wb", buffering=0) as pipe:
            pipe.write(stream + b"\xff" * 3_000)
            got.wait(timeout=30)

    producer = threading.Thread(target=produce)
    producer.start()
    with os.fdopen(reading, "rb") as pipe:
        planes = decode_planes(open_source(pipe))
        first = next(planes)
        got.set()
        assert first.frames[0].index == 0
        planes.close()
        producer.join(timeout=30)
    assert not producer.is_alive()
