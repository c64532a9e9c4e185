"""Build the example decoders and compare them, with cases and with each other.

Rules: CNF-1, CNF-7, CNF-9, CNF-21. Standard library only; run as a script:

    python tests/interop/check_examples.py [FOLDER ...] [--mutants N] [--seed S] [--keep DIR]

A folder holds cases (`case.json` and what it names: input, `expected.ndjson`, for rejects `expected.json`), at any
depth; only those of kind fba and the fba ones of kind neg are taken, and the streams of the worked examples are
always there. Prints a matrix; exit code 1 if a decoder disagrees with a case or with another decoder, 2 if none could
be built. A decoder whose compiler is not installed is printed as `not run: ...`.

`--mutants N`: N times one to three bits of a stream are flipped, and the decoders are compared among themselves;
`--keep DIR` stores the streams they do not agree on.
"""

# ruff: noqa: T201 (a script whose output is the matrix)
from __future__ import annotations

import argparse
import json
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

HERE: Final = Path(__file__).resolve().parent
EXAMPLES: Final = HERE.parents[1] / "conformance" / "examples"
SAMPLES: Final = HERE.parent / "fixtures" / "samples"
TIMEOUT: Final = 30.0
MUTATED_BYTES: Final = 8192
HEADERS: Final = ("000001b061000001b523", "000001b063000001b59147", "000001b061000001b241000001b523")

# The worked examples FBA-EX-1..4: the stream, and per plane what it says of some FAPs (null: no value).
WORKED: Final[dict[str, tuple[str, list[dict[str, Any]]]]] = {
    "FBA-EX-1": (
        "000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1",
        [
            {"time": "0/1", "intra": True, "faps": {3: 100, 48: -3400}},
            {"time": "1/25", "intra": False, "faps": {3: 140, 48: -1700}},
            {"time": "2/25", "intra": False, "faps": {3: 140, 48: 170}},
        ],
    ),
    "FBA-EX-2": (
        "000001bab1900192492e92000000049405172f000001b1",
        [
            {"time": "0/1", "intra": True, "faps": {48: 316200, 49: 316200, 50: None}},
            {"time": "1/25", "intra": False, "faps": {48: 315690, 49: 316540, 50: None}},
        ],
    ),
    "FBA-EX-3": (
        "000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1",
        [
            {
                "viseme": {"select1": 4, "select2": 7, "blend": 40, "def": 1},
                "expression": {
                    "select1": 1, "intensity1": 50, "select2": 3, "intensity2": 10, "init_face": 1, "def": 0,
                },
                "faps": {3: 400},
            },
            {
                "viseme": {"select1": 7, "select2": 0, "blend": 32, "def": 0},
                "expression": {
                    "select1": 1, "intensity1": 48, "select2": 6, "intensity2": 34, "init_face": 0, "def": 1,
                },
                "faps": {3: 344},
            },
        ],
    ),
    "FBA-EX-4": (
        "000001baa032c0004d01279200fd9f553f600a7e49fe9483ff7ff2a032a0004c81249201028d85019a000249249007e97f000001b1",
        [
            {"faps": {3: 40, 4: None, 31: 40, 32: None, 48: 170, 49: -170, 50: 340}},
            {"faps": {3: 44, 4: None, 31: 30, 32: None, 48: 170, 49: -170, 50: 0}},
            {"faps": {3: 44, 4: -12, 31: None, 32: 16, 48: 170, 49: -170, 50: 0}},
            {"time": "1/10", "faps": {3: 48, 4: None, 31: 30, 32: 16, 33: None, 48: 170, 49: -170, 50: 0}},
        ],
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What a decoder said. `fault`: "" (accepted), class and span, or what else happened."""

    fault: str
    bits: tuple[int, int] | None
    lines: tuple[str, ...]

    @property
    def error_class(self) -> str:
        return self.fault.split(" ")[0]


@dataclass(frozen=True)
class Case:
    name: str
    data: bytes
    check: Callable[[Answer], str]  # "" or what is wrong


@dataclass
class Decoder:
    name: str
    needs: str
    build: Callable[[Path, Path], list[list[str]]]
    command: Callable[[Path, Path], list[str]]
    words: list[str] = field(default_factory=list)
    missing: str = ""

    def make(self, work: Path) -> None:
        """Build into a folder of its own, so that the sources stay as they are."""
        if shutil.which(self.needs) is None:
            self.missing = f"{self.needs} is not installed"
            return
        source, out = EXAMPLES / self.name, work / self.name
        out.mkdir()
        for command in self.build(source, out):
            done = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise SystemExit(f"{self.name}: {' '.join(command)} failed\n{done.stdout}{done.stderr}")
        self.words = self.command(source, out)

    def decode(self, path: Path) -> Answer:
        try:
            done = subprocess.run([*self.words, str(path)], capture_output=True, timeout=TIMEOUT, check=False)
        except subprocess.TimeoutExpired:
            return Answer("timeout", None, ())
        lines = tuple(done.stdout.decode("utf-8", "replace").splitlines())
        if done.returncode == 0:
            return Answer("", None, lines)
        if done.returncode != 1:
            return Answer(f"crash {done.returncode} {done.stderr[-200:]!r}", None, lines)
        try:
            told = json.loads(done.stderr)
            bits = (int(told["bits"][0]), int(told["bits"][1]))
            return Answer(f"{told['class']} [{bits[0]}, {bits[1]})", bits, lines)
        except (ValueError, KeyError, TypeError, IndexError):
            return Answer(f"crash 1 {done.stderr[-200:]!r}", None, lines)


def decoders() -> list[Decoder]:
    return [
        Decoder(
            "c", "cc", lambda _, out: [["make", "-s", f"BUILD={out}"]], lambda _, out: [str(out / "fba_decoder")]
        ),
        Decoder(
            "rust", "cargo",
            lambda _, out: [["cargo", "build", "-q", "--release", "--offline", "--locked", "--target-dir", str(out)]],
            lambda _, out: [str(out / "release" / "fba-decoder")],
        ),
        Decoder(
            "go", "go",
            lambda _, out: [["go", "build", "-o", str(out / "fba-decoder"), "."]],
            lambda _, out: [str(out / "fba-decoder")],
        ),
        Decoder(
            "javascript", "node", lambda *_: [], lambda source, _: ["node", str(source / "fba-decoder.mjs")]
        ),
    ]  # fmt: skip


def _holds(expected: Any, found: Any) -> bool:
    if isinstance(expected, dict):
        return isinstance(found, dict) and all(k in found and _holds(v, found[k]) for k, v in expected.items())
    return type(expected) is type(found) and bool(expected == found)


def _parsed(lines: Iterable[str]) -> list[Any]:
    return [json.loads(line) for line in lines]


def _sample(folder: Path, case: dict[str, Any]) -> Case:
    expected = _parsed((folder / "expected.ndjson").read_text(encoding="utf-8").splitlines())
    reject = case["expect"] == "reject"
    fault = json.loads((folder / "expected.json").read_text(encoding="utf-8")) if reject else {}
    unsupported = str(case.get("profile", "")).startswith("dct")

    def check(answer: Answer) -> str:
        if unsupported:
            return "" if answer.error_class == "Unsupported" else f"{answer.fault or 'accepted'}, not Unsupported"
        if not reject and answer.fault:
            return answer.fault
        if reject and answer.error_class != fault["class"]:
            return f"{answer.fault or 'accepted'}, not {fault['class']} {fault['bits']}"
        if reject and answer.bits is not None:
            first, end = answer.bits
            if not (first < fault["bits"][1] and fault["bits"][0] < end):
                return f"{answer.fault} misses {fault['bits']}"
        found = _parsed(answer.lines)
        if found[:1] != expected[:1]:
            return f"header {found[:1]}"
        if len(found) != (case["lines"] + 1 if expected else 0):
            return f"{len(found) - 1} lines, not {case['lines']}"
        by_index = {line["index"]: line for line in found[1:]}
        for line in expected[1:]:
            if not _holds(line, by_index.get(line["index"])):
                return f"line {line['index']} differs"
        return ""

    return Case(folder.name, (folder / case["input"]).read_bytes(), check)


def _worked(name: str, data: str, planes: list[dict[str, Any]]) -> Case:
    def check(answer: Answer) -> str:
        if answer.fault:
            return answer.fault
        found = _parsed(answer.lines)[1:]
        if len(found) != len(planes):
            return f"{len(found)} planes, not {len(planes)}"
        for index, (plane, line) in enumerate(zip(planes, found, strict=True)):
            faps = {number: line["faps"][number - 1] for number in plane["faps"]}
            if not _holds({**plane, "faps": faps}, {**line, "faps": faps}) or faps != plane["faps"]:
                return f"plane {index} differs"
        return ""

    return Case(name, bytes.fromhex(data), check)


def cases(folders: Iterable[Path]) -> Iterator[Case]:
    for name, (data, planes) in WORKED.items():
        yield _worked(name, data, planes)
    for folder in folders:
        for path in sorted(folder.rglob("case.json")):
            case = json.loads(path.read_text(encoding="utf-8"))
            if case["kind"] in ("fba", "neg") and case.get("media") == "fba":
                yield _sample(path.parent, case)


def disagreement(answers: dict[str, Answer]) -> str:
    """What the decoders said differently of one stream, "" if they agree: fault, span and output, all but spelling."""
    if len(set(answers.values())) <= 1:
        return ""
    said = {name: (answer.fault, _parsed(answer.lines)) for name, answer in answers.items()}
    first = next(iter(said.values()))
    if all(one == first for one in said.values()):
        return ""
    return "; ".join(f"{name}: {fault or 'accepted'}, {len(lines)} lines" for name, (fault, lines) in said.items())


def mutants(streams: list[bytes], count: int, seed: int) -> Iterator[bytes]:
    """Copies of the streams with one to three flipped bits, every fourth behind a sequence header, some cut short."""
    chance = random.Random(seed)
    for number in range(count):
        data = bytearray(chance.choice(streams))
        if number % 4 == 0 and data[:4] == b"\x00\x00\x01\xba":
            data[:0] = bytes.fromhex(chance.choice(HEADERS))
        if len(data) < 5:
            data += bytes(5 - len(data))
        top = min(len(data) * 8, 400) if chance.random() < 0.5 else len(data) * 8
        for _ in range(chance.randint(1, 3)):
            at = chance.randrange(0 if number % 8 == 7 else 32, max(top, 33))
            data[at // 8] ^= 0x80 >> at % 8
        if number % 16 == 1:
            del data[chance.randrange(len(data)) :]
        yield bytes(data)


def main() -> int:
    parser = argparse.ArgumentParser(description="compare the example decoders with cases and with each other")
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--mutants", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folders: list[Path] = options.folders or [SAMPLES]
    bad = 0
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(2) as pool:
        work = Path(name)
        built: list[Decoder] = []
        for decoder in decoders():
            decoder.make(work)
            if decoder.missing:
                print(f"not run: {decoder.name}: {decoder.missing}")
            else:
                built.append(decoder)
        if not built:
            return 2

        def ask(data: bytes, number: int) -> dict[str, Answer]:
            path = work / f"{number}.fba"
            path.write_bytes(data)
            answers = {one.name: one.decode(path) for one in built}
            path.unlink()
            return answers

        every = list(cases(folders))
        print(f"{'case':16}" + "".join(f"{one.name:>12}" for one in built))
        for case, answers in zip(every, pool.map(ask, [one.data for one in every], range(len(every))), strict=True):
            wrong = {name: case.check(answer) for name, answer in answers.items()}
            print(f"{case.name:16}" + "".join(f"{'DIFFERS' if wrong[one.name] else 'ok':>12}" for one in built))
            for name, text in wrong.items():
                if text:
                    bad += 1
                    print(f"    {name}: {text}")
            if text := disagreement(answers):
                bad += 1
                print(f"    {text}")
        streams = [one.data for one in every if len(one.data) <= MUTATED_BYTES]
        tried = list(mutants(streams, options.mutants, options.seed))
        faults: dict[str, int] = {}
        apart = 0
        for number, answers in enumerate(pool.map(ask, tried, range(len(tried)))):
            text = disagreement(answers)
            crashed = [one for one in answers.values() if one.error_class in ("crash", "timeout")]
            if text or crashed:
                apart += 1
                print(f"mutant {number}: {text or crashed[0].fault}")
                if options.keep:
                    options.keep.mkdir(parents=True, exist_ok=True)
                    (options.keep / f"mutant-{options.seed}-{number}.fba").write_bytes(tried[number])
            said = answers[built[0].name].error_class or "accepted"
            faults[said] = faults.get(said, 0) + 1
        print(f"{len(every)} cases, {len(built)} decoders, {bad} disagreements")
        if tried:
            counted = ", ".join(f"{name} {count}" for name, count in sorted(faults.items()))
            print(f"{len(tried)} mutants, {apart} disagreements: {counted}")
    return 1 if bad or apart else 0


if __name__ == "__main__":
    sys.exit(main())
