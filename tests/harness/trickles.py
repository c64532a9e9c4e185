"""Right, a byte at a time, and slowly."""

import sys
import time

from _shared import answer

for char in "".join(answer()[0]):
    sys.stdout.write(char)
    sys.stdout.flush()
    time.sleep(0.05)
