"""Limits on what one input may ask for.

Rules: CNF-22, CNF-26, FBA-42. Each is checked before memory is taken; passing one is `ResourceLimit`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits in force; defaults are those of CNF-22.

    Rules: CNF-22, CNF-26.

    `skipped_frames`: frames one temporal header may skip. `idle_planes`: consecutive planes without data and without
    a start code between them (FBA-42). `collected_planes`: planes kept when a whole stream is collected; streaming
    has none. `user_data_bytes`: one user_data element. `text_line_bytes`, `json_bytes`: text inputs.
    """

    skipped_frames: int = 1_000_000
    idle_planes: int = 1_024
    collected_planes: int = 10_000_000
    user_data_bytes: int = 16 * 1024 * 1024
    text_line_bytes: int = 1024 * 1024
    json_bytes: int = 256 * 1024 * 1024
    mesh_nodes_uniform: int = 1_046_529
    mesh_nodes_delaunay: int = 65_535
    fit_sets: int = 256
    fit_links: int = 1_024
    fat_vertices: int = 2_000_000
    adapter_output_bytes: int = 256 * 1024 * 1024

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The names that `--limit name=value` takes. Rules: CNF-26."""
        return tuple(f.name for f in fields(cls))

    def with_values(self, changes: dict[str, int]) -> Limits:
        """A copy with some limits changed. Rules: CNF-26. Raises KeyError for a name that is no limit."""
        for name in changes:
            if name not in self.names():
                raise KeyError(name)
        return replace(self, **changes)


DEFAULT_LIMITS = Limits()
