"""The ledger of known failures.

Rules: CNF-15, CNF-25.
"""

from __future__ import annotations

import json
import sys
import tomllib
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import CliRunner

from snhc.conformance.cli.run import command
from snhc.conformance.compare import BAD, STATUSES
from snhc.conformance.ledger import EXCUSABLE, SCHEMA_FILE, Entry, Ledger, draft, load
from snhc.conformance.results import Report, Result
from snhc.reference_impl.bitstream.errors import InputFormat

TODAY = date(2026, 6, 15)
SUITE = ["a.b.one", "a.b.two", "a.c"]


def entry(**more: Any) -> Entry:
    fields: dict[str, Any] = {
        "vectors": "a.b.*", "adapter": "dec*", "reason": "why", "link": "https://x.org/1",
        "expires": TODAY + timedelta(1),
    }  # fmt: skip
    return Entry(**{**fields, **more})


def one(status: str, vector: str = "a.b.one", adapter: str = "decoder") -> Result:
    return Result(
        adapter, vector, "t", "syntax", "valid", "f", ("fba",), ("FBA-1",), status, "because", "", 0.0, None, None,
        "snhc run",
    )  # fmt: skip


def applied(ledger: Ledger, *results: Result, today: date = TODAY) -> Report:
    adapters = tuple(dict.fromkeys(result.adapter for result in results))
    return ledger.apply(Report("0.0.0", "", adapters, results), SUITE, today)


@pytest.mark.parametrize("status", STATUSES)
def test_what_each_status_becomes(status: str) -> None:
    (result,) = applied(Ledger((entry(),)), one(status)).results
    wanted = "xfail" if status in EXCUSABLE else "xpass" if status == "pass" else status
    assert result.status == wanted
    assert result.known is not None and (result.known.status, result.known.link) == (status, "https://x.org/1")


def test_other_vectors_and_decoders_stay_what_they_are() -> None:
    results = (one("fail", "a.c"), one("fail", adapter="other"))
    assert applied(Ledger((entry(),)), *results).results == results


@pytest.mark.parametrize(("days", "status"), [(-1, "fail"), (0, "xfail"), (1, "xfail")])
def test_the_last_day_still_excuses(days: int, status: str) -> None:
    report = applied(Ledger((entry(expires=TODAY + timedelta(days)),)), one("fail"))
    assert report.results[0].status == status
    assert [note.kind for note in report.notes] == (["expired"] if status == "fail" else [])
    assert report.results[0].known is not None and report.results[0].known.expired == (status == "fail")


def test_a_pass_under_an_expired_entry_is_a_pass() -> None:
    report = applied(Ledger((entry(expires=date(2020, 1, 1)),)), one("pass"))
    assert report.results[0].status == "pass" and report.exit_code == 0


def test_a_failure_of_another_kind_is_not_excused() -> None:
    results = applied(Ledger((entry(statuses=("fail",)),)), one("crash"), one("fail", "a.b.two")).results
    assert [result.status for result in results] == ["crash", "xfail"]


def test_the_first_entry_that_is_alive_counts() -> None:
    ledger = Ledger((entry(expires=date(2020, 1, 1), reason="old"), entry(statuses=("crash",)), entry(reason="third")))
    (result,) = applied(ledger, one("fail")).results
    assert result.status == "xfail" and result.known is not None and result.known.reason == "third"


def test_verdicts() -> None:
    ledger = Ledger((entry(),))
    assert applied(ledger, one("fail"), one("pass", "a.c")).exit_code == 0
    # Nothing but known failures is no pass, and a known failure that passes is bad.
    assert applied(ledger, one("fail")).exit_code == 1
    assert applied(ledger, one("pass"), one("pass", "a.c")).exit_code == 1
    assert "xpass" in BAD and "xfail" not in BAD


def test_entries_that_fit_nothing_are_said() -> None:
    ledger = Ledger((entry(vectors="no.such"), entry(adapter="other"), entry(vectors="x|a.c")))
    notes = applied(ledger, one("pass")).notes
    assert [(note.kind, note.message) for note in notes] == [
        ("unmatched", "fits no vector of the suite"),
        ("unmatched", "fits no decoder of the run"),
    ]


GOOD = """[[known]]
vectors = "a"
adapter = "b"
reason = "c"
link = "https://d"
expires = 2030-01-01
"""


def test_a_ledger_reads(tmp_path: Path) -> None:
    path = tmp_path / "l.toml"
    path.write_text(GOOD + 'statuses = ["crash"]\n')
    assert load(path).entries == (Entry("a", "b", "c", "https://d", date(2030, 1, 1), ("crash",)),)
    path.write_text("")
    assert load(path).entries == ()


@pytest.mark.parametrize(
    ("old", "new", "path"),
    [
        ('vectors = "a"\n', "", "$.known[0]"),
        ('reason = "c"', 'reason = ""', "$.known[0].reason"),
        ('link = "https://d"', 'link = ""', "$.known[0].link"),
        ('link = "https://d"', 'link = "see the wiki"', "$.known[0].link"),
        ("expires = 2030-01-01", 'expires = "soon"', "$.known[0].expires"),
        ("expires = 2030-01-01", 'expires = "2030-02-31"', "$.known[0].expires"),
        ("expires = 2030-01-01", "expires = 2030-01-01T10:00:00", "$.known[0].expires"),
        ("expires = 2030-01-01", 'expires = 2030-01-01\nstatuses = ["pass"]', "$.known[0].statuses[0]"),
        ("expires = 2030-01-01", "expires = 2030-01-01\nsurprise = 1", "$.known[0]"),
        ("[[known]]", "[known]", "$.known"),
        ("[[known]]", "[[known", ""),
    ],
)
def test_a_wrong_ledger_is_refused_with_the_place(tmp_path: Path, old: str, new: str, path: str) -> None:
    file = tmp_path / "l.toml"
    assert old in GOOD
    file.write_text(GOOD.replace(old, new))
    with pytest.raises(InputFormat) as caught:
        load(file)
    assert caught.value.path == path


def test_a_draft_holds_each_failure_and_waits_for_links(tmp_path: Path) -> None:
    evil = 'quote " backslash \\ \x1b[2J \n newline'
    results = [one("fail", 'a."b'), one("crash"), one("pass", "a.c"), one("xfail", "a.d"), one("error", "e", evil)]
    path = tmp_path / "draft.toml"
    path.write_text(draft(results, TODAY))
    with pytest.raises(InputFormat):
        load(path)
    path.write_text(path.read_text().replace('link = ""', 'link = "https://x"'))
    entries = load(path).entries
    assert [(e.vectors, e.statuses) for e in entries] == [
        ('a."b', ("fail",)),
        ("a.b.one", ("crash",)),
        ("e", ("error",)),
    ]
    assert {e.expires for e in entries} == {TODAY + timedelta(90)}
    jsonschema.Draft202012Validator.check_schema(json.loads(SCHEMA_FILE.read_text()))
    assert tomllib.loads(path.read_text())


def test_the_command_excuses_drafts_and_tells(tmp_path: Path) -> None:
    harness = Path(__file__).parent.parent / "harness" / "wrong_value.py"
    adapter = tmp_path / "a.toml"
    adapter.write_text(f'name = "dec"\ncommand = ["{sys.executable}", "{harness}", "{{input}}"]\n')
    words = [str(adapter), "--filter", "fap.arith.example.1|fba.error.time-code.hours-24"]
    drafted = tmp_path / "draft.toml"
    first = CliRunner().invoke(command, [*words, "--draft-ledger", str(drafted)])
    assert first.exit_code == 1 and drafted.read_text().count("[[known]]") == 1
    drafted.write_text(drafted.read_text().replace('link = ""', 'link = "https://x"'))
    second = CliRunner().invoke(command, [*words, "--ledger", str(drafted), "--format", "json"])
    assert second.exit_code == 0, second.output
    statuses = {r["vector"]: r["status"] for r in json.loads(second.stdout)["results"]}
    assert statuses == {"fap.arith.example.1": "xfail", "fba.error.time-code.hours-24": "pass"}
    drafted.write_text(GOOD)
    third = CliRunner().invoke(command, [*words, "--ledger", str(drafted)])
    assert third.exit_code == 1 and "ledger: a [b]: fits no vector of the suite" in third.stdout
