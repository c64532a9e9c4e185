"""FAP interpolation tables, and the NDJSON frames they work on (FIT rules)."""
