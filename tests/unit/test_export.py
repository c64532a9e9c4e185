"""The export: whole, the same every time, and checked with nothing but `sha256sum` and a JSON Schema validator."""

from __future__ import annotations

import gzip
import io
import json
import re
import subprocess
import tarfile
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner, Result

from snhc.conformance.cli import snhc
from snhc.reference_impl.rules import rules
from snhc.vectors import export
from snhc.vectors.export import SUMS, archive, export_files, write_export
from snhc.vectors.manifest import MANIFEST_NAME, SUITE, load


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("export") / "suite"
    write_export(target)
    return target


def run(*args: object) -> Result:
    return CliRunner().invoke(snhc, ["generate", *map(str, args)])


def sums(folder: Path) -> subprocess.CompletedProcess[str]:
    """What a stranger does, without any of our code."""
    return subprocess.run(
        ["sha256sum", "--strict", "-c", SUMS], cwd=folder, capture_output=True, text=True, check=False
    )


def names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_sha256sum_finds_it_whole(folder: Path) -> None:
    done = sums(folder)
    assert done.returncode == 0, done.stdout[-500:] + done.stderr
    assert {line.rpartition(": ")[0] for line in done.stdout.splitlines()} == names(folder) - {SUMS}


def test_sha256sum_finds_one_changed_byte(tmp_path: Path) -> None:
    write_export(tmp_path / "suite")
    victim = tmp_path / "suite" / "fap" / "fap.arith.example.1.fba"
    victim.write_bytes(victim.read_bytes()[:-1] + b"\0")
    done = sums(tmp_path / "suite")
    assert done.returncode == 1
    assert [line for line in done.stdout.splitlines() if not line.endswith(": OK")] == [
        "fap/fap.arith.example.1.fba: FAILED"
    ]


def test_the_manifest_fits_the_schema_beside_it_and_names_every_file(folder: Path) -> None:
    schema = json.loads((folder / "manifest.schema.json").read_text(encoding="utf-8"))
    document = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema, jsonschema.Draft202012Validator)
    named = set(re.findall(r'"file": "([^"]+)"', (folder / "manifest.json").read_text(encoding="utf-8")))
    papers = {"README.md", "VECTORS.md", "RULES.md", "LICENSE", "manifest.json", "manifest.schema.json", SUMS}
    assert names(folder) == named | papers


def test_what_it_tells_is_true(folder: Path) -> None:
    manifest = load()
    readme = (folder / "README.md").read_text(encoding="utf-8")
    assert f"{len(manifest.entries)} vectors" in readme and f"version {manifest.suite}" in readme
    assert "$" not in readme
    assert all(f"`{tool}`" in readme for entry in manifest.entries for tool in entry.tools)
    listed = (folder / "VECTORS.md").read_text(encoding="utf-8")
    assert (
        re.findall(r"^\| `([^`]+\.[^`]+)` \|", listed, re.MULTILINE).sort() == [e.id for e in manifest.entries].sort()
    )
    told = set(re.findall(r"^## ([A-Z]{3}-\d+): ", (folder / "RULES.md").read_text(encoding="utf-8"), re.MULTILINE))
    assert told == {rule for entry in manifest.entries for rule in entry.rules} & set(rules())
    assert "Apache License" in (folder / "LICENSE").read_text(encoding="utf-8")


def test_the_same_every_time(folder: Path, tmp_path: Path) -> None:
    assert run("--export", tmp_path / "suite").exit_code == 0
    assert names(folder) == names(tmp_path / "suite")
    assert all((folder / name).read_bytes() == (tmp_path / "suite" / name).read_bytes() for name in names(folder))


def test_the_archive_holds_the_same_and_no_trace_of_the_machine(folder: Path, tmp_path: Path) -> None:
    done = run("--export", tmp_path / "suite.tar.gz")
    assert (done.exit_code, done.stdout) == (0, f"{len(names(folder))} files in {tmp_path}/suite.tar.gz\n")
    packed = (tmp_path / "suite.tar.gz").read_bytes()
    assert packed == archive(export_files(), f"snhc-suite-{load().suite}")
    # RFC 1952: no name, no time.
    assert packed[3:8] == bytes(5)
    with tarfile.open(fileobj=io.BytesIO(gzip.decompress(packed))) as tar:
        members = tar.getmembers()
        tar.extractall(tmp_path, filter="data")
    assert {(m.uid, m.gid, m.uname, m.gname, m.mtime) for m in members} == {(0, 0, "", "", 0)}
    top = tmp_path / f"snhc-suite-{load().suite}"
    assert names(top) == names(folder)
    assert sums(top).returncode == 0


def test_a_decoder_is_judged_by_the_export_as_by_the_suite(folder: Path) -> None:
    done = CliRunner().invoke(snhc, ["run", "--suite", str(folder), "--filter", "fap.arith.*", "--quiet"])
    assert done.exit_code == 0, done.output


# -- whole or not at all -----------------------------------------------------------------------------------------------


def test_an_older_export_is_replaced_and_nothing_else_is(tmp_path: Path) -> None:
    target = tmp_path / "suite"
    target.mkdir()
    assert run("--export", target).exit_code == 0
    (target / "mesh" / "mesh.example.1.m2d").write_bytes(b"changed")
    assert run("--export", target).exit_code == 0
    assert sums(target).returncode == 0
    (target / "notes.txt").write_text("mine", encoding="utf-8")
    done = run("--export", target)
    assert done.exit_code == 3 and (target / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["suite"]


@pytest.mark.parametrize("held", [{"thesis.tex": "years"}, {MANIFEST_NAME: "{}"}, {SUMS: ""}])
def test_other_folders_are_left_alone(tmp_path: Path, held: dict[str, str]) -> None:
    for name, text in held.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(FileExistsError):
        write_export(tmp_path)
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == held


def test_a_folder_of_empty_folders_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "work" / "to-come").mkdir(parents=True)
    with pytest.raises(FileExistsError):
        write_export(tmp_path / "work")
    assert (tmp_path / "work" / "to-come").is_dir()


def test_what_goes_wrong_half_way_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "suite"
    write_export(target)
    before = {name: (target / name).read_bytes() for name in names(target)}
    good = export.export_files()
    # The last name cannot be written: there is a file where its folder should be.
    monkeypatch.setattr(export, "export_files", lambda suite: {**good, f"{SUMS}/more": b""})
    done = run("--export", target)
    assert done.exit_code == 3
    assert [path.name for path in tmp_path.iterdir()] == ["suite"]
    assert {name: (target / name).read_bytes() for name in names(target)} == before


def test_a_suite_with_a_wrong_file_is_not_exported(tmp_path: Path) -> None:
    write_export(tmp_path / "suite")
    (tmp_path / "suite" / "mesh" / "mesh.example.1.m2d").write_bytes(b"changed")
    done = run("--suite", tmp_path / "suite", "--export", tmp_path / "out")
    assert done.exit_code == 3 and "mesh.example.1" in done.stderr
    assert not (tmp_path / "out").exists()


def test_options_exclude_each_other() -> None:
    assert run("--check", "--export", "x").exit_code == 2
    assert run("--format", "json").exit_code == 2


def test_export_reads_the_suite_on_disk(folder: Path) -> None:
    assert (folder / MANIFEST_NAME).read_bytes() == (SUITE / MANIFEST_NAME).read_bytes()


def test_long_names_are_archived_too() -> None:
    name = f"{'f' * 90}/{'n' * 140}.ndjson"
    with tarfile.open(fileobj=io.BytesIO(gzip.decompress(archive({name: b"x"}, "top")))) as tar:
        assert tar.getnames() == ["top", f"top/{'f' * 90}", f"top/{name}"]
