"""Face animation streams: syntax, decoding, encoding, text formats (FBA rules)."""
