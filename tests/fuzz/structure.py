"""Mutations that know what a stream is made of: other values in its records, other bits in one of its elements.

A stream that decodes is read into its records; something in them is changed, and the faulty writer writes them. So
inputs get past start codes, markers and masks, where changed bytes are mostly refused.
"""

from __future__ import annotations

from random import Random

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.syntax.element import ELEMENTS
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import read_stream, write_faulty
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem

_NAMES = sorted({element.name for element in ELEMENTS})
TRIES = 6
# What readers of text repeat on: blanks, digits, signs, quotes, brackets, letters, and the bytes that end something.
UNITS = (
    b" ", b"\n", b"\r", b"\t", b",", b"0", b"1", b"9", b".", b"-", b"+", b"e", b"E5", b"a", b"_", b'"', b"'", b"\\",
    b"[", b"]", b"{", b"}", b"(", b")", b"[]", b"{}", b"#", b"#\n", b"\0", b"\xff", b"\x80", b"\xc3\xa9", b"1 ", b"1\n",
    b'"",', b'"a":1,', b"1,", b"/", b"!", b"&&", b"*", b".a", b":",
)  # fmt: skip
_MODES = ("wire", "value", "flip", "guard", "tail", "cut", "word")


def mutated(data: bytes, rng: Random) -> bytes:
    """The stream with some of its structure changed; the data as it is where that cannot be."""
    for _ in range(TRIES):
        try:
            items = read_stream(data)
        except SnhcError:
            return data
        try:
            for _ in range(rng.choice((0, 1, 1, 2, 4))):
                _change(items, rng)
            faults = [_mutation(rng) for _ in range(rng.choice((0, 1, 1, 2, 3)))]
            out = write_faulty(items, faults)
        except SnhcError:
            continue  # what came out cannot be written
        except (IndexError, ValueError, OverflowError, AssertionError, TypeError, AttributeError, KeyError):
            # Records that no reader makes may be more than a writer can say; it is the readers that are tested here.
            continue
        if out != data:
            return out
    return data


def pumped(data: bytes, rng: Random, size: int) -> bytes:
    """An input with one part of it repeated until it is `size` bytes long, and something before it and behind it.

    What costs more than its length shows in inputs that are long and the same all over, which small mutations of small
    inputs never become.
    """
    at = rng.randrange(len(data) + 1)
    length = rng.choice((1, 1, 2, 3, 8, 40))
    unit = rng.choice(UNITS) if rng.random() < 0.6 else data[at : at + length] or b" "
    times = max(1, (size - len(data)) // len(unit))
    behind = data[at + (rng.choice((0, 1, length))) :] if rng.random() < 0.7 else rng.choice((b"", b"x", b"\n"))
    return data[:at] + unit * times + behind


def _mutation(rng: Random) -> Mutation:
    mode = rng.choice(_MODES)
    to = rng.choice((0, 1, rng.getrandbits(3), rng.getrandbits(8), rng.getrandbits(16)))
    return Mutation(
        rng.choice(_NAMES), mode, to, "", rng.choice((0, 0, 1, 3, rng.getrandbits(5))), rng.randrange(1, 17)
    )


def _planes(items: list[StreamItem]) -> list[list[AnyPlane]]:
    return [
        *(item.fba.planes for item in items if item.fba is not None),
        *(item.mesh.planes for item in items if item.mesh is not None),
    ]  # type: ignore[list-item]


def _change(items: list[StreamItem], rng: Random) -> None:
    lists = [planes for planes in _planes(items) if planes]
    if not lists:
        return
    planes = rng.choice(lists)
    place = rng.randrange(len(planes))
    how = rng.randrange(5)
    if how == 0 and len(planes) > 1:
        del planes[place]
    elif how == 1 and len(planes) < 12:
        # The same record twice would be changed twice; a writer only reads it.
        planes.insert(rng.randrange(len(planes) + 1), planes[place])
    else:
        _in_record(planes[place], rng, 0)


def _in_record(record: object, rng: Random, depth: int) -> None:
    """One number somewhere below a record, a little or far off."""
    names = [name for name in getattr(type(record), "__slots__", ()) or _fields(record) if name not in ("frames",)]
    rng.shuffle(names)
    for name in names:
        value = getattr(record, name, None)
        if isinstance(value, bool) or value is None:
            continue
        if isinstance(value, int):
            setattr(record, name, _other(value, rng))
            return
        if isinstance(value, list) and value:
            place = rng.randrange(len(value))
            if isinstance(value[place], int):
                value[place] = _other(value[place], rng)
                return
            if isinstance(value[place], list) and value[place]:
                inner = value[place]
                at = rng.randrange(len(inner))
                if isinstance(inner[at], int):
                    inner[at] = _other(inner[at], rng)
                    return
            elif depth < 3:
                _in_record(value[place], rng, depth + 1)
                return
        elif depth < 3 and type(value).__module__.startswith("snhc"):
            _in_record(value, rng, depth + 1)
            return


def _fields(record: object) -> list[str]:
    # Compiled records have no slots to list.
    return [
        name for name in dir(type(record)) if not name.startswith("_") and not callable(getattr(record, name, None))
    ]


def _other(value: int, rng: Random) -> int:
    return rng.choice((value + 1, value - 1, -value, 0, value ^ 1, value + rng.randrange(-40, 41), rng.getrandbits(6)))
