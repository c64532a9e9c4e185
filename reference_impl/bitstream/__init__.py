"""Bits: the cursor, the syntax machines, errors, findings, limits."""
