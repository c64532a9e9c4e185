"""What an input is, and the verb that a message names for it.

Rules: CNF-2, CNF-7, CNF-25.
"""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from snhc.analyzer.check import check_input
from snhc.conformance.cli import VERBS, snhc
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.documents import kinds
from snhc.reference_impl.documents.kinds import hint, kind_of_input
from snhc.vectors.manifest import SUITE, load

STREAM = (SUITE / "fap" / "fap.arith.example.1.fba").read_bytes()
FAP = b"2.1 speech 25 1\n" + b"0 " * 67 + b"0\n0\n"
KINDS = {
    "stream": STREAM,
    "mp4": b"\0\0\0\x18ftypmp42abcd",
    "zip": b"PK\x03\x04abcd",
    "pictures": b"\x89PNG\r\n\x1a\nabcd",
    "fap": FAP,
    "fdp": b"# points\n2.1 0.0 1.5 -3\n",
    "fit": b"DEF one FIT {\n}",
    "model": b"Group { }",
    "scene": b"# BT\nInitialObjectDescriptor {\n}",
    "json": b'{"points": {}}',
    "dump": b'\xef\xbb\xbf{"format": "snhc-dump"}',
    "mesh": b'{"format":"snhc-mesh","version":1}',
    "decoded": b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n{"index":0}\n',
    "report": b'{\n "format": "snhc-report"}',
    "journal": b'{"format": "snhc-journal"}',
    "": b"hello world\n",
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_told_by_its_content(kind: str) -> None:
    assert kind_of_input(KINDS[kind]) == kind


def test_a_fap_text_may_have_a_number_for_a_name(tmp_path: Path) -> None:
    text = FAP.replace(b"speech", b"001")
    assert kind_of_input(text) == kind_of_input(b"# one\n\n" + text) == "fap"
    assert kind_of_input(b"2.1 1 25 3\n") == kind_of_input(b"2.1 1 25 3\n# two\n2.2 0 0 0 1.5\n") == "fdp"
    path = tmp_path / "001.fap"
    path.write_bytes(text)
    for words in (["check", str(path)], ["encode", str(path), "-o", str(tmp_path / "001.fba")]):
        assert CliRunner().invoke(snhc, words).exit_code == 0


@pytest.mark.parametrize("name", ["zip", "pictures", "stream", "fap", "stats"])
def test_json_that_calls_itself_what_is_no_json_is_json(name: str) -> None:
    assert kind_of_input(b'{"format": "snhc-' + name.encode() + b'"}') == "json"


@pytest.mark.parametrize("kind", ["fap", "fdp", "fit", "json", "stream"])
def test_a_slow_pipe_is_told_like_a_file(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "input"
    path.write_bytes(KINDS[kind])

    def checked(stream: object) -> list[str]:
        out: list[str] = []
        try:
            out.append(check_input(stream, lambda finding: out.append(str(finding))).kind)  # type: ignore[arg-type]
        except SnhcError as error:
            out.append(str(error))
        return out

    # Byte by byte, as a pipe may come.
    with path.open("rb") as file, io.BufferedReader(Drop(KINDS[kind])) as pipe:
        assert checked(pipe) == checked(file)


class Drop(io.RawIOBase):
    """A pipe that hands over one byte at a time."""

    def __init__(self, data: bytes) -> None:
        self._rest = io.BytesIO(data)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: bytearray) -> int:  # type: ignore[override]
        data = self._rest.read(1)
        buffer[: len(data)] = data
        return len(data)


def test_inputs_of_the_suite_are_what_they_are() -> None:
    found: dict[str, set[str]] = {}
    for entry in load(check_schema=False).entries:
        if entry.kind == "valid":
            kind = kind_of_input((SUITE / entry.file).read_bytes()[: kinds.HEAD_BYTES])
            found.setdefault(Path(entry.file).suffix, set()).add(kind)
    assert found[".fba"] == found[".m2d"] == {"stream"}
    # Dialects without a header of its form are told by nothing.
    assert found[".fap"] == {"fap", ""} and found[".json"] == {"json"}


def test_every_verb_that_is_named_is_there() -> None:
    for what, verbs in kinds._OTHERS.values():
        named = re.findall(r"(?<![-\w])[a-z]+", verbs.replace(" and ", " "))
        assert what and set(named) <= set(VERBS), verbs


@pytest.mark.parametrize("verb", ["decode", "dump", "stats", "check"])
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("stream", "")])
def test_what_is_no_stream_is_called_by_its_name(tmp_path: Path, verb: str, kind: str) -> None:
    path = tmp_path / "input"
    path.write_bytes(KINDS[kind])
    if verb == "check" and kind in ("fap", "fdp", "fit", "model", "json"):
        return
    done = CliRunner().invoke(snhc, [verb, str(path), "--json-errors"])
    fault = json.loads(done.stderr.splitlines()[-1])
    if kind == "mp4":
        # The standard defines it, and it is not built here.
        assert (done.exit_code, fault["class"], fault["rule"]) == (4, "Unsupported", "SYS-13")
        return
    assert (done.exit_code, fault["class"]) == (3, "InputFormat")
    assert hint(KINDS[kind]).startswith("this is ") and hint(KINDS[kind]) in fault["message"]


@pytest.mark.parametrize("kind", ["stream", "zip", "fdp", "fit", "model", "report", "mp4"])
def test_what_cannot_be_encoded_is_called_by_its_name(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "input"
    path.write_bytes(KINDS[kind])
    done = CliRunner().invoke(snhc, ["encode", str(path), "-o", str(tmp_path / "out.fba")])
    assert done.exit_code == 3 and not (tmp_path / "out.fba").exists()
    assert ("MP4" if kind == "mp4" else hint(KINDS[kind])) in done.stderr


def test_nothing_is_said_of_what_is_not_known(tmp_path: Path) -> None:
    path = tmp_path / "input"
    path.write_bytes(KINDS[""])
    done = CliRunner().invoke(snhc, ["decode", str(path)])
    assert done.exit_code == 3 and "this is" not in done.stderr
    assert hint(STREAM, "stream") == ""


@pytest.mark.parametrize("verb", ["decode", "dump", "stats", "check", "plot"])
def test_an_empty_input_is_called_empty(tmp_path: Path, verb: str) -> None:
    path = tmp_path / "input"
    path.write_bytes(b"")
    done = CliRunner().invoke(snhc, [verb, str(path)])
    assert done.exit_code == 3 and "; this is empty (FBA-1)" in done.stderr
    done = CliRunner().invoke(snhc, [verb, "-"], input=b"")
    assert done.exit_code == 3 and "; this is empty (FBA-1)" in done.stderr


# -- documents that cannot be read -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "content", "said"),
    [
        (["report", "FILE"], b"\0\0\0\xff\xff\xff\xff\xff", "is no text"),
        (["run", "FILE"], b"command = '\xff'", "byte 0xff at 11 is no text"),
        (["run", "--ledger", "FILE"], b"\xff", "byte 0xff at 0 is no text"),
        (["coverage", "--mutants", "--matrix", "FILE"], b"{}", "format is missing"),
        (["encode", "FILE", "-o", "OUT"], b'{"frames": [', "its end"),
        (["encode", "FILE", "-o", "OUT"], b'{"frames": []}', "a mesh document, which has this key"),
    ],
)
def test_why_a_document_cannot_be_read_is_said_for_people(
    tmp_path: Path, words: list[str], content: bytes, said: str
) -> None:
    path = tmp_path / "input"
    path.write_bytes(content)
    names = {"FILE": str(path), "OUT": str(tmp_path / "out.fba")}
    done = CliRunner().invoke(snhc, [names.get(word, word) for word in words])
    assert done.exit_code in (3, 5) and said in done.stderr, done.stderr
    assert "codec" not in done.stderr and "Expecting" not in done.stderr


def test_a_file_that_is_not_there_says_what_is_allowed(tmp_path: Path) -> None:
    done = CliRunner().invoke(snhc, ["decode", str(tmp_path / "nowhere"), "--json-errors"])
    assert json.loads(done.stderr)["allowed"] == "a file that is there"
    done = CliRunner().invoke(snhc, ["decode", str(tmp_path), "--json-errors"])
    assert json.loads(done.stderr)["allowed"] == "a file, no folder"


@pytest.mark.parametrize(
    "loader", ["analyzer.policy:load_policy", "conformance.ledger:load", "conformance.adapters.file:read"]
)
def test_of_a_file_without_end_no_more_is_read_than_may_be_there(loader: str) -> None:
    module, _, name = loader.partition(":")
    program = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30)); from pathlib import Path; "
        f"from snhc.{module} import {name}; {name}(Path('/dev/zero'))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert "more than 1048576 bytes" in done.stderr
