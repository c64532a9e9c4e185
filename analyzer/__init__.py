"""Looking into streams: traces as trees, dumps, queries."""
