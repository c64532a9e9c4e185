"""The one-file HTML viewer: `page` puts it together, `columns`, `frames` and `head` make its data."""
