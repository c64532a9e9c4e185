"""Policies: what they find and where, and what is no policy.

Rules: CNF-19, CNF-23, CNF-25.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from snhc.analyzer.policy import check_policy, load_policy
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import trace_stream, write_stream
from snhc.vectors.builders import inter, intra, stream

QUANT = """
[[rule]]
id = "quantiser"
expression = 'name == "fap_quant" && value > 15'
message = "fap_quant is {value}, {bits} bits in plane {plane}"
severity = "warning"
"""
TIMED = """
[[rule]]
id = "has-time-code"
expression = 'name == "time_code_hours"'
message = "no plane carries a time code"
expect = "some"
rule = "FBA-7"
"""


def speech(quant: int, time: tuple[int, int, int] | None = None) -> bytes:
    first = intra({3: 1, 48: 2}, quant=quant, time=time)
    return write_stream(stream(first, inter(first, {3: 1}), intra({3: 1}, quant=quant)))


def found(tmp_path: Path, policy: str, data: bytes) -> list[Finding]:
    file = tmp_path / "policy.toml"
    file.write_text(policy)
    out: list[Finding] = []
    check_policy(BytesSource(data), load_policy(file), out.append)
    return out


def run(*args: object) -> Result:
    return CliRunner().invoke(snhc, ["check", *map(str, args)])


def test_what_is_taken_is_a_finding_at_its_bits(tmp_path: Path) -> None:
    data = speech(16)
    spans = [
        (part.trace.start[row], part.trace.end[row], part.plane.frames[0].index)
        for part in trace_stream(data)
        for row in range(len(part.trace))
        if part.trace.el(row).name == "fap_quant" and part.plane is not None
    ]
    findings = found(tmp_path, QUANT, data)
    assert [(f.bits, f.message) for f in findings] == [
        ((start, end), f"fap_quant is 16, 5 bits in plane {plane}") for start, end, plane in spans
    ]
    assert len(findings) == 2
    assert {(f.id, f.severity, f.rule) for f in findings} == {("policy.quantiser", "warning", "FBA-9")}
    assert findings[0].path == "plane[0].fap.fap_quant"
    assert found(tmp_path, QUANT, speech(15)) == []


def test_what_must_be_there(tmp_path: Path) -> None:
    data = speech(1)
    (missing,) = found(tmp_path, TIMED, data)
    assert (missing.id, missing.severity, missing.rule) == ("policy.has-time-code", "error", "FBA-7")
    assert missing.bits == (0, 8 * len(data))
    assert found(tmp_path, TIMED, speech(1, (1, 2, 3))) == []


def test_planes_and_symbols(tmp_path: Path) -> None:
    planes = '[[rule]]\nid = "size"\nexpression = "kind == \'plane\' && bits > 60"\nmessage = "{name} {plane}"\n'
    assert {f.path for f in found(tmp_path, planes, speech(1))} == {"plane[0]", "plane[2]"}
    symbols = '[[rule]]\nid = "s"\nexpression = "kind == \'symbol\' && value == 2"\nmessage = "{name}: {value}"\n'
    assert found(tmp_path, symbols, speech(1)) == []
    (one,) = found(tmp_path, "symbols = true\n" + symbols, speech(1))
    assert one.message == "FAP 48 head_pitch: 2"


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("", "rule"),
        ("x = 1", "x"),
        ("rule = 1", "rule"),
        ("rule = [1]", "rule[0]"),
        ('name = 1\n[[rule]]\nid = "a"', "name"),
        ('[[rule]]\nid = "a"\nexpression = "true"', "rule[0].message"),
        ('[[rule]]\nid = "A b"\nexpression = "true"\nmessage = ""', "rule[0].id"),
        (QUANT + QUANT, "rule[1].id"),
        (QUANT.replace("warning", "fatal"), "rule[0].severity"),
        (QUANT + 'expect = "all"', "rule[0].expect"),
        (QUANT + 'rule = "FBA-999"', "rule[0].rule"),
        (QUANT.replace("{value}", "{valeu}"), "rule[0].message"),
        (TIMED.replace("no plane", "{plane}"), "rule[0].message"),
        (QUANT.replace("value > 15", "valeu > 15"), "rule[0].expression"),
        (QUANT.replace("value > 15", "value >"), "rule[0].expression"),
        (QUANT + "colour = 1", "rule[0].colour"),
        ("[[rule", ""),
        ("\xff", ""),
    ],
)
def test_what_is_no_policy_says_where(tmp_path: Path, text: str, path: str) -> None:
    file = tmp_path / "policy.toml"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputFormat) as caught:
        load_policy(file)
    assert (caught.value.path or "") == path
    stream_file = tmp_path / "a.fba"
    stream_file.write_bytes(speech(1))
    result = run(stream_file, "--policy", file)
    assert result.exit_code == 3
    assert "Traceback" not in result.output


def test_the_verb(tmp_path: Path) -> None:
    policy, timed, data, text = (tmp_path / name for name in ("p.toml", "t.toml", "a.fba", "a.fap"))
    policy.write_text(QUANT)
    timed.write_text(TIMED)
    data.write_bytes(speech(16))
    text.write_text("2.1 x 25 0\n")
    result = run(data, "--policy", policy)
    assert result.exit_code == 0, "a warning"
    assert result.stdout.count("policy.quantiser") == 2
    assert run(data, "--policy", policy, "--fail-on", "warning").exit_code == 1
    result = run(data, "--policy", policy, "--policy", timed, "--format", "json")
    assert result.exit_code == 1
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert [line["id"] for line in lines if line["id"].startswith("policy.")] == [
        "policy.quantiser", "policy.quantiser", "policy.has-time-code",
    ]  # fmt: skip
    assert run(text, "--policy", policy).exit_code == 2
    assert run(data, "--policy", tmp_path / "gone").exit_code == 3


def test_the_policy_of_the_docs_is_one(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "check.md").read_text()
    file = tmp_path / "box.toml"
    file.write_text(page.partition("```toml\n")[2].partition("```")[0])
    assert [rule.id for rule in load_policy(file).rules] == ["quantiser", "has-time-code"]
