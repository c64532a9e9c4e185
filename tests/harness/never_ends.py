"""Right, but it does not end."""

import sys
import time

from _shared import answer

sys.stdout.write("".join(answer()[0]))
sys.stdout.flush()
while True:
    time.sleep(60)
