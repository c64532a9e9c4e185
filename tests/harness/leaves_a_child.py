"""Right, but leaves a child behind that holds its output open."""

import os
import time

from _shared import answer, finish

if os.fork() == 0:
    while True:
        time.sleep(60)
finish(*answer())
