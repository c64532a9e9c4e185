"""Right, but leaves a child of a child behind, in a session of its own."""

import os
import time

from _shared import answer, finish

if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        while True:
            time.sleep(60)
    os._exit(0)
os.wait()
finish(*answer())
