"""The bank of broken decoders: each gets exactly its status, one-shot and persistent.

Rules: CNF-9, CNF-10, CNF-14, CNF-15, CNF-16.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from snhc.conformance import process
from snhc.conformance.adapters import OneShot, Persistent
from snhc.conformance.process import Surroundings
from snhc.conformance.runner import run
from snhc.vectors.manifest import Manifest
from snhc.vectors.manifest import load as load_manifest

HARNESS = Path(__file__).parent.parent / "harness"
sys.path.insert(0, str(HARNESS))
from mutants import MUTANTS  # noqa: E402  # type: ignore[import-not-found]

VALID = "fap.arith.example.1"
INVALID = "fba.error.time-code.hours-24"
# May be concealed; the fault lies in the first plane, a line before it there is not.
CONCEALABLE = "fba.error.marker.group-1"
MANIFEST = load_manifest(check_schema=False)
ENTRIES = {entry.id: entry for entry in MANIFEST.entries}
MESH = next(entry.id for entry in MANIFEST.entries if entry.tools == ("mesh",))
OUTPUT = 1 << 20
MEMORY = 256 << 20
PYTHON = os.path.realpath(sys.executable)


def one_shot(script: str, *words: str, timeout: float = 20.0) -> OneShot:
    command = (PYTHON, "-S", str(HARNESS / f"{script}.py"), "{input}", *words)
    return OneShot(" ".join((script, *words)), command, timeout=timeout, output_bytes=OUTPUT, memory_bytes=MEMORY)


def persistent(*words: str, timeout: float = 20.0, start_timeout: float = 20.0) -> Persistent:
    return Persistent(
        " ".join(words), (PYTHON, "-S", str(HARNESS / "persistent.py"), *words),
        around=Surroundings(MEMORY, OUTPUT), timeout=timeout, start_timeout=start_timeout,
    )  # fmt: skip


def statuses(adapter: OneShot | Persistent, *ids: str) -> tuple[str, ...]:
    chosen = Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids))
    return tuple(result.status for result in run(chosen, [adapter]).results)


def reasons(adapter: OneShot | Persistent, *ids: str) -> list[str]:
    chosen = Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids))
    return [result.reason for result in run(chosen, [adapter]).results]


BANK = {
    # name: status on the valid, the invalid, the concealable vector
    "correct": ("pass", "pass", "pass"),
    "rejects_everything": ("fail", "pass", "pass"),
    "accepts_everything": ("fail", "fail", "fail"),
    "prints_nothing": ("error", "fail", "error"),
    "prints_garbage": ("error", "fail", "error"),
    "not_utf8": ("error", "fail", "error"),
    "crashes": ("crash", "crash", "crash"),
    "falls_over": ("crash", "crash", "crash"),
    "exits_2": ("crash", "crash", "crash"),
    "wrong_value": ("fail", "pass", "pass"),
    "float_values": ("error", "pass", "pass"),
    "nan_values": ("error", "pass", "pass"),
    "missing_frame": ("fail", "pass", "pass"),
    "extra_frame": ("fail", "pass", "pass"),
    "swapped_frames": ("fail", "pass", "pass"),
    "wrong_state": ("fail", "pass", "pass"),
    "exits_0_after_error": ("pass", "fail", "fail"),
    "wrong_class": ("pass", "fail", "fail"),
    "wrong_place": ("pass", "fail", "fail"),
    "unsupported": ("not_applicable", "not_applicable", "not_applicable"),
    "says_unsupported_in_words": ("fail", "pass", "pass"),
    # What a decoder makes of a stream behind a fault that it may conceal is its own affair.
    "stale_output": ("fail", "fail", "pass"),
    "rejects_after_decoding": ("fail", "pass", "pass"),
    "prints_on_stderr": ("error", "pass", "pass"),
    "takes_memory": ("crash", "crash", "crash"),
    "fills_a_file": ("crash", "crash", "crash"),
    "overwrites_its_input": ("pass", "pass", "pass"),
}
# What makes no sense, or is another thing, where one process does all vectors.
ONE_SHOT_ONLY = {
    "floods": ("error", "error", "error"),
    "leaves_a_child": ("pass", "pass", "pass"),
    "leaves_a_session": ("pass", "pass", "pass"),
    "takes_memory_in_children": ("crash", "crash", "crash"),
    "kills_its_parent": ("crash", "crash", "crash"),
    "hides_a_crash": ("crash", "crash", "crash"),
    "sanitizer": ("crash", "crash", "crash"),
}
ENDLESS = ("hangs", "waits_for_a_child", "stops_itself", "never_ends", "closes_output_and_hangs", "trickles")


@pytest.mark.parametrize("name", [*BANK, *ONE_SHOT_ONLY])
def test_each_decoder_of_the_bank_gets_exactly_its_status(name: str) -> None:
    assert statuses(one_shot(name), VALID, INVALID, CONCEALABLE) == {**BANK, **ONE_SHOT_ONLY}[name]


@pytest.mark.parametrize("name", BANK)
def test_each_decoder_of_the_bank_gets_its_status_as_a_persistent_one_too(name: str) -> None:
    assert statuses(persistent(name), VALID, INVALID, CONCEALABLE) == BANK[name]


@pytest.mark.parametrize("name", ENDLESS)
def test_a_decoder_that_does_not_end_is_stopped(name: str) -> None:
    assert statuses(one_shot(name, timeout=0.7), VALID) == ("timeout",)


@pytest.mark.parametrize("name", ["hangs", "waits_for_a_child", "stops_itself"])
def test_a_persistent_decoder_that_does_not_answer_is_stopped(name: str) -> None:
    assert statuses(persistent(name, timeout=0.7), VALID) == ("timeout",)


def test_every_script_of_the_harness_is_in_the_bank() -> None:
    scripts = {path.stem for path in HARNESS.glob("*.py")}
    elsewhere = {"_shared", "other_format", "mutants", "persistent", "writes_outside"}
    assert scripts == set(BANK) | set(ONE_SHOT_ONLY) | set(ENDLESS) | elsewhere
    assert len(scripts | set(MUTANTS)) >= 25


MALFORMED = {
    "no_header", "header_last", "two_headers", "wrong_kind", "wrong_version", "version_is_true", "byte_order_mark",
    "blank_lines", "cut_in_a_line", "words_behind", "one_json_list", "times_as_numbers", "intra_is_1",
    "strings_for_values", "value_of_many_digits", "values_of_67_faps", "no_state", "lower_case_state",
}  # fmt: skip


@pytest.mark.parametrize("name", MUTANTS)
def test_output_that_is_wrong_in_one_way(name: str) -> None:
    expected = ("error" if name in MALFORMED else "fail", "pass")
    assert statuses(one_shot("mutants", name), VALID, INVALID) == expected
    assert statuses(persistent("mutants", name), VALID, INVALID) == expected


def test_a_decoder_that_writes_outside_cannot(request: pytest.FixtureRequest) -> None:
    if not process.fenced():
        pytest.skip("this kernel has no Landlock")
    assert statuses(one_shot("writes_outside"), VALID, INVALID) == ("crash", "crash")
    assert not (HARNESS / "left-behind.ndjson").exists()


# -- the protocol ------------------------------------------------------------------------------------------------------

FAULTS = {
    # name: status of the first vector; with the second the process behaves
    "wrong_seq": ("error", "decode 2 was asked, the answer is for 'decode' 3"),
    "seq_of_the_last": ("error", "the answer is for 'decode' 1"),
    "seq_is_text": ("error", "the answer is for 'decode' '2'"),
    "seq_is_float": ("error", "the answer is for 'decode' 2.0"),
    "wrong_type": ("error", "the answer is for 'hello' 2"),
    # Whether the second line is here before the next question is a matter of time.
    "two_answers": ("error", "after its answer: "),
    "second_answer_later": ("error", "after its answer: "),
    "no_answer": ("timeout", "no end after"),
    "garbage_before": ("error", "a line that is no JSON: 'decoding...'"),
    "garbage_behind": ("error", "after its answer: "),
    "half_a_line_behind": ("error", "after its answer: "),
    "no_line_end": ("timeout", "no end after"),
    "dies_in_the_message": ("crash", "exit code 3 before it answered"),
    "dies_by_signal": ("crash", "signal 6 before it answered"),
    "dies_behind_its_answer": ("crash", "after its answer: the process ended with signal 6"),
    "leaves_without_a_word": ("error", "exit code 0 before it answered"),
    "closes_stdin": ("error", "it has closed its standard input"),
    "closes_stdout": ("error", "it has closed its standard output"),
    "not_an_object": ("error", "no JSON object"),
    "no_status": ("error", "'status' is a required property"),
    "unknown_status": ("error", "'ok' is not one of"),
    "accepted_without_output": ("error", "'output' is a required property"),
    "lines_for_output": ("error", "is not of type 'string'"),
    "floods_a_line": ("error", "more than 1048576 bytes"),
    "floods_lines": ("error", "no JSON"),
    "floods_stderr": ("pass", ""),
    "says_crash": ("crash", "own words"),
    "half_a_surrogate": ("error", "half of a surrogate pair"),
    "bits_as_text": ("error", "is not of type 'array'"),
    "changes_hello": ("error", "after its answer: it speaks 'snhc-adapter' version 3"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_the_protocol_is_the_status_of_one_vector(name: str) -> None:
    status, words = FAULTS[name]
    adapter = persistent(name, timeout=0.7 if status == "timeout" else 20.0)
    chosen = Manifest(MANIFEST.suite, (ENTRIES[VALID],))
    result = run(chosen, [adapter]).results[0]
    assert (result.status, words in result.reason) == (status, True), result.reason


def test_after_a_fault_the_next_vectors_are_asked_of_another_process() -> None:
    # Each process fails on its first vector: the second asks the same process only where the first went well.
    assert statuses(persistent("dies_by_signal"), VALID, INVALID, CONCEALABLE) == ("crash",) * 3
    assert statuses(persistent("floods_stderr"), VALID, INVALID, CONCEALABLE) == ("pass",) * 3


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("never_answers_hello", "no answer to hello within 0.7 s"),
        ("dies_at_hello", "no licence found"),
        ("wrong_version", "it speaks 'snhc-adapter' version 2, this is 'snhc-adapter' version 1"),
        ("wrong_protocol", "it speaks 'another' version 1"),
        ("unknown_tool", "'speech' is not one of"),
    ],
)
def test_what_cannot_be_greeted_is_an_error_and_not_tried_again(name: str, words: str) -> None:
    adapter = persistent(name, start_timeout=0.7 if name.startswith("never") else 20.0)
    started = time.monotonic()
    chosen = Manifest(MANIFEST.suite, tuple(entry for entry in MANIFEST.entries if entry.tools == ("fba",)))
    report = run(chosen, [adapter], jobs=2)
    assert {result.status for result in report.results} == {"error"}
    assert words in report.results[0].reason
    assert time.monotonic() - started < 30 and report.exit_code == 5


def test_what_the_process_does_not_claim_is_not_applicable() -> None:
    assert statuses(persistent("claims_nothing"), VALID) == ("not_applicable",)
    assert statuses(persistent("claims_no_faults"), VALID, INVALID) == ("pass", "not_applicable")
    assert statuses(persistent("claims_fap_only"), MESH) == ("not_applicable",)
    options = ("fba.framing.draft-codes", "fba.framing.trailing-data.strict", "fba.error.limit.skipped-frames")
    assert statuses(persistent("floods_stderr"), *options) == ("not_applicable",) * 3
    assert statuses(persistent("correct_with_options"), *options) == ("pass",) * 3


@pytest.mark.parametrize("name", ["correct_no_bye", "lingers_after_bye", "talks_after_bye", "exits_7_after_bye"])
def test_how_a_process_leaves_changes_no_status(name: str) -> None:
    started = time.monotonic()
    assert statuses(persistent(name), VALID, INVALID) == ("pass", "pass")
    assert time.monotonic() - started < 15
