"""Decoders whose output is wrong in one way, by name: `mutants.py INPUT NAME`.

Each is a function from the right lines (header first) to wrong ones; rejections are right.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

from _shared import answer, finish

Lines = list[str]
Frame = dict[str, Any]
MUTANTS: dict[str, Callable[[Lines], Lines]] = {}


def _lines(mutant: Callable[[Lines], Lines]) -> Callable[[Lines], Lines]:
    MUTANTS[mutant.__name__] = mutant
    return mutant


def _frames(mutant: Callable[[list[Frame]], object]) -> Callable[[list[Frame]], object]:
    """From the frames, which it changes."""

    def change(lines: Lines) -> Lines:
        frames = [json.loads(line) for line in lines[1:]]
        if frames:
            mutant(frames)
        return [lines[0], *(json.dumps(frame) + "\n" for frame in frames)]

    MUTANTS[mutant.__name__] = change
    return mutant


def _header(lines: Lines, **changes: object) -> Lines:
    return [json.dumps({**json.loads(lines[0]), **changes}) + "\n", *lines[1:]]


@_lines
def header_only(lines: Lines) -> Lines:
    return lines[:1]


@_lines
def no_header(lines: Lines) -> Lines:
    return lines[1:]


@_lines
def header_last(lines: Lines) -> Lines:
    return [*lines[1:], lines[0]]


@_lines
def two_headers(lines: Lines) -> Lines:
    return [lines[0], *lines]


@_lines
def wrong_kind(lines: Lines) -> Lines:
    return _header(lines, kind="mesh")


@_lines
def wrong_version(lines: Lines) -> Lines:
    return _header(lines, version=2)


@_lines
def version_is_true(lines: Lines) -> Lines:
    return _header(lines, version=True)


@_lines
def duplicated_frame(lines: Lines) -> Lines:
    return [*lines[:2], *lines[1:]]


@_lines
def reversed_frames(lines: Lines) -> Lines:
    return [lines[0], *reversed(lines[1:])]


@_lines
def byte_order_mark(lines: Lines) -> Lines:
    return ["\ufeff" + lines[0], *lines[1:]]


@_lines
def blank_lines(lines: Lines) -> Lines:
    return [line + "\n" for line in lines]


@_lines
def cut_in_a_line(lines: Lines) -> Lines:
    return [*lines[:-1], lines[-1][: len(lines[-1]) // 2]]


@_lines
def words_behind(lines: Lines) -> Lines:
    return [*lines, "decoded without errors\n"]


@_lines
def one_json_list(lines: Lines) -> Lines:
    return [json.dumps([json.loads(line) for line in lines])]


@_frames
def late_by_one(frames: list[Frame]) -> None:
    values = [frame["faps"] for frame in frames]
    for frame, before in zip(frames[1:], values, strict=False):
        frame["faps"] = before


@_frames
def wrong_index(frames: list[Frame]) -> None:
    for number, frame in enumerate(frames, 1):
        frame["index"] = number


@_frames
def wrong_time(frames: list[Frame]) -> None:
    frames[-1]["time"] = "1001/30000"


@_frames
def times_as_numbers(frames: list[Frame]) -> None:
    for frame in frames:
        frame["time"] = 0.0


@_frames
def wrong_intra(frames: list[Frame]) -> None:
    for frame in frames:
        frame["intra"] = True


@_frames
def intra_is_1(frames: list[Frame]) -> None:
    for frame in frames:
        frame["intra"] = int(frame["intra"])


@_frames
def fap_too_late(frames: list[Frame]) -> None:
    # Right values, each at the next FAP.
    for frame in frames:
        frame["faps"] = [None, *frame["faps"][:-1]]


@_frames
def negated(frames: list[Frame]) -> None:
    for frame in frames:
        frame["faps"] = [value if value is None else -value for value in frame["faps"]]


@_frames
def strings_for_values(frames: list[Frame]) -> None:
    for frame in frames:
        frame["faps"] = [value if value is None else str(value) for value in frame["faps"]]


@_frames
def zero_for_null(frames: list[Frame]) -> None:
    for frame in frames:
        frame["faps"] = [value or 0 for value in frame["faps"]]


@_frames
def huge_value(frames: list[Frame]) -> None:
    frames[-1]["faps"][2] = 10**400


@_lines
def value_of_many_digits(lines: Lines) -> Lines:
    # Beyond what Python reads as an int.
    return [*lines[:-1], lines[-1].replace('"faps":[null,null,', '"faps":[null,null,1' + "0" * 5000 + ",", 1)]


@_frames
def values_of_67_faps(frames: list[Frame]) -> None:
    for frame in frames:
        del frame["faps"][-1]


@_frames
def no_state(frames: list[Frame]) -> None:
    for frame in frames:
        del frame["state"]


@_frames
def lower_case_state(frames: list[Frame]) -> None:
    for frame in frames:
        frame["state"] = frame["state"].lower()


@_frames
def viseme_out_of_nowhere(frames: list[Frame]) -> None:
    frames[-1]["viseme"] = {"select1": 1, "select2": 0, "blend": 0, "def": 0}


@_frames
def flags_for_numbers(frames: list[Frame]) -> None:
    # Equal in Python, another value in JSON.
    for frame in frames:
        for key in ("gender", "coding_type", "fap_quant"):
            if frame.get(key) in (0, 1):
                frame[key] = bool(frame[key])


if __name__ == "__main__":
    given, said, code = answer()
    finish(MUTANTS[sys.argv[2]](given) if code == 0 else given, said, code)
