#!/usr/bin/env bash
# The compiled form under the address sanitizer: its runtime must be the first library of the process.
set -euo pipefail
runtime="$("${CC:-gcc}" -print-file-name=libasan.so)"
if [ ! -e "$runtime" ]; then
    echo "not run: fuzz-asan (no libasan.so)"
    exit 0
fi
# CPython itself leaks at its end; what is looked for is reads and writes outside.
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=1
form="$(LD_PRELOAD="$runtime" python -m snhc.conformance.cli --version)"
case "$form" in
    *compiled*) ;;
    *) echo "fuzz-asan: $form: not the compiled form" >&2; exit 1 ;;
esac
LD_PRELOAD="$runtime" python tests/fuzz/campaign.py --plain "$@"
