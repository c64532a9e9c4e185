"""`python -m snhc.conformance.cli`: the same as `snhc`."""

from . import main

main()
