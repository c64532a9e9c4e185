"""A stream in the terminal: tree, hexdump, details, search."""
