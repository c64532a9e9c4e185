"""What this form of the codec makes of generated streams, one digest per stream: run in both forms, compared.

    python tests/form_digests.py FIRST COUNT

Stream number n is made from the seed n alone: every other one is a new face stream, the rest are streams of the suite
(faces, DCT, meshes) with some bytes changed. The digest covers the bytes that the writer makes, frames, findings,
every row of the trace, the coder's steps, and the error.
"""

from __future__ import annotations

import sys
from functools import cache
from hashlib import sha256
from pathlib import Path
from random import Random

from strategies import STYLES, Planes

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.records import FbaObject
from snhc.reference_impl.systems.stream import decode_frames, read_stream, trace_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem

SUITE = Path(__file__).parents[1] / "vectors" / "suite"
LARGEST = 4096


@cache
def suite_streams() -> list[Path]:
    """Streams of the suite that are small enough to be decoded thousands of times."""
    found = [path for kind in ("*.fba", "*.m2d") for path in SUITE.rglob(kind) if path.stat().st_size <= LARGEST]
    return sorted(found, key=str)


def stream(number: int) -> bytes:
    """Stream number n."""
    rng = Random(number)
    if number & 1:
        return changed(rng, rng.choice(suite_streams()).read_bytes())
    make = Planes(rng)
    item = StreamItem(0x1BA)
    item.fba = FbaObject()
    for _ in range(rng.randint(1, 12)):
        mask = rng.choice((0, 1, 1, 1, 2, 3))
        ready = (not mask & 1 or make.faps.has_intra) and (not mask & 2 or make.baps.has_intra)
        item.fba.planes.append(
            make.plane(
                intra=not ready or rng.random() < 0.2,
                mask=mask,
                quant=rng.choice((0, 1, 1, 2, 31, rng.randint(0, 31))),
                density=rng.choice((0.15, 0.5, 1.0)),
                lists=rng.choice((0, 15, rng.randint(0, 15))),
                style=rng.choice(STYLES),
            )
        )
    data = write_stream([item, StreamItem(0x1B1)])
    return changed(rng, data) if rng.random() < 0.2 else data


def changed(rng: Random, data: bytes) -> bytes:
    """Bits flipped, bytes replaced, or an end cut off."""
    out = bytearray(data)
    for _ in range(rng.choice((0, 1, 1, 2, 5))):
        if out:
            place = rng.randrange(len(out))
            out[place] = out[place] ^ 1 << rng.randrange(8) if rng.random() < 0.7 else rng.randrange(256)
    return bytes(out[: rng.randint(0, len(out))] if rng.random() < 0.1 else out)


def outcome(data: bytes) -> str:
    """All that the codec says about a stream."""
    said: list[str] = [data.hex()]
    findings: list[Finding] = []
    try:
        said += [repr(frame) for frame in decode_frames(data, on_finding=findings.append)]
    except SnhcError as error:
        said.append(str(error.as_json()))
    said += [str(finding) for finding in findings]
    for part in trace_stream(data):
        said += [f"{el.name} {start} {end} {value} {path}" for el, start, end, value, path in part.trace.rows()]
        said += [repr(segment) for segment in part.trace.segments.values()]
        said.append(str(part.error))
    try:
        said.append(write_stream(read_stream(data)).hex())
    except SnhcError as error:
        said.append(str(error))
    return "\n".join(said)


def main() -> None:
    first, count = int(sys.argv[1]), int(sys.argv[2])
    for number in range(first, first + count):
        sys.stdout.write(f"{number} {sha256(outcome(stream(number)).encode()).hexdigest()}\n")


if __name__ == "__main__":
    main()
