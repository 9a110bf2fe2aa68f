"""Every extension of glTF that the reader knows, and how much of it is drawn."""

from __future__ import annotations

from ssdo_gl.scene.formats.gltf.document import Document, GltfError, shown

EXACT, APPROXIMATE, NOT_DRAWN = "exact", "approximate", "not drawn"
# What is not listed is unknown: skipped, unless the file requires it.
EXTENSIONS = {
    "EXT_mesh_gpu_instancing": EXACT,
    "EXT_meshopt_compression": EXACT,
    "EXT_texture_webp": EXACT,
    "KHR_animation_pointer": NOT_DRAWN,
    "KHR_draco_mesh_compression": EXACT,
    "KHR_lights_punctual": APPROXIMATE,
    "KHR_materials_anisotropy": NOT_DRAWN,
    "KHR_materials_clearcoat": NOT_DRAWN,
    "KHR_materials_diffuse_transmission": NOT_DRAWN,
    "KHR_materials_dispersion": NOT_DRAWN,
    "KHR_materials_emissive_strength": EXACT,
    "KHR_materials_ior": EXACT,
    "KHR_materials_iridescence": NOT_DRAWN,
    "KHR_materials_pbrSpecularGlossiness": APPROXIMATE,
    "KHR_materials_sheen": NOT_DRAWN,
    "KHR_materials_specular": EXACT,
    "KHR_materials_transmission": APPROXIMATE,
    "KHR_materials_unlit": EXACT,
    "KHR_materials_variants": APPROXIMATE,
    "KHR_materials_volume": NOT_DRAWN,
    "KHR_mesh_quantization": EXACT,
    "KHR_meshopt_compression": EXACT,
    "KHR_node_visibility": EXACT,
    "KHR_texture_basisu": EXACT,
    "KHR_texture_transform": EXACT,
    "MSFT_texture_dds": EXACT,
}


def check_extensions(document: Document) -> None:
    """Refuse a file that requires what changes its geometry in ways not read here."""
    for name in document.json.get("extensionsRequired", []):
        if name not in EXTENSIONS and not str(name).startswith("KHR_materials_"):
            raise GltfError(f"requires the extension {shown(name)}, which is not supported")
