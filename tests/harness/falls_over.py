"""Ends with a traceback, and so with exit code 1."""

raise ZeroDivisionError
