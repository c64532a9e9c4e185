"""Takes memory in many processes, none of which takes too much."""

import os
import time

for _ in range(16):
    if os.fork() == 0:
        taken = b"x" * (40 << 20)
        time.sleep(60)
        os._exit(len(taken) & 1)
os.wait()
