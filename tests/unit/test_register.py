"""The rule register: complete, consistent, quick to ask; one located error for a file that breaks its form.

Rules: CNF-8, CNF-23, CNF-24.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest

from snhc.reference_impl import rules as register
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.findings import SEVERITIES
from snhc.reference_impl.rules.register import REGISTER

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

# The ids of the specification. They are permanent: this table only grows.
IDS = {
    "FBA": (*range(1, 45), *range(50, 55)),
    "DCT": tuple(range(1, 16)),
    "MSH": (*range(1, 26), *range(30, 42)),
    "FIT": tuple(range(1, 10)),
    "FAT": tuple(range(1, 12)),
    "FAC": (*range(1, 8), *range(10, 15), *range(20, 26), *range(30, 35), 40, 41),
    "SYS": tuple(range(1, 63)),
    "TTS": tuple(range(1, 7)),
    "CNF": tuple(range(1, 27)),
}
AMBIGUITIES = {"FBA": 12, "DCT": 6, "MSH": 4, "FIT": 3, "FAT": 4, "FAC": 5, "TTS": 1, "SYS": 12}
# Keys that users type: first = followed.
KEYS = {
    "AMB-FBA-1": ["lowest-first", "highest-first"],
    "AMB-FBA-2": ["table", "wide"],
    "AMB-FBA-3": ["rederived", "kept"],
    "AMB-FBA-4": ["none", "clip"],
    "AMB-FBA-5": ["base_step", "variant_b"],
    "AMB-FBA-6": ["after", "before"],
    "AMB-FBA-7": ["header", "bare"],
    "AMB-FBA-8": ["accept", "error", "plane-data"],
    "AMB-FBA-9": ["padding", "planes"],
    "AMB-DCT-1": ["3", "4"],
    "AMB-DCT-2": ["orthonormal", "unnormalised"],
    "AMB-DCT-3": ["unscaled", "scaled"],
    "AMB-DCT-4": ["none", "sent"],
    "AMB-DCT-5": ["segments", "fba-28"],
    "AMB-MSH-1": ["checkerboard", "by-column", "by-row"],
    "AMB-MSH-2": ["fan", "other"],
}


def test_every_rule_of_the_specification_is_there_and_no_other() -> None:
    assert list(IDS) == list(register.AREAS)
    expected = {f"{area}-{number}" for area, numbers in IDS.items() for number in numbers}
    assert set(register.rules()) == expected


def test_every_rule_is_a_statement_with_a_label() -> None:
    for entry in register.rules().values():
        assert len(entry.statement) >= 40, entry.id
        assert entry.statement.endswith("."), entry.id
        assert "\n" not in entry.statement, entry.id
        assert entry.confidence in register.CONFIDENCES, entry.id
        assert entry.title.strip(), entry.id
        assert entry.source.strip(), entry.id
    statements = [entry.statement for entry in register.rules().values()]
    assert len(set(statements)) == len(statements)


def test_titles_are_unique() -> None:
    titles = [entry.title for entry in register.rules().values()]
    assert sorted({title for title in titles if titles.count(title) > 1}) == []


def test_every_ambiguity_of_the_specification_is_there() -> None:
    expected = {f"AMB-{area}-{n}" for area, count in AMBIGUITIES.items() for n in range(1, count + 1)}
    assert set(register.ambiguities()) == expected


def test_rules_and_ambiguities_name_each_other() -> None:
    from_rules = {(a, entry.id) for entry in register.rules().values() for a in entry.ambiguities}
    from_ambiguities = {(entry.id, r) for entry in register.ambiguities().values() for r in entry.rules}
    assert from_rules == from_ambiguities
    assert {a for a, _ in from_rules} == set(register.ambiguities())


@pytest.mark.parametrize("ambiguity_id", KEYS)
def test_reading_keys_are_permanent(ambiguity_id: str) -> None:
    entry = register.ambiguity(ambiguity_id)
    assert list(entry.readings) == KEYS[ambiguity_id]
    assert entry.followed == KEYS[ambiguity_id][0]


def test_every_rule_that_statements_name_exists() -> None:
    texts = {entry.id: entry.statement + entry.note for entry in register.rules().values()}
    texts |= {e.id: e.why + "".join(e.readings.values()) for e in register.ambiguities().values()}
    texts |= {e.id: e.description for e in register.findings().values()}
    for entry_id, text in texts.items():
        for named in re.findall(r"(?<!AMB-)\b(?:FBA|DCT|MSH|FIT|FAT|FAC|SYS|TTS|CNF)-\d+", text):
            assert named in register.rules(), f"{entry_id} names {named}"


def test_every_finding_that_a_statement_names_is_registered() -> None:
    for entry in register.rules().values():
        for named in re.findall(r"\bfindings? ([a-z]+(?:-[a-z0-9]+)+)", entry.statement):
            assert named in register.findings(), f"{entry.id} names {named}"


def test_findings_are_measured_by_a_rule() -> None:
    for kind in register.findings().values():
        assert kind.rule in register.rules(), kind.id
        assert kind.severity in SEVERITIES
        assert kind.description.endswith("."), kind.id
    assert register.finding("no-end-code").rule == "FBA-1"


def test_ambiguities_that_the_decoder_can_switch_belong_to_built_rules() -> None:
    for entry in register.ambiguities().values():
        if entry.built:
            assert any(register.rule(rule_id).built for rule_id in entry.rules), entry.id


def test_one_rule_as_text() -> None:
    text = register.describe("FBA-38")
    assert text.startswith("FBA-38: Time of a plane\n")
    for part in (
        "confidence: one implementation",
        "clause (unverified): ISO",
        "AMB-FBA-6",
        "* after:",
        "before:",
    ):
        assert part in text
    assert max(map(len, text.splitlines())) <= 100
    assert register.describe("AMB-FBA-6") in text
    assert "warning (FBA-42)" in register.describe("zero-padding")


def test_the_listing_has_one_line_per_rule() -> None:
    lines = list(register.listing())
    assert len(lines) == len(register.rules())
    assert [line.split()[0] for line in lines] == list(register.rules())
    assert all("\n" not in line for line in lines)


@pytest.mark.parametrize("unknown", ["FBA-99", "FBA-07", "XYZ-1", "fba-1", "FBA-", "", "AMB-FBA-99", "no-such-thing"])
def test_an_unknown_id_is_an_error_that_names_it(unknown: str) -> None:
    with pytest.raises(InputFormat) as caught:
        register.describe(unknown)
    assert caught.value.value == unknown
    assert caught.value.allowed


def test_one_rule_reads_one_file() -> None:
    code = (
        "import sys, pathlib\n"
        "read = []\n"
        "def hook(event, args):\n"
        "    if event == 'open' and str(args[0]).endswith('.toml'):\n"
        "        read.append(str(args[0]))\n"
        "sys.addaudithook(hook)\n"
        "from snhc.reference_impl.rules import rule\n"
        "assert not read and 'tomllib' not in sys.modules\n"
        "rule('FBA-26')\n"
        "assert [pathlib.Path(p).name for p in read] == ['fba.toml'], read\n"
    )  # fmt: skip
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


DAMAGES = [
    ("tts.toml", 'title = "Input"', 'titel = "Input"', "titel", "TTS-1", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", 'title = "Input"\n', "", "title", "TTS-1", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", "[TTS-6]", "[TTT-6]", "entry", "TTT-6", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", "[TTS-6]", "[FBA-6]", "entry", "FBA-6", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", "[area]", "[head]", "entry", "area", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", 'document = "speech"', "document = 1", "document", "area", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", '["AMB-TTS-1"]', '["TTS-1"]', "ambiguities", "TTS-2", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", '["AMB-TTS-1"]', '"AMB-TTS-1"', "ambiguities", "TTS-2", lambda f: register.rule("TTS-1", f)),
    ("tts.toml", '"this suite"\n', '"certain"\n', "confidence", "TTS-4", lambda f: register.rules(f)),
    ("tts.toml", "[TTS-6]", "[TTS-6", "register", "", lambda f: register.rules(f)),
    ("ambiguities.toml", "[AMB-FBA-1]", "[AMB-FAP-1]", "entry", "AMB-FAP-1", register.ambiguities),
    ("ambiguities.toml", "readings.wide", "readings.Wide", "readings", "AMB-FBA-2", register.ambiguities),
    ("ambiguities.toml", 'readings.wide = "', '# "', "readings", "AMB-FBA-2", register.ambiguities),
    ("ambiguities.toml", '["FBA-10"]', '["FBA-010"]', "rules", "AMB-FBA-1", register.ambiguities),
    ("findings.toml", 'severity = "info"', 'severity = "bad"', "severity", "no-end-code", register.findings),
    ("findings.toml", "[no-end-code]", "[no.end-code]", "end-code", "no", register.findings),
    ("findings.toml", 'rule = "FBA-1"', 'rule = "FBA-x"', "rule", "no-end-code", register.findings),
]  # fmt: skip


@pytest.mark.parametrize(
    ("file", "old", "new", "what", "entry", "load"), DAMAGES, ids=[f"{d[0]}-{d[2]}".strip() for d in DAMAGES]
)
def test_a_file_that_breaks_the_form_is_one_error(
    tmp_path: Path, file: str, old: str, new: str, what: str, entry: str, load: Callable[[Path], Any]
) -> None:
    folder = shutil.copytree(REGISTER, tmp_path / "rules", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputFormat) as caught:
        load(folder)
    assert caught.value.path == f"{file} {entry}".strip()
    assert caught.value.what == what
