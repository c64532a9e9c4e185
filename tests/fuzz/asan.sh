#!/usr/bin/env bash
# The compiled form under the address sanitizer: its runtime must be the first library of the process.
set -euo pipefail
python -c "
from snhc.conformance.cli.version import version_line
line = version_line()
print(line)
raise SystemExit('pure' in line)
"
runtime="$("${CC:-gcc}" -print-file-name=libasan.so)"
[ -e "$runtime" ] || { echo "not run: fuzz-asan (no libasan.so)"; exit 0; }
# CPython itself leaks at its end; what is looked for is reads and writes outside.
LD_PRELOAD="$runtime" ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 python tests/fuzz/campaign.py --plain "$@"
