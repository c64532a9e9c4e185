"""Decoders that a child process of ours holds: Python callables, entry points, shared libraries.

Rules: CNF-11, CNF-12.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from snhc.conformance.adapters import Persistent, host, load
from snhc.conformance.adapters.base import Claims
from snhc.conformance.adapters.session import Session
from snhc.conformance.runner import Result, run
from snhc.vectors.manifest import SUITE, Entry, Manifest
from snhc.vectors.manifest import load as load_manifest

ROOT = Path(__file__).parents[2]
HEADER = ROOT / "conformance" / "c" / "snhc_decoder.h"
VALID = "fap.arith.example.1"
INVALID = "fba.error.time-code.hours-24"
MANIFEST = load_manifest(check_schema=False)
ENTRIES = {entry.id: entry for entry in MANIFEST.entries}


def _results(adapter: Persistent, *ids: str) -> list[Result]:
    return list(run(Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids)), [adapter]).results)


def test_a_question_that_cannot_be_put_leaves_no_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[Session] = []
    real = Session.close
    monkeypatch.setattr(Session, "close", lambda self: (closed.append(self), real(self))[1])

    def exceeded(self: Claims, entry: Entry, path: Path, aux: Path | None) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(Claims, "exceeded", exceeded)
    (tmp_path / "own.py").write_text("def decode(request):\n    return ''\n")
    (tmp_path / "own.toml").write_text('object = "own:decode"\n')
    adapter = load(tmp_path / "own.toml")
    assert isinstance(adapter, Persistent)
    entry = ENTRIES[VALID]
    with pytest.raises(KeyboardInterrupt):
        adapter.decode(entry, SUITE / entry.file)
    assert len(closed) == 1


def _statuses(adapter: Persistent, *ids: str) -> tuple[str, ...]:
    return tuple(result.status for result in _results(adapter, *ids))


# -- Python ------------------------------------------------------------------------------------------------------------

MODULE = '''
import ctypes, json, os, sys, time

SUITE = {suite!r}
HEADER = '{{"format":"snhc-decoded","version":1,"kind":"fba"}}\\n'


class NotOurs(Exception):
    def __init__(self, said):
        self.snhc_error = said


def as_text(request):
    """The right text, found by the name of the input."""
    print("decoding", request.path)
    name = os.path.basename(request.path)
    if "error" in name:
        raise NotOurs({{"class": "ForbiddenValue"}})
    return open(SUITE + "/fap/" + name.replace(".fba", ".ndjson")).read()


def as_objects(request):
    assert len(request.data) > 8 and request.aux is None and request.media == "fba" and request.format == "ndjson"
    for line in as_text(request).splitlines():
        yield json.loads(line)


def rejects_with_ours(request):
    from snhc.conformance.decoders import Rejected
    raise Rejected("ForbiddenValue", (4, 5))


def breaks(request):
    raise ZeroDivisionError("no such plane")


def breaks_half_way(request):
    yield HEADER
    raise ZeroDivisionError("no such plane")


def leaves(request):
    sys.exit(1)


def dies(request):
    ctypes.string_at(0)


def hangs(request):
    time.sleep(600)


def gives_a_number(request):
    return 5


def unsupported(request):
    raise NotOurs({{"class": "Unsupported"}})


def closes_stdin(request):
    sys.stdin.close()
    return HEADER


def prints(request):
    sys.stdout.write("not a message\\n")
    os.write(1, b"neither\\n")
    return as_text(request)


class Capable:
    capabilities = {{"tools": ["fba"], "kinds": ["valid"], "options": ["object"]}}

    def __call__(self, request):
        return as_text(request)


capable = Capable()
nothing = None
'''


@pytest.fixture(scope="module")
def python_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("package")
    (folder / "decoders_of_a_test.py").write_text(MODULE.format(suite=str(SUITE)))
    information = folder / "decoders_of_a_test-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: decoders-of-a-test\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(
        "[snhc.decoders]\nright = decoders_of_a_test:as_text\nlost = decoders_of_a_test:not_there\n"
    )
    return folder


def _python(python_path: Path, key: str, value: str, timeout: float = 20.0) -> Persistent:
    path = python_path / "adapter.toml"
    path.write_text(f'{key} = "{value}"\nenvironment = {{ PYTHONPATH = "{python_path}" }}\ntimeout = {timeout}\n')
    adapter = load(path)
    assert isinstance(adapter, Persistent)
    return adapter


OBJECTS = {
    # name: status on a valid and an invalid vector
    "as_text": ("pass", "pass"),
    "as_objects": ("pass", "pass"),
    "prints": ("pass", "pass"),
    "rejects_with_ours": ("fail", "fail"),
    "breaks": ("crash", "crash"),
    "breaks_half_way": ("crash", "crash"),
    "leaves": ("crash", "crash"),
    "dies": ("crash", "crash"),
    "gives_a_number": ("crash", "crash"),
    "unsupported": ("not_applicable", "not_applicable"),
    "closes_stdin": ("crash", "crash"),
    "capable": ("pass", "not_applicable"),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_python_objects(python_path: Path, name: str) -> None:
    assert _statuses(_python(python_path, "object", f"decoders_of_a_test:{name}"), VALID, INVALID) == OBJECTS[name]


def test_a_python_decoder_that_hangs_is_stopped(python_path: Path) -> None:
    assert _statuses(_python(python_path, "object", "decoders_of_a_test:hangs", 0.7), VALID) == ("timeout",)


def test_entry_points(python_path: Path) -> None:
    assert _statuses(_python(python_path, "decoder", "right"), VALID, INVALID) == ("pass", "pass")


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("decoder", "wrong", "no entry point 'wrong' in the group snhc.decoders; there are: lost, right"),
        ("decoder", "lost", "entry point lost does not load"),
        ("object", "no_such_module:x", "No module named 'no_such_module'"),
        ("object", "decoders_of_a_test:absent", "has no attribute 'absent'"),
        ("object", "decoders_of_a_test:nothing", "cannot be called"),
    ],
)
def test_a_decoder_that_does_not_load_says_why(python_path: Path, key: str, value: str, words: str) -> None:
    result = _results(_python(python_path, key, value), VALID)[0]
    assert result.status == "error" and words in result.reason


def test_the_host_needs_nothing_but_the_standard_library() -> None:
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(Path(host.__file__)), "--object", "no_module:x"],
        input='{"seq":1,"type":"hello","protocol":"snhc-adapter","version":1,"readings":{}}\n', text=True,
        capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 5 and "No module named 'no_module'" in done.stderr


# -- C -----------------------------------------------------------------------------------------------------------------


@pytest.fixture
def compiler() -> str:
    found = shutil.which("cc")
    if found is None:
        pytest.skip("no C compiler")
    return found


def _library(folder: Path, compiler: str, body: str) -> Persistent:
    (folder / "decoder.c").write_text(f'#include "{HEADER}"\n#include <stdio.h>\n#include <string.h>\n{body}')
    subprocess.run(
        [compiler, "-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-o",
         str(folder / "decoder.so"), str(folder / "decoder.c")], check=True,
    )  # fmt: skip
    path = folder / "adapter.toml"
    path.write_text('library = "decoder.so"\ntimeout = 20\n')
    adapter = load(path)
    assert isinstance(adapter, Persistent)
    return adapter


ABI = """
uint32_t snhc_abi_version(void) { return SNHC_ABI_VERSION; }
const char *snhc_describe(void) { return "{\\"tools\\":[\\"fba\\"],\\"options\\":[\\"limit\\",\\"object\\"]}"; }
"""


def _decode(statements: str) -> str:
    return ABI + (
        "int snhc_decode(const snhc_request *r, snhc_write write, void *context, snhc_rejection *why)\n"
        "{\n    (void)r; (void)write; (void)context; (void)why;\n" + statements + "\n}\n"
    )


def test_the_structures_are_those_of_the_header(tmp_path: Path, compiler: str) -> None:
    structures = {
        "snhc_limit": host.Limit, "snhc_reading": host.Reading, "snhc_request": host.Request,
        "snhc_rejection": host.Rejection,
    }  # fmt: skip
    lines = [f'#include "{HEADER}"', "#include <stdio.h>", "int main(void) {", 'printf("%d\\n", SNHC_ABI_VERSION);']
    expected = [host.ABI_VERSION]
    for name, structure in structures.items():
        lines.append(f'printf("%zu\\n", sizeof({name}));')
        expected.append(ctypes.sizeof(structure))
        for field, *_ in structure._fields_:
            lines.append(f'printf("%zu %zu\\n", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));')
            place = getattr(structure, field)
            expected += [place.offset, place.size]
    (tmp_path / "sizes.c").write_text("\n".join([*lines, "return 0; }"]))
    subprocess.run([compiler, "-o", str(tmp_path / "sizes"), str(tmp_path / "sizes.c")], check=True)
    printed = subprocess.run([str(tmp_path / "sizes")], capture_output=True, text=True, check=True).stdout
    assert list(map(int, printed.split())) == expected


def test_the_header_is_cplusplus_too(tmp_path: Path) -> None:
    if shutil.which("c++") is None:
        pytest.skip("no C++ compiler")
    (tmp_path / "x.cpp").write_text(f'#include "{HEADER}"\nint main() {{ return SNHC_ACCEPTED; }}\n')
    command = ["c++", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only", str(tmp_path / "x.cpp")]
    subprocess.run(command, check=True)


LIBRARIES = {
    "header_only": (
        'const char *t = "{\\"format\\":\\"snhc-decoded\\",\\"version\\":1,\\"kind\\":\\"fba\\"}\\n";\n'
        "printf(\"noise\\n\"); fflush(stdout);\nif (r->data[0] != 0 || r->size < 8) return 9;\n"
        "if (write(context, t, 10) || write(context, t + 10, strlen(t) - 10)) return 9;\nreturn SNHC_ACCEPTED;",
        ("fail", "fail"),
    ),
    "rejects": (
        'strcpy(why->error_class, "ForbiddenValue"); why->has_bits = 1; why->first_bit = 0; why->end_bit = 4000;\n'
        "return SNHC_REJECTED;",
        ("fail", "pass"),
    ),
    "rejects_silently": ("return SNHC_REJECTED;", ("fail", "pass")),
    "another_code": ("return 7;", ("crash", "crash")),
    "null_pointer": ("volatile int *p = 0; return *p;", ("crash", "crash")),
    "not_utf8": ('write(context, "\\xff\\xfe\\n", 3); return SNHC_ACCEPTED;', ("error", "fail")),
    "prints_nothing": ("return SNHC_ACCEPTED;", ("error", "fail")),
    "unsupported": ('strcpy(why->error_class, "Unsupported"); return 1;', ("not_applicable", "not_applicable")),
}  # fmt: skip


@pytest.mark.parametrize("name", LIBRARIES)
def test_libraries(tmp_path: Path, compiler: str, name: str) -> None:
    statements, expected = LIBRARIES[name]
    assert _statuses(_library(tmp_path, compiler, _decode(statements)), VALID, INVALID) == expected


def test_a_library_gets_options_limits_and_readings(tmp_path: Path, compiler: str) -> None:
    says = (
        'snprintf(why->path, sizeof why->path, "%s %s %u %d%d %s=%d %s=%s", r->media, r->format, r->object, r->draft,\n'
        '    r->strict, r->limit_count ? r->limits[0].name : "none", r->limit_count ? (int)r->limits[0].value : 0,\n'
        "    r->readings[0].ambiguity, r->readings[0].key);\nwhy->line = (unsigned)r->struct_bytes;\nreturn 1;"
    )
    adapter = _library(tmp_path, compiler, _decode(says))
    adapter = replace(adapter, claims=replace(adapter.claims, readings={"AMB-FBA-6": "before"}))
    said = []
    for id in ("fba.error.limit.skipped-frames", "fba.framing.objects.second-of-two"):
        said.append(adapter.decode(ENTRIES[id], SUITE / ENTRIES[id].file).stderr.decode())
    adapter.close()
    size = ctypes.sizeof(host.Request)
    assert said == [
        f'{{"line": {size}, "path": "fba ndjson 0 00 skipped_frames=40 AMB-FBA-6=before"}}\n',
        f'{{"line": {size}, "path": "fba ndjson 1 00 none=0 AMB-FBA-6=before"}}\n',
    ]


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("int other;", "undefined symbol: snhc_abi_version"),
        (_decode("return 0;").replace("return SNHC_ABI_VERSION", "return 99"), "has ABI version 99, this is 1"),
        (_decode("return 0;").replace('\\"tools\\"', "tools"), "snhc_describe gives no JSON"),
    ],
)
def test_a_library_that_does_not_fit_says_why(tmp_path: Path, compiler: str, body: str, words: str) -> None:
    result = _results(_library(tmp_path, compiler, body), VALID)[0]
    assert result.status == "error" and words in result.reason


def test_a_library_that_is_not_there() -> None:
    path = Path(__file__).parent / "no-such.so"
    adapter = Persistent("none", (sys.executable, "-I", "-S", host.__file__, "--library", str(path)))
    result = _results(adapter, VALID)[0]
    assert result.status == "error" and "no-such.so" in result.reason
