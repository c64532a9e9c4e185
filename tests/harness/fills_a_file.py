"""Writes a file without end."""

import os

with open("big", "wb") as file:  # noqa: PTH123
    os.truncate(file.fileno(), 1 << 40)
