"""Foreign programs: limits, folder, environment, descriptors, and nothing left of them.

Rules: CNF-14.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from snhc.conformance import process
from snhc.conformance.process import Finished, Surroundings, fenced, room, run

PYTHON = [os.path.realpath(sys.executable), "-I", "-S"]
LINUX = sys.platform.startswith("linux")


def ran(code: str, *, seconds: float = 20, output_bytes: int = 1 << 16, memory_bytes: int = 1 << 30) -> Finished:
    command = [*PYTHON, "-c", code]
    return run(command, None, seconds=seconds, output_bytes=output_bytes, memory_bytes=memory_bytes)


def alive(pid: int) -> bool:
    """Also a zombie counts: nobody would reap it."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


FAMILIES = {
    "a child": "pid = os.fork()",
    "a child in a session of its own": "pid = os.fork()\nif pid == 0: os.setsid()",
    "an orphan in a session of its own": (
        "read, write = os.pipe()\nif os.fork() == 0:\n    os.setsid()\n    pid = os.fork()\n    if pid:\n"
        "        os.write(write, b'%d' % pid)\n        os._exit(0)\nelse:\n    pid = int(os.read(read, 20))"
    ),
}


@pytest.mark.parametrize("ends", ["ends", "hangs"])
@pytest.mark.parametrize("family", FAMILIES)
def test_nothing_that_a_program_started_outlives_it(family: str, ends: str) -> None:
    if not LINUX and family != "a child":
        pytest.skip("only Linux has subreapers")
    code = (
        f"import os, signal, sys, time\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n{FAMILIES[family]}\n"
        "if pid == 0:\n    time.sleep(600)\n    os._exit(0)\nprint(pid, flush=True)\n"
        + ("" if ends == "ends" else "time.sleep(600)")
    )
    finished = ran(code, seconds=20 if ends == "ends" else 3)
    assert finished.stopped == ("" if ends == "ends" else "timeout")
    assert finished.seconds < 10
    assert not alive(int(finished.stdout))


def test_a_runner_that_is_killed_leaves_nothing_running(tmp_path: Path) -> None:
    mark = tmp_path / "pid"
    code = f"import os, time; open({str(mark)!r}, 'w').write(str(os.getpid())); time.sleep(600)"
    runner = (
        "from snhc.conformance.process import Surroundings, room\n"
        f"with room(Surroundings(writable=({str(tmp_path)!r},))) as own:\n"
        f"    own.run({[*PYTHON, '-c', code]!r}, None, 600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", runner]) as runs:
        until = time.monotonic() + 20
        while not (mark.exists() and mark.read_text()) and time.monotonic() < until:
            time.sleep(0.02)
        pid = int(mark.read_text())
        assert alive(pid)
        runs.kill()
    until = time.monotonic() + 10
    while alive(pid) and time.monotonic() < until:
        time.sleep(0.02)
    assert not alive(pid)


def test_an_interrupted_run_ends_what_runs() -> None:
    found: list[Finished] = []
    thread = threading.Thread(target=lambda: found.append(ran("import time; time.sleep(600)", seconds=600)))
    thread.start()
    time.sleep(0.5)
    process.kill_running()
    thread.join(20)
    assert found[0].stopped == "warden" and found[0].seconds < 20
    assert ran("print(1)").stdout == b"1\n"


def test_a_program_that_kills_the_warden_is_told_apart_and_the_next_one_runs() -> None:
    assert ran("import os, signal; os.kill(os.getppid(), signal.SIGKILL)").stopped == "warden"
    assert ran("print(1)").code == 0


def test_output_is_cut_at_its_limit() -> None:
    finished = ran("while True: print('x' * 4096)", output_bytes=1000)
    assert (finished.stopped, finished.code, len(finished.stdout)) == ("output", None, 1000)
    finished = ran("import sys; sys.stderr.write('y' * (8 << 20))")
    assert (finished.stopped, finished.code, len(finished.stderr)) == ("", 0, process.STDERR_BYTES)


def test_memory_of_one_process_is_limited_by_the_kernel() -> None:
    if not LINUX:
        pytest.skip("only Linux limits private memory")
    finished = ran("x = bytearray(300 << 20)", memory_bytes=128 << 20)
    assert finished.code == 1 and b"MemoryError" in finished.stderr
    assert ran("x = bytearray(300 << 20); print(len(x))", memory_bytes=512 << 20).code == 0
    # No limit at all.
    assert ran("x = bytearray(300 << 20)", memory_bytes=0).code == 0


def test_memory_of_all_processes_together_is_limited_by_the_warden() -> None:
    if not LINUX:
        pytest.skip("only Linux tells what processes take")
    code = (
        "import os, time\nfor i in range(8):\n    if os.fork() == 0:\n        x = b'x' * (40 << 20)\n"
        "        time.sleep(60)\n        os._exit(len(x) & 1)\nos.wait()"
    )
    finished = ran(code, memory_bytes=128 << 20)
    assert (finished.stopped, finished.code) == ("memory", None) and finished.peak > 128 << 20


def test_a_file_has_a_limit() -> None:
    finished = ran(f"import os; open('big', 'wb').truncate({process.FILE_BYTES + 1})")
    assert finished.code == 1 and b"File too large" in finished.stderr


def test_a_program_runs_in_a_folder_of_its_own() -> None:
    code = "import os; open('left', 'w').close(); print(os.getcwd()); print(os.environ['TMPDIR'])"
    finished = ran(code)
    folder, temporary = finished.stdout.decode().splitlines()
    assert folder == temporary != str(Path.cwd())
    assert not Path(folder).exists()


def test_a_program_cannot_write_elsewhere(tmp_path: Path) -> None:
    if not fenced():
        pytest.skip("this kernel has no Landlock")
    (tmp_path / "there").write_text("old")
    for code in (
        "open('{}/new', 'w')", "open('{}/there', 'w')", "open('{}/there', 'r+').write('new')",
        "os.remove('{}/there')", "os.truncate('{}/there', 0)",
        "os.mkdir('{}/folder')", "open('a', 'w'); os.rename('a', '{}/a')", "os.symlink('a', '{}/link')",
    ):  # fmt: skip
        finished = ran("import os; " + code.format(tmp_path))
        assert finished.code == 1 and b"Error" in finished.stderr, code
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("there", "old")]
    # In its own folder all of it is allowed, and so are the devices.
    code = "import os; os.mkdir('b'); open('a', 'w'); os.rename('a', 'b/c'); os.remove('b/c'); open('/dev/null', 'w')"
    assert ran(code).code == 0


def test_folders_that_an_adapter_names_are_writable(tmp_path: Path) -> None:
    with room(Surroundings(writable=(str(tmp_path),))) as own:
        finished = own.run([*PYTHON, "-c", f"open({str(tmp_path / 'new')!r}, 'w').write('x')"], None, 20)
    assert finished.code == 0 and (tmp_path / "new").read_text() == "x"


def test_a_copy_of_the_input_is_given(tmp_path: Path) -> None:
    source = tmp_path / "vector.fba"
    source.write_bytes(b"abc")
    with room(Surroundings()) as own:
        copied = own.put(source)
        assert copied.name == source.name and copied.is_relative_to(own.folder)
        finished = own.run([*PYTHON, "-c", f"open({str(copied)!r}, 'a').write('d')"], None, 20)
    assert finished.code == 0 and source.read_bytes() == b"abc" and not copied.exists()


def test_the_environment_is_the_documented_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SECRET_TOKEN", "x")
    monkeypatch.setenv("PYTHONPATH", "/nowhere")
    monkeypatch.setenv("LC_TIME", "C")
    monkeypatch.setenv("LICENCE", "yes")
    around = Surroundings(variables={"MODE": "fast", "LANG": "C"}, passed=("LICENCE", "NOT_THERE"))
    with room(around) as own:
        finished = own.run([*PYTHON, "-c", "import os; print('\\n'.join(sorted(os.environ)))"], None, 20)
    names = set(finished.stdout.decode().split())
    assert {"LC_TIME", "LICENCE", "MODE", "LANG", "TMPDIR", "PATH"} <= names
    assert names <= {*process.PASSED, "LC_TIME", "LC_CTYPE", "LC_ALL", "LICENCE", "MODE", "TMPDIR", "TMP", "TEMP"}


def test_no_descriptor_is_inherited() -> None:
    read, write = os.pipe()
    os.set_inheritable(write, True)
    try:
        # 3 is that of the listing itself.
        code = "import os; print(sorted(map(int, os.listdir('/dev/fd'))))"
        assert ran(code).stdout == b"[0, 1, 2, 3]\n"
    finally:
        os.close(read)
        os.close(write)


def test_standard_input_is_a_file_or_empty(tmp_path: Path) -> None:
    source = tmp_path / "in"
    source.write_bytes(b"abc")
    command = [*PYTHON, "-c", "import sys; print(len(sys.stdin.read()))"]
    assert run(command, source, seconds=20, output_bytes=100).stdout == b"3\n"
    assert run(command, None, seconds=20, output_bytes=100).stdout == b"0\n"


def test_a_program_that_is_not_there() -> None:
    with pytest.raises(FileNotFoundError, match="no-such-program"):
        run(["no-such-program"], None, seconds=1, output_bytes=1)
    assert ran("print(1)").code == 0


def test_wardens_are_used_again_and_end() -> None:
    process.close()
    with room(Surroundings()) as first:
        warden = first.warden
    with room(Surroundings()) as second:
        assert second.warden is warden
        with room(Surroundings()) as third:
            assert third.warden is not warden
    root = warden.root
    process.close()
    assert not root.exists()
