"""Checking decoders: adapters, runner, comparators, reports, and the command line."""
