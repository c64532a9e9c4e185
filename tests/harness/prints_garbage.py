"""Words that are no decoded output."""

import sys

sys.stdout.write("Segmentation fault (just kidding)\n\x00\x01\x02\n")
