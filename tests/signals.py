"""Signals for the processes of tests."""

from __future__ import annotations

import signal


def hears_interrupts() -> None:
    """In a child before its program runs: Ctrl-C ends it, also where the tests run in a shell's background.

    There interrupts are ignored, which a child would inherit.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
