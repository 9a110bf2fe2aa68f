"""What a ray needs to know of the surface it hits, as tables for upload."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.scene.material import Texture
from ssdo_gl.scene.scene import Scene

SURFACE_WORDS = 16
MATERIAL_TEXELS = 12
# Flags in the word that names a triangle's row of the material table.
SMOOTH_FLAG = 1 << 31
LIGHT_BODY_FLAG = 1 << 30
SINGLE_SIDED_FLAG = 1 << 29
# Instead of an alpha cutoff: alpha is the chance that a ray meets the surface.
BY_CHANCE = -2.0
# Added to the place of a texture that is not interpolated.
NEAREST_MARK = 0.5
# Added to the second coordinate of a texture that is in the atlas of data.
DATA_MARK = 0.5
# Where in a row of the material table the place of each image stands, and its bit in the
# set of those that take the second texture coordinates.
IMAGE_TEXELS = {
    "albedo": 2,
    "emission": 3,
    "metallic_roughness": 7,
    "specular": 8,
    "specular_color": 9,
    "normal": 10,
}


# Roughness below which a dielectric sends on by directions, too: rays/surfel_lobes.glsl.
SMOOTH_LAYER = 0.6


@dataclass(frozen=True)
class RayFeatures:
    """What rays can meet in a scene; a shader without what nobody has is faster.

    Attributes
    ----------
    single_sided : bool
        Whether there are surfaces that only their front shows of, other than solids,
        whose backs nothing outside of them meets.
    second_uvs : bool
        Whether there are images with texture coordinates of their own.
    glossy : bool
        Whether anything reflects more than diffuse light.
    lobes : bool
        Whether any of it is metal or polish, which send on by directions what they reflect.
    normal_maps, tangents : bool
        Whether there are normal maps, and among them some along tangents of the file.
    glow_is_direct : bool
        Whether all that glows counts as direct light, so that rays do not gather it.
    """

    smooth_normals: bool
    vertex_colors: bool
    textures: bool
    cutouts: bool
    single_sided: bool = False
    second_uvs: bool = False
    glossy: bool = False
    lobes: bool = False
    normal_maps: bool = False
    tangents: bool = False
    glow_is_direct: bool = False

    @classmethod
    def of(cls, scene: Scene) -> RayFeatures:
        """Return the features of the objects of `scene`."""
        pairs = [(scene.meshes[o.mesh], scene.materials[o.material]) for o in scene.objects]
        bumped = [mesh for mesh, m in pairs if mesh.uvs is not None and m.normal_texture]
        return cls(
            smooth_normals=any(mesh.normals is not None for mesh, _ in pairs),
            vertex_colors=any(mesh.colors is not None for mesh, _ in pairs),
            textures=any(
                mesh.uvs is not None and IMAGE_TEXELS.keys() & m.textures for mesh, m in pairs
            ),
            cutouts=any(m.has_holes for _, m in pairs),
            single_sided=any(m.single_sided and not mesh.is_solid for mesh, m in pairs),
            second_uvs=any(
                mesh.second_uvs is not None and m.second_uvs & m.textures.keys()
                for mesh, m in pairs
            ),
            glossy=any(m.is_glossy for _, m in pairs),
            lobes=any(
                m.is_metal or (m.is_glossy and m.mean_roughness < SMOOTH_LAYER) for _, m in pairs
            ),
            normal_maps=bool(bumped),
            tangents=any(mesh.has_tangents for mesh in bumped),
        )

    @property
    def needs_corners(self) -> bool:
        """Whether anything is interpolated between the corners of triangles."""
        return self.smooth_normals or self.vertex_colors or self.textures

    @property
    def corner_texels(self) -> int:
        """How many texels of a row of `surface_table` are read: SURFACE_TEXELS of the shaders."""
        return 4 if self.vertex_colors else 3 if self.textures else 1


def surface_count(bvh: Bvh) -> int:
    """Return the number of rows of `surface_table`."""
    has_more = bvh.triangles.second_uvs is not None or bvh.triangles.tangents is not None
    return bvh.primitive_triangles.size * (2 if has_more else 1)


def surface_table(bvh: Bvh, span: slice = slice(None)) -> NDArray[np.uint32]:
    """Return corner attributes, (2 P, 16): row 2 p + s belongs to triangle s of primitive p.

    Words 0-2: shading normals; 3-8: texture coordinates (float32 bits, u and v in turn);
    9-14: colours, 4 x 16 bits each. Corners in the order of the primitive's vertices.
    Where there are tangents or second coordinates, 2 P rows with these follow, words 0-2:
    directions of tangents; 3-8: coordinates; 9: handedness of the corners' tangents, 2 bits
    each, 0: no tangent, 1: right-handed, 3: left-handed. With a `span`, these rows of it.
    """
    count = bvh.primitive_triangles.size
    first, last, _ = span.indices(surface_count(bvh))
    parts = [_corner_rows(bvh, slice(first, min(last, count)))] if first < count else []
    if last > count:
        parts.append(_more_corner_rows(bvh, slice(max(first - count, 0), last - count)))
    return np.concatenate(parts) if parts else np.zeros((0, SURFACE_WORDS), dtype=np.uint32)


def _chosen_corners(bvh: Bvh, span: slice) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    """Return triangles (N, 1) and their corners (N, 3) in rows of the table."""
    chosen = bvh.primitive_triangles.reshape(-1)[span]
    return np.maximum(chosen, 0)[:, None], bvh.primitive_corners.reshape(-1, 3)[span]


def _corner_rows(bvh: Bvh, span: slice) -> NDArray[np.uint32]:
    triangles = bvh.triangles
    rows, corners = _chosen_corners(bvh, span)
    table = np.zeros((len(rows), SURFACE_WORDS), dtype=np.uint32)
    table[:, 3:9] = _uv_words(triangles.uvs[rows, corners])
    table[:, 0:3] = triangles.normals[rows, corners]
    table[:, 9:15] = triangles.colors[rows, corners].reshape(-1, 6)
    return table


def _more_corner_rows(bvh: Bvh, span: slice) -> NDArray[np.uint32]:
    triangles = bvh.triangles
    rows, corners = _chosen_corners(bvh, span)
    second = np.zeros((len(rows), SURFACE_WORDS), dtype=np.uint32)
    if triangles.second_uvs is not None:
        second[:, 3:9] = _uv_words(triangles.second_uvs[rows, corners])
    if triangles.tangents is not None:
        tangents = triangles.tangents[rows, corners]
        second[:, 0:3] = tangents[..., 0]
        second[:, 9] = tangents[..., 1] @ np.array([1, 4, 16], dtype=np.uint32)
    return second


def _uv_words(uvs: NDArray[np.float32]) -> NDArray[np.uint32]:
    return uvs.reshape(-1, 6).view(np.uint32)


def material_words(bvh: Bvh, scene: Scene) -> NDArray[np.uint32]:
    """Return the row of `material_table` of both triangles of each primitive with flags, (P, 2).

    They change with the geometry only: what a light does is up to the table.
    """
    triangles = bvh.triangles
    if triangles.count == 0:
        return np.zeros((0, 2), dtype=np.uint32)
    is_body = triangles.light >= 0
    rows = triangles.material.copy()
    lamps = np.array(lamp_materials(scene), dtype=np.int64).reshape(-1, 2)
    stride = len(scene.materials)
    rows[is_body] = stride + np.searchsorted(
        lamps[:, 0] * stride + lamps[:, 1],
        triangles.light[is_body] * stride + triangles.material[is_body],
    )
    words = rows.astype(np.uint32)
    words |= np.where(triangles.smooth, SMOOTH_FLAG, 0).astype(np.uint32)
    words |= np.where(triangles.single_sided, SINGLE_SIDED_FLAG, 0).astype(np.uint32)
    words |= np.where(is_body, LIGHT_BODY_FLAG, 0).astype(np.uint32)
    return words[np.maximum(bvh.primitive_triangles, 0)]


def lamp_materials(scene: Scene) -> list[tuple[int, int]]:
    """Return (light, material) of the bodies of lights, each pair once, in order."""
    return sorted({(o.light, o.material) for o in scene.objects if o.light is not None})


@dataclass(frozen=True, eq=False)
class Atlas:
    """All images of a scene in one.

    Attributes
    ----------
    pixels : ndarray, shape (height, width, 4), uint8 (sRGB) or float32 (linear)
        Row 0 is the top row of the images.
    places : dict
        id(Texture) -> (x, y, width, height), texels.
    """

    pixels: NDArray[np.uint8] | NDArray[np.float32]
    places: dict[int, tuple[int, int, int, int]]


def build_atlas(textures: Sequence[Texture], max_size: int) -> Atlas:
    """Pack `textures` on shelves; images are halved until all fit into `max_size`.

    Parameters
    ----------
    textures : sequence of Texture
        At least one.
    max_size : int
        Largest width and height, texels.
    """
    unique = list({id(texture): texture for texture in textures}.values())
    linear = any(texture.pixels.dtype != np.uint8 for texture in unique)
    images = {id(t): _as_linear(t.pixels) if linear else t.pixels for t in unique}
    while True:
        places, width, height = _shelves({k: i.shape[:2] for k, i in images.items()}, max_size)
        if height <= max_size and width <= max_size:
            break
        images = {key: _halved(image) for key, image in images.items()}
    pixels = np.zeros((height, width, 4), dtype=np.float32 if linear else np.uint8)
    for key, (x, y, w, h) in places.items():
        pixels[y : y + h, x : x + w] = images[key]
    return Atlas(pixels, places)


def _shelves(
    sizes: dict[int, tuple[int, int]], max_size: int
) -> tuple[dict[int, tuple[int, int, int, int]], int, int]:
    """Place images (height, width) in rows, tallest first; return places and extent."""
    area = sum(h * w for h, w in sizes.values())
    # A square that wastes a tenth, but never narrower than the widest image.
    row_width = max(max(w for _, w in sizes.values()), min(int((1.1 * area) ** 0.5), max_size))
    places = {}
    x = y = shelf = 0
    for key in sorted(sizes, key=lambda k: -sizes[k][0]):
        h, w = sizes[key]
        if x + w > row_width:
            x, y, shelf = 0, y + shelf, 0
        places[key] = (x, y, w, h)
        x, shelf = x + w, max(shelf, h)
    return places, row_width, y + shelf


def _as_linear(pixels: NDArray[np.uint8] | NDArray[np.float32]) -> NDArray[np.float32]:
    if pixels.dtype != np.uint8:
        return np.asarray(pixels, dtype=np.float32)
    linear = linear_from_srgb(pixels.astype(np.float64) / 255.0)
    linear[..., 3] = pixels[..., 3] / 255.0
    return linear.astype(np.float32)


def _halved(
    pixels: NDArray[np.uint8] | NDArray[np.float32],
) -> NDArray[np.uint8] | NDArray[np.float32]:
    """Keep every second texel; one pixel stays one."""
    return pixels[:: 2 if pixels.shape[0] > 1 else 1, :: 2 if pixels.shape[1] > 1 else 1]


def material_table(
    scene: Scene, places: Mapping[int, tuple[int, int, int, int]]
) -> NDArray[np.float32]:
    """Return a row of twelve texels for each material, then for each lamp, (M, 12, 4).

    Lamps are those of `lamp_materials`.

    0: albedo, alpha factor. 1: emission, 1 if both sides emit, 2: unlit. 2 and 3: x, y, width and
    height of albedo and emission texture in the atlas; width 0: none, negative sizes:
    clamped instead of repeated; x + 1/2: not interpolated. 4: alpha cutoff, -1 if nothing
    is cut out, `BY_CHANCE` where alpha is coverage; 1 for the body of a light without
    shadows, which passes through everything; 1 for that of one which casts direct shadows.
    5: metallic, roughness, scale of normals, set of images with the second coordinates.
    6: reflectance of the dielectric at normal incidence, strength. 7 to 10: places of
    the images of `IMAGE_TEXELS`; y + 1/2: in the atlas of data.

    Parameters
    ----------
    places : mapping
        `Atlas.places` of the atlases with the textures; textures that are not in it are
        left out.
    """
    lamps = lamp_materials(scene)
    rows = [*scene.materials, *(scene.materials[material] for _, material in lamps)]
    table = np.zeros((max(len(rows), 1), MATERIAL_TEXELS, 4), dtype=np.float32)
    for row, material in zip(table, rows, strict=False):
        row[0] = *material.albedo, material.alpha
        row[1] = *material.emission, material.side_code
        for name, texture in material.textures.items():
            if id(texture) in places and name in IMAGE_TEXELS:
                x, y, width, height = places[id(texture)]
                sides = [-1 if wrap == "clamp" else 1 for wrap in texture.wrap]
                x_mark = NEAREST_MARK if texture.nearest else 0.0
                y_mark = DATA_MARK if texture.is_data else 0.0
                place = x + x_mark, y + y_mark, width * sides[0], height * sides[1]
                row[IMAGE_TEXELS[name]] = place
        second = (1 << IMAGE_TEXELS[name] for name in material.second_uvs & IMAGE_TEXELS.keys())
        row[5] = material.metallic, material.roughness, material.normal_scale, sum(second)
        row[6] = *material.dielectric_color, material.specular
        row[4, 0] = -1.0 if material.alpha_cutoff is None else material.alpha_cutoff
        row[4, 0] = BY_CHANCE if material.is_translucent else row[4, 0]
    for row, (light, _) in zip(table[len(scene.materials) :], lamps, strict=False):
        row[4, 1:3] = [scene.lights[light].shadow == shadow for shadow in ("none", "map")]
    return table
