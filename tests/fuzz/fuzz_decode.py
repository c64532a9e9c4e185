"""Fuzzing of decoder and tracer with atheris: `python tests/fuzz/fuzz_decode.py -runs=200000 [CORPUS FOLDER]`.

The law is that of tests/unit/test_hostile.py: a decode or one located fault, the same from both machines; whatever
decodes writes back to the same bytes. A finding is kept as a named file in tests/fuzz_findings/, which
tests/unit/test_fuzz_findings.py replays.
"""

from __future__ import annotations

import sys
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).parent.parent))

with atheris.instrument_imports(include=["snhc"]):
    from fuzz_law import check_bytes

from fba_helpers import SAMPLES

# Longer inputs find nothing that these do not, and cost more.
LONGEST = 256
STARTS = (
    "000001ba", "000001ba7f000001bb", "000001b063000001b523000001ba", "000001b59147000001b2610000", "00000101",
    "000001bab1900192492e92000000049405172f000001b1",
    "000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1",
    "000001baa032c0004d01279200fd9f553f600a7e49fe9483ff7ff2a032a0004c81249201028d85019a000249249007e97f000001b1",
)  # fmt: skip


def seeds() -> list[bytes]:
    """Streams to begin with: the worked examples, the small cases, start codes."""
    small = [path.read_bytes() for kind in ("fba", "neg") for path in sorted((SAMPLES / kind).glob("*/input.fba"))]
    return [bytes.fromhex(start) for start in STARTS] + [data for data in small if len(data) <= LONGEST]


def main() -> None:
    folders = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    arguments = list(sys.argv)
    if not folders:
        import tempfile

        folder = Path(tempfile.mkdtemp(prefix="snhc-fuzz-"))
        for number, data in enumerate(seeds()):
            (folder / f"seed-{number:02}").write_bytes(data)
        arguments.append(str(folder))
    if not any(argument.startswith("-max_len") for argument in arguments):
        arguments.append(f"-max_len={LONGEST}")
    atheris.Setup(arguments, check_bytes)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
