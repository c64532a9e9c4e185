"""The law that fuzzing holds, one input at a time; shared by the harness and by the replay of its findings."""

from __future__ import annotations

from fba_helpers import check_input, check_partition, traced
from strategies import written

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.systems.stream import Options, read_stream


def check_bytes(data: bytes) -> None:
    """Decode, trace, read and write back; also with the draft's start codes where there are any."""
    check_mode(data, Options())
    if b"\0\0\1\1" in data or b"\0\0\1\3" in data:
        check_mode(data, Options(draft=True))


def check_mode(data: bytes, options: Options) -> None:
    """The law under the given options."""
    error = check_input(data, options)
    if error is not None and error.error_class == "InputFormat":
        return
    try:
        items = read_stream(data, options)
    except SnhcError as fault:
        _, _, error = traced(data, options)
        assert error is not None
        assert fault.as_json() == error.as_json()
        return
    check_partition(data, options)
    assert written(items, options.draft) == data
