"""The vector suite: recipes, manifest, generated files."""
