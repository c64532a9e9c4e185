"""What the small decoders share: the reference decoder's answer to the vector that they are given."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import NoReturn

from snhc.vectors.decoding import decode
from snhc.vectors.manifest import DecodeOptions


def answer() -> tuple[list[str], str, int]:
    """Lines, the JSON line of a fault ("" for none), exit code."""
    decoded = decode(Path(sys.argv[1]).read_bytes(), DecodeOptions().for_decoder())
    if decoded.error is None:
        return list(decoded.lines), "", 0
    return list(decoded.lines), json.dumps(decoded.error.as_json()) + "\n", 1


def finish(lines: list[str], said: str, code: int) -> NoReturn:
    """Print and exit."""
    sys.stdout.write("".join(lines))
    sys.stdout.flush()
    sys.stderr.write(said)
    sys.exit(code)
