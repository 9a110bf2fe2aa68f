"""Triangle meshes: what they hold, shapes, and what makes meshes of files fit to draw."""

from __future__ import annotations

from ssdo_gl.scene.geometry.batching import batched
from ssdo_gl.scene.geometry.flattened import thickened, with_area
from ssdo_gl.scene.geometry.main_parts import MainPart, main_part
from ssdo_gl.scene.geometry.mesh import (
    MAX_INSTANCES,
    Mesh,
    SceneObject,
    cleaned_mesh,
    smoothed,
)
from ssdo_gl.scene.geometry.shapes import (
    SEGMENTS,
    box,
    cone,
    cylinder,
    parallelogram_matrix,
    quad,
    sphere,
    torus,
)
from ssdo_gl.scene.geometry.surfaces import Surfaces
from ssdo_gl.scene.geometry.topology import (
    SPAN,
    are_mirrored,
    check_vertices,
    corners_within,
    joined_vertices,
    placed,
    spans,
)
