"""Face models: feature points, units, face animation tables, deformers (FAC and FAT rules)."""
