#!/bin/bash
# bash.sh INPUT: a program that writes .fap files as a decoder to be checked.
out="$TMPDIR/decoded.fap"
other-decoder "$1" "$out" >&2
case $? in
    0) cat "$out" ;;
    1 | 2) exit 1 ;;       # what this program ends with when it does not like a stream
    *) exit 70 ;;          # it fell over: anything but 0 and 1
esac
