"""Runs `snhc` with the arguments given, and says on the last line of standard error how much memory it took at most.

    python tests/peak.py stats stream.fba

The peak is that of the program alone, in KiB. What the system says of a child (`ru_maxrss`) is no less than the parent
had when it started it, and so says nothing where a large test process measures a small command.
"""

from __future__ import annotations

import resource
import sys
from pathlib import Path


def peak() -> int:
    """Largest resident set so far of this process since its program began, KiB."""
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1])
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most // 1024 if sys.platform == "darwin" else most


def main() -> None:
    from snhc.conformance.cli import snhc

    try:
        snhc(prog_name="snhc")
    finally:
        sys.stderr.write(f"\n{peak()}\n")


if __name__ == "__main__":
    main()
