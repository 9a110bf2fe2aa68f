"""The [materials.NAME] tables."""

from __future__ import annotations

from pathlib import Path

from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.files import Table, contained_file, read_texture
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene_error import SceneError

# Where one of these stands, the surface is glossy unless `specular` says otherwise.
GLOSS_KEYS = (
    "metallic",
    "roughness",
    "ior",
    "specular_color",
    "metallic_roughness_texture",
    "specular_texture",
    "specular_color_texture",
)
KEYS = (
    "albedo",
    "emission",
    "albedo_texture",
    "emission_texture",
    *GLOSS_KEYS,
    "specular",
    "normal_texture",
    "normal_scale",
    "occlusion_texture",
    "occlusion_strength",
    "unlit",
    "opacity",
    "blend",
    "alpha",
    "alpha_cutoff",
    "two_sided_emission",
)


def read_materials(table: Table | None, file: Path | None, builder: SceneBuilder) -> dict[str, int]:
    """Add every named material and return name -> index."""
    index: dict[str, int] = {}
    for name in table.data if table else ():
        assert table is not None
        inside = table.table(name)
        assert inside is not None
        material = Table(inside.source, f"[materials.{name}]", inside.data)
        read = _read_material(name, material, file)
        index[name] = builder.material(read)
        if read.alpha < 1.0 and not read.blends and read.alpha_cutoff is None:
            show = f"opacity = {read.alpha:g} would let what lies behind show"
            builder.note(f"{material.where('alpha')} is left out without alpha_cutoff: {show}")
    return index


def _read_material(name: str, table: Table, file: Path | None) -> Material:
    table.allow(*KEYS)
    cutoff = None
    if "alpha_cutoff" in table:
        cutoff = table.number("alpha_cutoff", low=0.0, high=1.0)
    has_texture = "albedo_texture" in table
    opacity = table.number("opacity", 1.0, low=0.0, high=1.0)
    if "opacity" in table and "alpha" in table:
        raise SceneError(f"{table.where('opacity')}: stands for alpha and blend; give one of them")
    is_glossy = any(key in table for key in GLOSS_KEYS)
    return Material(
        name=name,
        # A texture alone should show as it is; a plain surface is light grey.
        albedo=table.color("albedo", (1.0, 1.0, 1.0) if has_texture else (0.8, 0.8, 0.8), 1.0),
        emission=table.color("emission", (0.0, 0.0, 0.0)),
        albedo_texture=_texture(table, "albedo_texture", file),
        emission_texture=_texture(table, "emission_texture", file),
        metallic=table.number("metallic", 0.0, low=0.0, high=1.0),
        roughness=table.number("roughness", 1.0, low=0.0, high=1.0),
        specular=table.number("specular", float(is_glossy), low=0.0, high=1.0),
        specular_color=table.color("specular_color", (1.0, 1.0, 1.0)),
        ior=table.number("ior", 1.5, low=1.0),
        metallic_roughness_texture=_texture(table, "metallic_roughness_texture", file, True),
        specular_texture=_texture(table, "specular_texture", file, True),
        specular_color_texture=_texture(table, "specular_color_texture", file),
        normal_texture=_texture(table, "normal_texture", file, True),
        normal_scale=table.number("normal_scale", 1.0),
        occlusion_texture=_texture(table, "occlusion_texture", file, True),
        occlusion_strength=table.number("occlusion_strength", 1.0, low=0.0, high=1.0),
        is_unlit=table.boolean("unlit", False),
        blends=table.boolean("blend", opacity < 1.0),
        alpha_cutoff=cutoff,
        alpha=table.number("alpha", opacity, low=0.0, high=1.0),
        two_sided_emission=table.boolean("two_sided_emission", False),
    )


def _texture(table: Table, key: str, file: Path | None, is_data: bool = False) -> Texture | None:
    if key not in table:
        return None
    return read_texture(file_beside(table, key, file), table.where(key), is_data=is_data)


def file_beside(table: Table, key: str, file: Path | None) -> Path:
    """Return the file that `key` names, in the folder of the scene file."""
    name = table.text(key)
    if file is None:
        raise SceneError(f"{table.where(key)} = {name!r}: this scene has no folder to look in")
    return contained_file(file, name, table.where(key))
