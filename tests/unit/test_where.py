"""Where a decoder went wrong: element, trace, symbols, bytes, curves, meshes, documents, foreign traces.

Rules: CNF-17, CNF-21, CNF-25.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import pytest
from click.testing import CliRunner

from snhc.conformance.adapters import Outcome
from snhc.conformance.cli import snhc
from snhc.conformance.results import Result
from snhc.conformance.running.case import Case, run_case
from snhc.reference_impl.systems.stream import trace_stream
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import SUITE, Entry, load

ENTRIES = {entry.id: entry for entry in load(check_schema=False).entries}


@dataclass(frozen=True, slots=True)
class Changed:
    """The reference decoder, with lines or end changed, in this process."""

    change: Callable[[list[dict[str, Any]]], Outcome | None]
    name: str = "changed"
    format: str = "ndjson"
    reproduce: str = "changed.toml"

    def lacks(self, entry: Entry) -> str:
        return ""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        second = aux.read_bytes() if aux else None
        decoded = decode_input(entry.media, path.read_bytes(), second, entry.options.for_decoder())
        frames = [json.loads(line) for line in decoded.lines]
        outcome = self.change(frames)
        if outcome is not None:
            return outcome
        text = "".join(json.dumps(frame) + "\n" for frame in frames).encode()
        said = json.dumps(decoded.error.as_json()).encode() if decoded.error is not None else b""
        return Outcome(1 if said else 0, text, said)

    def timed(self, seconds: float) -> Self:
        return self

    def close(self) -> None:
        return None


def result_of(id: str, change: Callable[[list[dict[str, Any]]], Outcome | None], traces: Path | None = None) -> Result:
    result = run_case(Case(Changed(change), ENTRIES[id]), SUITE, traces)
    assert result.status == "fail", result
    return result


def add(frame: int, *path: str | int, by: int = 1) -> Callable[[list[dict[str, Any]]], None]:
    """Add to one number of a line."""

    def change(frames: list[dict[str, Any]]) -> None:
        at: Any = frames[frame + 1]
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] += by

    return change


# -- streams -----------------------------------------------------------------------------------------------------------


def test_a_fap_leads_to_its_segment_its_symbol_and_its_bits() -> None:
    result = result_of("fap.arith.example.2", add(1, "faps", 47))
    assert result.location is not None and result.location.element == "fap_segment"
    trace = result.evidence["trace"]
    (marked,) = [row for row in trace if row.get("mark")]
    assert tuple(marked["bits"]) == result.location.bits and marked["rule"] == "FBA-28"
    assert trace.index(marked) >= 5 and len(trace) > trace.index(marked) + 1
    (symbol,) = [row for row in result.evidence["symbols"] if row["mark"]]
    assert symbol["label"] == "FAP 48 head_pitch"
    shown = result.evidence["bytes"]
    data = (SUITE / result.file).read_bytes()
    assert bytes.fromhex(shown["hex"]) == data[shown["first"] :][: len(shown["hex"]) // 2]
    assert shown["marks"] == [marked["bits"]]


def test_rows_of_the_excerpt_are_those_of_the_trace() -> None:
    result = result_of("fap.arith.example.4", lambda frames: _first_value(frames, 1))
    rows = [
        [part.trace.start[row], part.trace.end[row]]
        for part in trace_stream((SUITE / result.file).read_bytes())
        for row in range(len(part.trace))
    ]
    shown = [row["bits"] for row in result.evidence["trace"]]
    at = rows.index(shown[0])
    assert rows[at : at + len(shown)] == shown


def test_a_curve_holds_both_sides() -> None:
    result = result_of("fap.arith.model.adapts", add(40, "faps", 2, by=7))
    curve = result.evidence["curve"]
    assert (curve["fap"], curve["frame"]) == (3, 40)
    differing = [
        curve["first"] + i
        for i, (a, b) in enumerate(zip(curve["reference"], curve["candidate"], strict=True))
        if a != b
    ]
    assert differing == [40]


@pytest.mark.parametrize("frame", [0, 1])
def test_a_node_leads_to_its_vector_or_its_position(frame: int) -> None:
    id = "mesh.delaunay.concave" if frame == 0 else "mesh.motion.range.7"
    result = result_of(id, add(frame, "nodes", 4, 0, by=3))
    assert result.location is not None
    part = "geometry" if frame == 0 else "motion"
    assert result.location.path == f"plane[{frame}].{part}.node[4]"
    mesh = result.evidence["mesh"]
    assert mesh["marks"] == [4] and mesh["candidate"][4][0] == mesh["reference"][4][0] + 3
    assert mesh["triangles"] and mesh["frame"] == frame


def test_a_triangle_that_is_missing_is_drawn() -> None:
    def turned(frames: list[dict[str, Any]]) -> None:
        frames[1]["triangles"][0] = frames[1]["triangles"][0][::-1]

    result = result_of("mesh.delaunay.concave", turned)
    assert result.difference is not None and result.difference.what == "triangles"
    assert result.evidence["mesh"]["triangles"] != result.evidence["mesh"]["candidate_triangles"]


def test_a_dct_coefficient_is_found() -> None:
    result = result_of("fap.dct.example.1", lambda frames: _first_value(frames, 9))
    assert result.location is not None and result.location.element in ("dc", "dc_difference")
    assert result.difference is not None and result.location.path.endswith(f".fap[{result.difference.fap}]")


def _first_value(frames: list[dict[str, Any]], by: int) -> None:
    faps = frames[1]["faps"]
    faps[next(i for i, value in enumerate(faps) if value is not None)] += by


def test_a_wrong_class_and_place_stand_against_the_expected() -> None:
    id = "fba.error.time-code.hours-24"
    result = result_of(id, lambda _: Outcome(1, stderr=b'words\n{"class": "MarkerBit", "bits": [3, 4]}\n'))
    expect = ENTRIES[id].expect.as_json()["reject"]
    assert result.expected == {"outcome": "rejected", **expect}
    assert result.got["class"] == "MarkerBit" and result.got["bits"] == [3, 4] and "words" in result.got["stderr"]
    marked = next(row for row in result.evidence["trace"] if row.get("mark"))
    assert marked["bits"] == expect["bits"] and "ForbiddenValue" in marked["error"]


def test_a_valid_stream_that_is_rejected_shows_where_it_was() -> None:
    result = result_of("fap.arith.example.1", lambda _: Outcome(1, stderr=b'{"class": "MarkerBit", "bit": 111}'))
    assert result.expected == {"outcome": "accepted"}
    assert result.location is not None and result.location.bits == (111, 112)
    assert result.location.element == "marker_bit"


@pytest.mark.parametrize("bits", ["[0, 0]", "[99999999, 99999999999999]", "[5, 2]", "[-3, 4]"])
def test_odd_places_that_decoders_name_do_no_harm(bits: str) -> None:
    result = result_of("fap.arith.example.1", lambda _: Outcome(1, stderr=b'{"bits": %s}' % bits.encode()))
    assert result.got["outcome"] == "rejected"


# -- documents ---------------------------------------------------------------------------------------------------------


def test_documents_have_paths_for_what_differs() -> None:
    coefficients = result_of("dct.coefficients.example.1", lambda frames: _first_value(frames, 9))
    assert coefficients.difference is not None
    (place,) = coefficients.evidence["document"]["paths"]
    assert place["path"] == f"segments[0].coefficients.{coefficients.difference.fap}" and place["value"].startswith("[")

    table = json.loads((SUITE / ENTRIES["fat.interval.example"].file).read_text())["tables"][0]
    vertex = table["meshes"][0]["coordIndex"][0]

    def moved(frames: list[dict[str, Any]]) -> None:
        next(iter(frames[1]["meshes"].values()))[vertex][0] += 50.0

    vertices = result_of("fat.interval.example", moved)
    paths = [place["path"] for place in vertices.evidence["document"]["paths"]]
    assert any(path.startswith("tables[0].meshes[0].coordIndex[") for path in paths)
    assert vertices.evidence["document"]["frames_line"] == 2

    def another(frames: list[dict[str, Any]]) -> None:
        frame = frames[1]
        frame["faps"][frame["state"].index("F")] += 1

    filled = result_of("fit.state.from-fit", another)
    assert all(place["path"].startswith("FAPs[") for place in filled.evidence["document"]["paths"])


def test_documents_have_the_path_of_a_fault() -> None:
    result = result_of(
        "fit.error.fap-0", lambda _: Outcome(0, b'{"format":"snhc-decoded","version":1,"kind":"faces"}\n')
    )
    assert result.evidence["document"]["paths"] == [{"path": "FAPs[1]", "value": "0"}]


# -- traces of decoders ------------------------------------------------------------------------------------------------


@pytest.fixture
def traces(tmp_path: Path) -> Path:
    """The reference trace as the decoder's own, with one value changed behind the fourth element of plane 1."""
    source = SUITE / ENTRIES["fap.arith.example.1"].file
    done = CliRunner().invoke(snhc, ["dump", str(source), "--format", "json"])
    document = json.loads(done.stdout)
    plane = next(part for part in document["parts"] if part.get("plane", {}).get("index") == 1)
    plane["elements"][-1]["levels"][0] += 1
    (tmp_path / "fap.arith.example.1.json").write_text(json.dumps(document))
    return tmp_path


def test_the_first_element_on_which_traces_differ_is_named(traces: Path) -> None:
    found = result_of("fap.arith.example.1", add(1, "faps", 2), traces).evidence["divergence"]
    assert found["reference"]["element"] == "fap_segment" and found["reference"]["path"] == "plane[1].fap"
    assert found["reference"]["levels"] != found["candidate"]["levels"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not of the form"), ("[]", "not of the form"), ('{"parts": [{"elements": [{"element": 3}]}]}', "not of"),
        ("[" * 100_000, "not of the form"), ('{"parts": []}', None),
    ],
)  # fmt: skip
def test_traces_that_are_none_are_said(tmp_path: Path, text: str, said: str | None) -> None:
    (tmp_path / "changed").mkdir()
    (tmp_path / "changed" / "fap.arith.example.1.json").write_text(text)
    found = result_of("fap.arith.example.1", add(1, "faps", 2), tmp_path).evidence["divergence"]
    if said is None:
        # It has ended before it began.
        assert found["candidate"] is None and found["reference"]["element"] == "fba_object_start_code"
    else:
        assert said in found["fault"]


# -- again -------------------------------------------------------------------------------------------------------------


def test_the_command_that_shows_it_again_does(tmp_path: Path) -> None:
    harness = Path(__file__).parent.parent / "harness" / "wrong_value.py"
    adapter = tmp_path / "it's mine.toml"
    adapter.write_text(f'name = "dec"\ncommand = ["{sys.executable}", "{harness}", "{{input}}"]\n')
    report = tmp_path / "r.json"
    run = [sys.executable, "-m", "snhc.conformance.cli"]
    words = ["run", str(adapter), "--filter", "fap.arith.example.*", "-o", str(report), "--timeout", "20"]
    words += ["--reading", "AMB-FBA-6=before"]
    assert subprocess.run([*run, *words], check=False).returncode == 1
    failing = [r for r in json.loads(report.read_text())["results"] if r["status"] == "fail"][1]
    program, *again = shlex.split(failing["reproduce"])
    assert program == "snhc" and "--timeout 20 --reading AMB-FBA-6=before" in failing["reproduce"]
    done = subprocess.run([*run, *again], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and failing["vector"] in done.stdout and failing["reason"] in done.stdout
    assert "1 fail" in done.stdout
