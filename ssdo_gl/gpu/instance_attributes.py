"""What is handed to shaders for each instance."""

from __future__ import annotations

# Per-instance data: three rows of view_from_object; albedo (rgb, alpha factor);
# emission (rgb, 1 if it may count as a sender); (1 if both sides emit, 2: unlit; alpha cutoff, -1:
# alpha is the share of fragments that are kept);
# (metallic, roughness, scale of the normal map, strength of baked occlusion);
# dielectric (rgb reflectance at normal incidence, strength).
INSTANCE_ATTRIBUTES = (
    ("a_view_from_object_row_0", 4),
    ("a_view_from_object_row_1", 4),
    ("a_view_from_object_row_2", 4),
    ("a_albedo", 4),
    ("a_emission", 4),
    ("a_emission_side_cutoff", 2),
    ("a_gloss", 4),
    ("a_dielectric", 4),
)
INSTANCE_FLOATS = sum(count for _, count in INSTANCE_ATTRIBUTES)
