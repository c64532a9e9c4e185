"""Signals for the processes of tests."""

from __future__ import annotations

import signal


def hears_interrupts() -> None:
    """In a child before its program runs: signals end it, also where tests run in the background, or by nohup.

    There interrupts and hang-ups are ignored, which a child would inherit.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
