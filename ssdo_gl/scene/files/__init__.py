"""What scene files and models are read with: files they name, tables, images."""

from __future__ import annotations

from ssdo_gl.scene.files.images import MAX_MODEL_TEXELS, check_size, doubled, read_texture
from ssdo_gl.scene.files.paths import check_file, contained_file, read_file
from ssdo_gl.scene.files.radiance_maps import MAX_RADIANCE, read_radiance_map
from ssdo_gl.scene.files.table import Table
