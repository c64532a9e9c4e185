"""What goes wrong around the program: full disks, outputs that cannot be, closed pipes, kills, files that change.

Rules: CNF-19, CNF-4, CNF-20. Outputs appear whole or not at all; what stood there before stays; a rerun completes.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from math import gcd
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.source import SourceChanged, open_source
from snhc.reference_impl.systems.stream import decode_frames, write_stream
from snhc.vectors.builders import inter, intra, stream
from snhc.vectors.generate import UNFINISHED, compare, generate
from snhc.vectors.manifest import MANIFEST_NAME, SUITE

# Enough to start a file, too little for any output below.
FULL = 100


def speech(count: int = 60) -> bytes:
    first = intra({3: 100, 48: -3}, quant=2, rate=(25, 0, 0))
    return write_stream(stream(first, *(inter(first, {3: n % 5 - 2, 48: 1}) for n in range(count))))


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inputs")
    (folder / "a.fba").write_bytes(speech(240))
    (folder / "b.fba").write_bytes(speech(239))
    (folder / "mesh.m2d").write_bytes(next((SUITE / "mesh").glob("mesh.real.*.m2d")).read_bytes())
    lines = run(["decode", "a.fba", "--format", "fap", "--quiet"], folder).stdout
    (folder / "a.fap").write_bytes(lines)
    return folder


def run(
    words: list[str], folder: Path, *, full: bool = False, stdout: int | None = subprocess.PIPE
) -> subprocess.CompletedProcess[bytes]:
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, FULL))

    return subprocess.run(
        [sys.executable, "-B", "-m", "snhc.conformance.cli", *words], cwd=folder, stdout=stdout, stderr=subprocess.PIPE,
        timeout=120, check=False, preexec_fn=limit if full else None,
        env={**os.environ, "COLUMNS": "100"},
    )  # fmt: skip


# Verb and arguments, and the name of an output that grows beyond FULL bytes.
OUTPUTS = [
    (["decode", "a.fba"], "out.ndjson"),
    (["decode", "a.fba"], "out.csv"),
    (["decode", "a.fba"], "out.fap"),
    (["decode", "a.fba"], "out.npz"),
    (["decode", "mesh.m2d"], "out.ndjson"),
    (["encode", "a.fap", "--mode", "dct"], "out.fba"),
    (["dump", "a.fba"], "out.txt"),
    (["dump", "a.fba"], "out.json"),
    (["dump", "a.fba"], "out.csv"),
    (["diff", "a.fba", "b.fba"], "out.html"),
    (["diff", "a.fba", "b.fba"], "out.json"),
    (["stats", "a.fba"], "out.json"),
    (["plot", "a.fba"], "out.svg"),
    (["render", "a.fba"], "out.glb"),
    (["render", "mesh.m2d"], "out.gif"),
    (["run", "--filter", "fap.arith.example.*"], "out.json"),
    (["rules"], "out.txt"),
]
IDS = [f"{words[0]}-{name.partition('.')[2]}-{n}" for n, (words, name) in enumerate(OUTPUTS)]


def _fault(done: subprocess.CompletedProcess[bytes], *, said: bytes) -> None:
    assert done.returncode == 3, done.stderr.decode()
    assert b"Traceback" not in done.stderr
    # Findings may stand before it; the fault is one line.
    *before, last = done.stderr.splitlines()
    assert said in last, done.stderr.decode()
    assert last.startswith(b"snhc: ")
    assert not [line for line in before if line.startswith(b"snhc:")]


@pytest.mark.parametrize(("words", "name"), OUTPUTS, ids=IDS)
def test_a_full_disk_leaves_what_was_there(inputs: Path, tmp_path: Path, words: list[str], name: str) -> None:
    target = tmp_path / name
    target.write_bytes(b"of old")
    # What is spooled elsewhere first (arrays), or has a journal, may fail there.
    named = b"File too large" if name.endswith(".npz") or words[0] == "run" else f"snhc: {target}".encode()
    _fault(run([*words, "-o", str(target)], inputs, full=True), said=named)
    assert target.read_bytes() == b"of old"
    # A run keeps its journal, to go on from.
    assert {path.name for path in tmp_path.iterdir()} <= {name, f"{name}.journal"}
    # With room it works, so that it was the disk.
    assert run([*words, "-o", str(target)], inputs).returncode in (0, 1)
    assert target.stat().st_size > FULL
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize(("words", "name"), OUTPUTS[::2], ids=IDS[::2])
def test_outputs_that_cannot_be(inputs: Path, tmp_path: Path, words: list[str], name: str) -> None:
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / f"folder{Path(name).suffix}").mkdir()
    for target, said in (
        (tmp_path / "nowhere" / name, b"No such file or directory"),
        (tmp_path / "file" / name, b"Not a directory"),
        (tmp_path / f"folder{Path(name).suffix}", b"Is a directory"),
    ):
        done = run([*words, "-o", str(target)], inputs)
        _fault(done, said=said)
        assert str(target).encode() in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", f"folder{Path(name).suffix}"]


@pytest.mark.skipif(os.geteuid() != 0, reason="a read-only folder is made by mounting, which needs root")
def test_a_read_only_folder(inputs: Path, tmp_path: Path) -> None:
    target = tmp_path / "read-only"
    target.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "ro,size=64k", "tmpfs", str(target)], capture_output=True)
    if mounted.returncode:
        pytest.skip("no file system can be mounted here")
    try:
        _fault(run(["decode", "a.fba", "-o", str(target / "out.csv")], inputs), said=b"Read-only file system")
    finally:
        subprocess.run(["umount", str(target)], check=True)


@pytest.mark.parametrize(
    "words",
    [
        ["decode", "a.fba"], ["dump", "a.fba", "--symbols"], ["dump", "a.fba", "--format", "json"], ["rules"],
        ["check", "a.fba"],
    ],
    ids=lambda words: "-".join(words[:1] + words[2:]),
)  # fmt: skip
def test_a_pipe_that_is_closed_is_no_error(inputs: Path, words: list[str]) -> None:
    ours, theirs = os.pipe()
    os.close(ours)
    try:
        done = run(words, inputs, stdout=theirs)
    finally:
        os.close(theirs)
    # As a program of the shell that a closed pipe ends; findings go elsewhere.
    assert done.returncode == 128 + signal.SIGPIPE
    assert b"Traceback" not in done.stderr
    assert b"Broken pipe" not in done.stderr


# -- kills -------------------------------------------------------------------------------------------------------------


OLD = {MANIFEST_NAME: b"old manifest", "fap/a.fba": b"old a", "fap/gone.fba": b"gone", "deep/er/gone.fba": b"gone"}
NEW = {MANIFEST_NAME: b"new manifest", "fap/a.fba": b"new a", "fap/b.fba": b"b", "mesh/c.m2d": b"c"}


def _killed_at(count: int, folder: Path) -> bool:
    """Generate in a process that is gone before its file operation number `count`; whether there was such a one."""
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 9
    try:
        left = [count]

        def counted(name: str) -> None:
            real = getattr(Path, name)

            def operation(self: Path, *args: object, **kwargs: object) -> object:
                if not left[0]:
                    os._exit(9)
                left[0] -= 1
                return real(self, *args, **kwargs)

            setattr(Path, name, operation)

        for name in ("write_bytes", "replace", "unlink", "mkdir"):
            counted(name)
        generate(folder)
    except BaseException:  # noqa: BLE001 (the child must not go on as a second test runner)
        os._exit(1)
    os._exit(0)


@pytest.fixture
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.vectors.generate.build_suite", lambda: dict(NEW))


def _files(folder: Path) -> Iterator[tuple[str, bytes]]:
    for path in folder.rglob("*"):
        if path.is_file():
            yield path.relative_to(folder).as_posix(), path.read_bytes()


@pytest.mark.usefixtures("_few")
@pytest.mark.parametrize("before", [{}, OLD], ids=["empty", "old-suite"])
def test_a_kill_of_generate_leaves_whole_files_and_a_rerun_completes(tmp_path: Path, before: dict[str, bytes]) -> None:
    for count in range(200):
        folder = tmp_path / str(count)
        for name, content in before.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        killed = _killed_at(count, folder)
        there = dict(_files(folder)) if folder.exists() else {}
        for name, content in there.items():
            if name.endswith(".part"):
                continue
            assert content in (before.get(name), NEW.get(name), b"" if name == UNFINISHED else None), (count, name)
        if there.get(MANIFEST_NAME) == NEW[MANIFEST_NAME]:
            assert there.items() >= NEW.items(), "what the manifest names is there"
        if killed and there not in (before, NEW):
            assert compare(dict(NEW), folder), "a suite that is not whole is not called so"
        generate(folder)
        assert dict(_files(folder)) == NEW
        if not killed:
            break
    assert 10 < count < 199


# -- files that change while they are read -----------------------------------------------------------------------------


def _long() -> bytes:
    """More than any window of the reader holds: planes without data, each with its start code."""
    whole = speech(3)
    return whole[:-4] + b"".join(bytes.fromhex("000001bb") + b"\x07" for _ in range(60_000)) + whole[-4:]


@pytest.mark.parametrize("keep", [0, 100, 100_000, 200_001])
def test_a_file_that_is_cut_while_it_is_read(tmp_path: Path, keep: int) -> None:
    path = tmp_path / "a.fba"
    whole = _long()
    path.write_bytes(whole)
    with path.open("rb") as file:
        frames = decode_frames(open_source(file))
        times = [next(frames).time for _ in range(10)]
        os.truncate(path, keep)
        try:
            for frame in frames:
                times.append(frame.time)
        except SourceChanged as error:
            # An I/O fault (exit code 3), not the stream's: what was there is gone.
            assert str(keep) in str(error) or keep < 65_536
    assert times == [(n // _gcd(n), 25 // _gcd(n)) for n in range(len(times))]
    assert len(times) < 60_004


def _gcd(n: int) -> int:
    return gcd(n, 25) or 25


def test_a_file_that_grows_while_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.fba"
    whole = _long()
    path.write_bytes(whole[: len(whole) // 2])
    with path.open("rb") as file:
        frames = decode_frames(open_source(file))
        times = [next(frames).time for _ in range(10)]
        with path.open("ab") as more:
            more.write(whole[len(whole) // 2 :])
        try:
            for frame in frames:
                times.append(frame.time)
        except SnhcError as error:
            # The end that the file had when it was opened counts.
            assert type(error).__name__ == "Truncated"
            assert error.bits is not None
            assert error.bits[1] == 8 * (len(whole) // 2)
    assert 30_000 < len(times) < 60_004
