"""The command as a process: streams, pipes, signals, what it loads."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from signals import hears_interrupts

WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
HEAVY = ("numpy", "rich", "jsonschema", "scipy", "asyncio")


def command(*args: str) -> list[str]:
    return [sys.executable, "-m", "snhc.conformance.cli", *args]


def environment(**more: str) -> dict[str, str]:
    """That of the tests, whose own buffering and colours are of no account."""
    dropped = ("PYTHONUNBUFFERED", "NO_COLOR", "SNHC_DEBUG")
    return {**{key: value for key, value in os.environ.items() if key not in dropped}, **more}


def run(*args: str, stdin: bytes = b"", env: dict[str, str] | None = None) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        command(*args), input=stdin, capture_output=True, timeout=60, check=False, env=environment(**(env or {}))
    )


def many_planes(count: int) -> bytes:
    # 07: is_intra 0, fba_object_mask 00, skip_frames 0; stuffing 0111.
    return WORKED[:-4] + b"".join(bytes.fromhex("000001bb") + b"\x07" for _ in range(count)) + WORKED[-4:]


def test_standard_input_and_output() -> None:
    result = run("decode", "-", stdin=WORKED)
    assert result.returncode == 0
    assert len(result.stdout.splitlines()) == 4
    assert result.stderr.startswith(b"info: no-sequence-header")


@pytest.mark.parametrize(
    ("args", "stdin", "code"),
    [
        (("decode", "-"), WORKED, 0),
        (("decode",), b"", 2),
        (("decode", "-", "--no-such-option"), b"", 2),
        (("decode", "/no/such/file"), b"", 3),
        (("decode", "/"), b"", 3),
        (("decode", "-"), b"text", 3),
        (("decode", "-"), WORKED[:30], 4),
        (("dump", "-"), WORKED[:30], 4),
        (("rules", "FBA-999"), b"", 2),
    ],
)
def test_exit_codes(args: tuple[str, ...], stdin: bytes, code: int) -> None:
    result = run(*args, stdin=stdin)
    assert result.returncode == code
    assert b"Traceback" not in result.stderr


def test_no_half_line_wherever_the_stream_ends() -> None:
    for end in range(5, len(WORKED) - 4, 7):
        result = run("decode", "-", "--quiet", stdin=WORKED[:end])
        assert result.returncode == 4
        assert result.stdout.endswith(b"\n")
        for line in result.stdout.splitlines():
            json.loads(line)


BUFFERING = pytest.mark.parametrize("buffering", [{}, {"PYTHONUNBUFFERED": "1"}], ids=["buffered", "unbuffered"])


@BUFFERING
def test_a_reader_that_goes_away_is_no_error(tmp_path: Path, buffering: dict[str, str]) -> None:
    stream = tmp_path / "many.fba"
    stream.write_bytes(many_planes(3000))
    process = subprocess.Popen(
        command("decode", str(stream), "--quiet"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(**buffering),
    )
    assert process.stdout is not None and process.stderr is not None
    assert process.stdout.readline().startswith(b'{"format"')
    process.stdout.close()
    assert process.wait(timeout=60) == 141
    assert process.stderr.read() == b""
    process.stderr.close()


@BUFFERING
def test_a_full_disk_is_an_input_or_output_fault(buffering: dict[str, str]) -> None:
    with Path("/dev/full").open("wb") as full:
        result = subprocess.run(
            command("decode", "-", "--quiet"),
            input=WORKED,
            env=environment(**buffering),
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
    assert result.returncode == 3
    assert len(result.stderr.splitlines()) == 1


def test_planes_are_shown_before_the_input_ends() -> None:
    process = subprocess.Popen(
        command("decode", "-", "--quiet"), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdin is not None and process.stdout is not None and process.stderr is not None
    # A plane is complete once its look-ahead is there: 4096 bytes are more than any.
    process.stdin.write(many_planes(20_000))
    process.stdin.flush()
    assert process.stdout.readline().startswith(b'{"format"')
    assert json.loads(process.stdout.readline())["index"] == 0
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        stream.close()


def test_interrupted(tmp_path: Path) -> None:
    target = tmp_path / "out.ndjson"
    process = subprocess.Popen(
        command("decode", "-", "-o", str(target)),
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=hears_interrupts,
    )  # fmt: skip
    assert process.stdin is not None and process.stderr is not None and process.stdout is not None
    process.stdin.write(WORKED[:8])
    process.stdin.flush()
    # Its part file shows that it has begun.
    for _ in range(600):
        if any(tmp_path.iterdir()):
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert b"Traceback" not in process.stderr.read()
    assert list(tmp_path.iterdir()) == []
    for stream in (process.stdin, process.stdout, process.stderr):
        stream.close()


@pytest.mark.parametrize("args", [("--help",), ("--version",), ("rules", "FBA-26"), ("dump", "--help"), ("dump", "-")])
def test_nothing_heavy_is_loaded(args: tuple[str, ...]) -> None:
    code = (
        "import sys; from snhc.conformance.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        f"print(*[name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, *args], input=WORKED, capture_output=True, timeout=60, check=True
    )
    assert result.stderr.strip() == b""


def test_no_colour_and_no_bar_in_pipes() -> None:
    result = run("dump", "-", stdin=WORKED, env={"TERM": "xterm-256color"})
    assert b"\x1b" not in result.stdout + result.stderr


def test_colour_on_a_terminal_unless_told_otherwise() -> None:
    import pty

    for extra, coloured in (({}, True), ({"NO_COLOR": "1"}, False)):
        ours, theirs = pty.openpty()
        process = subprocess.Popen(
            command("dump", "-", "--depth", "1"), stdin=subprocess.PIPE, stdout=theirs, stderr=subprocess.DEVNULL,
            env=environment(TERM="xterm", **extra),
        )  # fmt: skip
        process.communicate(WORKED, timeout=60)
        os.close(theirs)
        shown = b""
        try:
            while chunk := os.read(ours, 65536):
                shown += chunk
        except OSError:
            # How a terminal says that nobody writes to it any more.
            pass
        os.close(ours)
        assert (b"\x1b[" in shown) is coloured
        assert b"plane[0]" in shown


def test_a_tree_on_a_terminal_goes_through_the_pager() -> None:
    """Every line comes through it, colours too; fault and exit code stand behind it; --no-pager does without."""
    pty = pytest.importorskip("pty")

    def on_a_terminal(*args: str) -> tuple[int, bytes]:
        ours, theirs = pty.openpty()
        with tempfile.NamedTemporaryFile(suffix=".fba") as file:
            file.write(WORKED[:30])
            file.flush()
            process = subprocess.Popen(
                command("dump", file.name, *args), stdin=theirs, stdout=theirs, stderr=theirs,
                env={**os.environ, "TERM": "xterm", "PAGER": "sed s/^/PAGED/"},
            )  # fmt: skip
            os.close(theirs)
            seen = b""
            while True:
                try:
                    piece = os.read(ours, 1 << 16)
                except OSError:  # Linux says so when the other side is closed
                    break
                if not piece:
                    break
                seen += piece
            os.close(ours)
            return process.wait(), seen

    code, seen = on_a_terminal()
    assert code == 4
    assert seen.count(b"PAGED") > 20
    assert b"PAGED\x1b[2mbits " in seen
    assert b"\nsnhc: Truncated: " in seen
    code, seen = on_a_terminal("--no-pager")
    assert (code, seen.count(b"PAGED")) == (4, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="closed streams of POSIX shells")
def test_closed_standard_streams_are_no_bug(tmp_path: Path) -> None:
    """Cron jobs and daemons may start a command with any of them closed."""
    path = tmp_path / "x.fba"
    path.write_bytes(WORKED)

    def closed(streams: str, *words: str) -> subprocess.CompletedProcess[bytes]:
        line = ["sh", "-c", f'exec "$@" {streams}', "sh", *command(*words)]
        return subprocess.run(line, capture_output=True, timeout=60, check=False, env=environment())

    done = closed(">&-", "decode", "--quiet", str(path))
    assert (done.returncode, done.stderr) == (3, b"snhc: Bad file descriptor\n")
    for streams in (">&-", "<&-", "2>&-", "<&- >&- 2>&-"):
        target = tmp_path / "out.ndjson"
        assert closed(streams, "decode", str(path), "-o", str(target)).returncode == 0
        assert target.read_bytes() == run("decode", str(path)).stdout
        target.unlink()
    assert path.read_bytes() == WORKED
    done = closed("<&-", "decode", "-")
    assert done.returncode == 3 and b"this is empty" in done.stderr
    assert closed("2>&-", "decode", str(path)).stdout == run("decode", str(path)).stdout
    for words in (["--version"], ["--help"], ["decode", "--help"]):
        done = closed(">&-", *words)
        assert (done.returncode, done.stderr) == (3, b"snhc: Bad file descriptor\n"), words
