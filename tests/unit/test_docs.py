"""The documentation: every command in it is run, every file it names by a path is there, the register has pages.

A page's commands run in order in one folder that holds a few files of the names the pages use. A command that begins
with another program than snhc must be one of OTHERS, where it is said what runs it.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from snhc.conformance.cli import snhc
from snhc.reference_impl.rules import ambiguities, findings, rules
from snhc.reference_impl.systems.stream import write_stream
from snhc.vectors.builders import inter, intra, stream
from snhc.vectors.manifest import SUITE

TOP = Path(__file__).parents[2]
PAGES = [TOP / "README.md", *sorted((TOP / "docs").glob("*.md"))]
# Beginnings of lines that are not run here, and what runs them.
OTHERS = {
    "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/snhc run": "CI, and every test of the verb",
    "python3 -m venv .venv && .venv/bin/pip install tox && .venv/bin/tox": "CI",
    "snhc generate --check": "tox, which is why it is not done twice",
    "snhc generate --suite vectors/suite": "for a checkout; tests/unit/test_vectors.py",
    "snhc coverage --update": "for a checkout; tests/unit/test_coverage_book.py",
    "snhc run my-decoder.toml --cluster": "tests/cluster",
    "pytest my-decoder.toml::": "tests/unit/test_own_ci.py",
    "pytest --snhc-adapter my-decoder.toml": "tests/unit/test_own_ci.py, in a project of its own",
    "python own_vectors.py": "tests/unit/test_own_vectors.py",
    "snhc run my-decoder.toml --suite own-suite": "tests/unit/test_own_vectors.py",
    "snhc generate --suite own-suite --export own-export": "tests/unit/test_own_vectors.py",
}
# Verbs whose 1 is an answer, not a fault; and the one that needs a terminal.
ANSWERS = {"run": {0, 1}, "diff": {0, 1}, "check": {0, 1}, "browse": {2}, "report": {0, 1}, "minimize": {0, 1}}


def commands(page: Path) -> Iterator[str]:
    """The lines of the shell blocks of a page, continued lines as one."""
    for block in re.findall(r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
        if block.startswith("#!"):
            continue  # a script, not commands
        for line in block.replace("\\\n", " ").splitlines():
            if line.strip() and not line.lstrip().startswith("#"):
                yield line.strip()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files that the pages speak of."""
    first = intra({3: 100, 48: -3}, quant=2, rate=(25, 0, 0))
    planes = [first, *(inter(first, {3: n % 5 - 2, 48: 1}) for n in range(40))]
    monkeypatch.chdir(tmp_path)
    for name in ("speech.fba", "a.fba"):
        Path(name).write_bytes(write_stream(stream(*planes)))
    Path("b.fba").write_bytes(write_stream(stream(*planes[:-1])))
    for target in ("speech.fap", "decoder1.ndjson", "decoder2.ndjson"):
        assert CliRunner().invoke(snhc, ["decode", "speech.fba", "--quiet", "-o", target]).exit_code == 0
    mesh = SUITE / "mesh" / "mesh.example.1.m2d"
    Path("mesh.m2d").write_bytes((mesh if mesh.exists() else next((SUITE / "mesh").glob("*.m2d"))).read_bytes())
    from PIL import Image

    Image.effect_mandelbrot((64, 48), (-2, -1, 1, 1), 40).convert("RGB").save("photo.png")
    page = (TOP / "docs" / "check.md").read_text(encoding="utf-8")
    Path("box.toml").write_text(page.partition("```toml\n")[2].partition("```")[0])
    # A decoder that answers quickly: the reference, in a process of its own.
    Path("my_decoder.py").write_text(
        "from snhc.reference_impl.bitstream.errors import SnhcError\n"
        "from snhc.reference_impl.face.decoded import ndjson\n"
        "from snhc.reference_impl.systems.stream import decode_frames\n"
        "class Rejected(Exception):\n"
        "    snhc_error = {}\n"
        "def decode(request):\n"
        "    try:\n"
        "        yield from ndjson(decode_frames(request.data))\n"
        "    except SnhcError as error:\n"
        "        fault = Rejected()\n"
        "        fault.snhc_error = error.as_json()\n"
        "        raise fault from error\n"
    )
    ledger = (TOP / "docs" / "running.md").read_text(encoding="utf-8")
    Path("known.toml").write_text(ledger.partition("```toml\n")[2].partition("```")[0])
    Path("traces").mkdir()
    # One that is wrong: it cuts head_pitch off.
    Path("clips.py").write_text(
        "import json, sys\n"
        "from snhc.vectors.decoding import decode\n"
        "from snhc.reference_impl.systems.stream import Options\n"
        "for line in decode(open(sys.argv[1], 'rb').read(), Options()).lines:\n"
        "    frame = json.loads(line)\n"
        "    if 'faps' in frame and (frame['faps'][47] or 0) < -200:\n"
        "        frame['faps'][47] = -200\n"
        "    print(json.dumps(frame))\n"
    )
    Path("clips.toml").write_text(f'command = ["{sys.executable}", "clips.py", "{{input}}"]\n')
    Path("my-decoder.toml").write_text(
        'name = "my decoder"\nobject = "my_decoder:decode"\n'
        f"interpreter = {sys.executable!r}\nenvironment = {{ PYTHONPATH = {str(tmp_path)!r} }}\n".replace("'", '"')
    )
    return tmp_path


# A run of the whole suite writes nothing: one is enough for all pages of this process.
_DONE: set[str] = set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_works(page: Path, folder: Path) -> None:
    for line in commands(page):
        words = shlex.split(line, comments=True)
        if any(line.startswith(other) for other in OTHERS) or " ".join(words) in _DONE:
            continue
        if words[1:2] == ["run"] and "-o" not in words:
            _DONE.add(" ".join(words))
        assert words[0] == "snhc", f"{page.name}: not run, and not said why: {line}"
        result = CliRunner().invoke(snhc, words[1:])
        allowed = ANSWERS.get(words[1], {0})
        assert result.exit_code in allowed, f"{page.name}: {line}\n{result.output[-2000:]}"
        assert result.exception is None or isinstance(result.exception, SystemExit)


def test_the_example_in_python_works(folder: Path) -> None:
    for page in PAGES:
        for block in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            exec(compile(block, page.name, "exec"), {"__name__": "example"})


def test_what_is_not_run_is_still_there() -> None:
    lines = [line for page in PAGES for line in commands(page)]
    for other in OTHERS:
        assert any(line.startswith(other) for line in lines), f"no page says {other}"


def test_pictures_and_pages_that_are_named_exist() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]*)[^)]*\)", page.read_text(encoding="utf-8")):
            if target and "://" not in target and not target.startswith("generated/"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_register_becomes_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(TOP / "docs"))
    from register_pages import write_pages

    stale = tmp_path / "rules-OLD.md"
    stale.write_text("old")
    write_pages(tmp_path)
    assert not stale.exists()
    text = "\n".join(path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md"))
    for id in (*rules(), *ambiguities()):
        assert f"\n({id.lower()})=\n" in text
        assert f"\n## {id}" in text
    for id in findings():
        assert f"| `{id}` |" in text
    # Links lead to what there is.
    for name, anchor in re.findall(r"\]\(([\w-]+\.md)#([\w-]+)\)", text):
        assert f"({anchor})=" in (tmp_path / name).read_text(encoding="utf-8")
    assert "](rules-FBA.md#fba-26)" in text
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.md")}
    write_pages(tmp_path)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.md")} == before
