"""Fuzz one target: `python tests/fuzz/one.py TARGET -runs=20000 [FOLDER OF INPUTS]`.

Pure form: guided by atheris. `--plain`: unguided, the mutations of `structure` and of bytes alone, which is how the
compiled form is fuzzed (atheris does not see into it), also with the address sanitizer. `--report FILE`: what was done,
as JSON.

A finding ends the run; the input is written to the folder of `-artifact_prefix`. It is then kept as a named file in
tests/fuzz_findings/, which tests/unit/test_fuzz_findings.py replays.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path
from random import Random

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent)]

# What an input may cost at the least before it is called slow: a clock has its own grain.
GRAIN = 0.05
TIMES = 10
SANITIZED = "asan" in os.environ.get("LD_PRELOAD", "")
# Long inputs of one repeated part: one for so many others.
PUMPS_SHARE = 250
PUMPS_AT_LEAST = 60
# Seconds after which an input is given up.
STUCK = 60
# What a process may hold in all, by far the largest part of it the fuzzer and the seeds.
MOST_MB = 1024


class Slow(Exception):
    """An input took more than TIMES the time of valid ones of its size."""


class Stuck(BaseException):
    """An input does not come to an end."""


class Large(Exception):
    """An input took more memory than all limits together allow."""


def peak_mb() -> float:
    """The largest resident set of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Meter:
    """Counts inputs and holds their times against those of the seeds."""

    def __init__(self, law: object, seeds: list[bytes]) -> None:
        self._law = law
        self.inputs = 0
        self.slowest = 0.0
        self.ratio = 0.0
        # A fixed part and a part per byte, both of the slowest seed.
        times = [(len(seed), min(self._timed(seed) for _ in range(3))) for seed in seeds]
        self._fixed = max((spent for _, spent in times), default=0.0)
        self._per_byte = max((spent / max(size, 16) for size, spent in times), default=0.0)

    def _timed(self, data: bytes) -> float:
        started = time.process_time()
        self._law(data)  # type: ignore[operator]
        return time.process_time() - started

    def __call__(self, data: bytes) -> None:
        spent = self._timed(data)
        self.inputs += 1
        allowed = max(GRAIN, self._fixed + self._per_byte * len(data))
        if spent > self.slowest:
            self.slowest = spent
        if spent > TIMES * allowed:
            # A busy machine is no finding.
            spent = min(spent, *(self._timed(data) for _ in range(3)))
            if spent > TIMES * allowed:
                raise Slow(f"{spent:.3f} s for {len(data)} bytes; valid inputs of this size take {allowed:.4f} s")
        self.ratio = max(self.ratio, spent / allowed)
        # Under the address sanitizer nothing that is freed goes back for a while.
        if not SANITIZED and peak_mb() > MOST_MB:
            raise Large(f"{peak_mb():.0f} MB after {len(data)} bytes; at most {MOST_MB} are allowed")


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("target")
    parser.add_argument("--plain", action="store_true")
    parser.add_argument("--report", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    options, rest = parser.parse_known_args()
    if not options.plain:
        import atheris

        with atheris.instrument_imports(include=["snhc"]):
            from targets import TARGETS
    else:
        from targets import TARGETS
    from structure import pumped

    target = TARGETS[options.target]
    seeds = list(dict.fromkeys(target.seeds()))
    meter = Meter(target.law, seeds)
    started = time.monotonic()
    pumps = 0

    def report(found: str = "") -> None:
        if options.report is not None:
            spent = time.monotonic() - started
            options.report.write_text(
                json.dumps(
                    {
                        "target": target.name, "inputs": meter.inputs, "seconds": round(spent, 1),
                        "slowest_ms": round(1000 * meter.slowest, 1), "ratio": round(meter.ratio, 2), "finding": found,
                        "guided": not options.plain, "pumped": pumps, "peak_mb": round(peak_mb()),
                    }
                )
            )  # fmt: skip

    rng = Random(options.seed)
    for _ in range(max(PUMPS_AT_LEAST, int(_value(rest, "runs", "10000")) // PUMPS_SHARE)):
        data = pumped(rng.choice(seeds), rng, rng.choice(target.pumped_to))
        _held(meter, data, rest, report)
        pumps += 1
    meter.inputs = 0
    if options.plain:
        return _plain(meter, target, seeds, options.seed, rest, report)
    return _guided(meter, target, seeds, options.seed, rest, report)


def _value(rest: list[str], name: str, otherwise: str) -> str:
    return next((word.partition("=")[2] for word in rest if word.startswith(f"-{name}=")), otherwise)


def _plain(meter: Meter, target: object, seeds: list[bytes], seed: int, rest: list[str], report: object) -> int:
    from structure import mutated

    rng = Random(seed)
    pool = list(seeds)
    longest = target.longest  # type: ignore[attr-defined]
    for _ in range(int(_value(rest, "runs", "10000"))):
        data = rng.choice(pool)
        if target.streams and rng.random() < 0.6:  # type: ignore[attr-defined]
            data = mutated(data, rng)
        else:
            data = _bytes(data, rng)
        data = data[:longest]
        _held(meter, data, rest, report)
        # Some of what came out is the ground for more.
        if rng.random() < 0.02 and len(pool) < 4 * len(seeds) + 200:
            pool.append(data)
    report()  # type: ignore[operator]
    return 0


def _held(meter: Meter, data: bytes, rest: list[str], report: object) -> None:
    """Run the law; what it does not hold for is kept."""

    def stuck(*_: object) -> None:
        raise Stuck(f"{len(data)} bytes take more than {STUCK} s")

    # The guided fuzzer has a timer of its own, and takes the signal only where nobody else has.
    before = signal.signal(signal.SIGALRM, stuck)
    signal.alarm(STUCK)
    try:
        meter(data)
    except BaseException as error:
        path = Path(_value(rest, "artifact_prefix", "") + "crash-plain")
        path.write_bytes(data)
        report(f"{type(error).__name__}: {error}"[:300])  # type: ignore[operator]
        print(f"finding in {path}", file=sys.stderr)  # noqa: T201
        raise
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _bytes(data: bytes, rng: Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        at = rng.randrange(len(out) + 1)
        how = rng.randrange(6)
        if how == 0 or not out:
            out[at:at] = rng.randbytes(rng.choice((1, 1, 2, 4)))
        elif how == 1:
            del out[at : at + rng.choice((1, 1, 3, 9))]
        elif how == 2:
            out[at:at] = out[at : at + rng.randrange(1, 24)]
        else:
            at = min(at, len(out) - 1)
            out[at] = rng.choice(
                (out[at] ^ (1 << rng.randrange(8)), rng.getrandbits(8), 0, 255, 48 + rng.randrange(10))
            )
    return bytes(out)


def _guided(meter: Meter, target: object, seeds: list[bytes], seed: int, rest: list[str], report: object) -> int:
    import atheris
    from structure import mutated

    longest = target.longest  # type: ignore[attr-defined]
    runs = int(_value(rest, "runs", "0"))
    arguments = [sys.argv[0], *rest, f"-seed={seed}"]
    if all(word.startswith("-") for word in rest):
        folder = Path(tempfile.mkdtemp(prefix="snhc-fuzz-"))
        for number, data in enumerate(seeds):
            (folder / f"seed-{number:03}").write_bytes(data)
        arguments.append(str(folder))
    if not any(word.startswith("-max_len") for word in rest):
        arguments.append(f"-max_len={longest}")

    def mutator(data: bytes, size: int, number: int) -> bytes:
        rng = Random(number)
        if target.streams and rng.random() < 0.4:  # type: ignore[attr-defined]
            return mutated(data, rng)[:size]
        return bytes(atheris.Mutate(data, size))

    def law(data: bytes) -> None:
        try:
            meter(data)
        except BaseException as error:
            report(f"{type(error).__name__}: {error}"[:300])  # type: ignore[operator]
            raise
        # The fuzzer ends the process without a word to Python.
        if meter.inputs % 256 == 0 or meter.inputs == runs:
            report()  # type: ignore[operator]

    atheris.Setup(arguments, law, custom_mutator=mutator)
    atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
