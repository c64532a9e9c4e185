"""2D mesh objects: geometry, triangulation, traversal, motion, warping, design.

Rules: the MSH rules, room by room. The syntax of the standard stands beside these modules; here is what the
syntax means. `rasteriser`, `design_encoder` and `tracking` need arrays, `drawing` needs Pillow: they are imported
only by those who draw or encode.
"""
