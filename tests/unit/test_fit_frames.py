"""CNF-1 frames in, CNF-2 lines out; block-wise FIT."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.decoded import header_line
from snhc.reference_impl.interpolation.fit import evaluate, fit_from_json
from snhc.reference_impl.interpolation.fit_bulk import evaluate_sequence
from snhc.reference_impl.interpolation.frames_json import (
    FrameLine,
    faces_line,
    frame_from_json,
    read_frames,
    vertices_line,
)
from snhc.reference_impl.syntax.element import Readings

HEADER = '{"format":"snhc-decoded","version":1,"kind":"fba"}\n'
GOOD: dict[str, object] = {
    "index": 4,
    "time": "2/50",
    "intra": True,
    "faps": [None, None, 7, *[None] * 65],
    "viseme": {"select1": 3, "select2": 0, "blend": 63, "def": 0},
    "expression": None,
    "state": "TUR" + "U" * 65,
    "baps": [1],
}


def read(text: str | bytes, limit: int = 1 << 20) -> list[FrameLine]:
    stream = io.BytesIO(text) if isinstance(text, bytes) else io.StringIO(text)
    return list(read_frames(stream, limit=limit))


def test_frame() -> None:
    (frame,) = read(HEADER + "\n" + json.dumps(GOOD) + "\r\n")
    assert (frame.index, frame.time, frame.intra) == (4, "2/50", True)
    assert (frame.faps[2], frame.viseme, frame.expression) == (7, (3, 0, 63), None)
    assert json.loads(faces_line(frame)) == GOOD
    assert read(HEADER.encode() + json.dumps(GOOD).encode()) == [frame]


def test_faces_are_read_too_and_time_may_be_an_integer() -> None:
    (frame,) = read(HEADER.replace("fba", "faces") + json.dumps({**GOOD, "time": 3}))
    assert frame.time == "3"
    assert json.loads(vertices_line(frame, {}))["time"] == 3


CASES: list[tuple[dict[str, object], str, str]] = [
    ({"index": -1}, "RangeViolation", "index"),
    ({"index": "0"}, "InputFormat", "index"),
    ({"time": "1/0"}, "InputFormat", "time"),
    ({"time": "a"}, "InputFormat", "time"),
    ({"time": 1.5}, "InputFormat", "time"),
    ({"intra": 1}, "InputFormat", "intra"),
    ({"faps": [None] * 67}, "InconsistentSemantics", "faps"),
    ({"faps": [None, 3, *[None] * 66]}, "RangeViolation", "faps[1]"),
    ({"faps": [None, None, 1.5, *[None] * 65]}, "InputFormat", "faps[2]"),
    ({"faps": [None, None, 10**400, *[None] * 65]}, "InputFormat", "faps[2]"),
    ({"viseme": {"select1": 3, "select2": 0}}, "InputFormat", "viseme.blend"),
    ({"viseme": [1, 2, 3]}, "InputFormat", "viseme"),
    ({"expression": {"select1": True}}, "InputFormat", "expression.select1"),
    ({"state": "U" * 67}, "InconsistentSemantics", "state"),
    ({"state": "TUX" + "U" * 65}, "InputFormat", "state[2]"),
    ({"state": "TURT" + "U" * 64}, "InconsistentSemantics", "state[3]"),
    ({"viseme": None}, "InconsistentSemantics", "state[0]"),
    ({"state": "TTR" + "U" * 65}, "InconsistentSemantics", "state[1]"),
]


@pytest.mark.parametrize(("changes", "error_class", "path"), CASES)
def test_fault(changes: dict[str, object], error_class: str, path: str) -> None:
    with pytest.raises(SnhcError) as caught:
        read(HEADER + json.dumps(GOOD) + "\n\n" + json.dumps({**GOOD, **changes}))
    assert (caught.value.error_class, caught.value.path, caught.value.line) == (error_class, path, 4)


@pytest.mark.parametrize(
    ("text", "error_class", "line", "path"),
    [
        ("", "InputFormat", 1, ""),
        (json.dumps(GOOD), "InputFormat", 1, "format"),
        (HEADER.replace("1", "2"), "InputFormat", 1, "version"),
        (HEADER.replace("1", "true"), "InputFormat", 1, "version"),
        (HEADER.replace("fba", "mesh"), "InputFormat", 1, "kind"),
        (HEADER + "[1]", "InputFormat", 2, ""),
        (HEADER + "{", "InputFormat", 2, ""),
        ((HEADER + '{"a": "').encode() + b'\xff"}', "InputFormat", 2, ""),
        (HEADER + " " * 300, "ResourceLimit", 2, ""),
    ],
)
def test_stream_fault(text: str | bytes, error_class: str, line: int, path: str) -> None:
    with pytest.raises(SnhcError) as caught:
        read(text, limit=200)
    if error_class == "InputFormat" and path == "format":
        assert caught.value.error_class in ("InputFormat", "ResourceLimit")
    else:
        assert (caught.value.error_class, caught.value.path, caught.value.line) == (error_class, path, line)


def test_a_line_of_exactly_the_limit_is_read() -> None:
    line = json.dumps(GOOD)
    assert len(read(HEADER + line + "\r\n" + line, limit=len(line))) == 2
    with pytest.raises(SnhcError) as caught:
        read(HEADER + line + "\r\n", limit=len(line) - 1)
    assert caught.value.error_class == "ResourceLimit"


def test_lines_out() -> None:
    assert header_line("faces") == '{"format":"snhc-decoded","version":1,"kind":"faces"}'
    assert json.loads(header_line("faces", Readings({"AMB-FIT-1": "from-1"})))["readings"] == {"AMB-FIT-1": "from-1"}
    frame = frame_from_json(GOOD)
    points = np.array([[0.1, 1 / 3, -2.0]])
    assert vertices_line(frame, {"Face": points}) == (
        '{"index":4,"time":"2/50","meshes":{"Face":[[0.1,0.3333333333333333,-2.0]]}}'
    )
    with pytest.raises(SnhcError) as caught:
        vertices_line(frame, {"Face": np.array([[0.0, 0.0, np.inf]])})
    assert caught.value.path == "meshes.Face[0]"


def test_blocks_do_not_show() -> None:
    fit = fit_from_json(
        {
            "FAPs": [3, -1, 4, -1], "Graph": [0, 1], "numeratorTerms": [1], "denominatorTerms": [0],
            "numeratorExp": [2], "numeratorCoefs": [0.5],
        }
    )  # fmt: skip
    frames = [frame_from_json({**GOOD, "index": i, "faps": [None, None, i, *[None] * 65]}) for i in range(20)]
    wanted = [evaluate(fit, frame) for frame in frames]
    for block in (1, 3, 20, 100):
        assert list(evaluate_sequence(fit, frames, block=block)) == wanted
    assert list(evaluate_sequence(fit, [])) == []
