"""Forks a child that hangs, in a session of its own, and waits for it."""

import os
import time

if os.fork() == 0:
    os.setsid()
    while True:
        time.sleep(60)
os.wait()
