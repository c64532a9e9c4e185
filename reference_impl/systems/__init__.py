"""What surrounds a face or mesh stream: visual object headers (SYS rules)."""
