"""Objects of trimesh in scenes, beside the files that trimesh writes of them."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from scene.test_composition import picture

import ssdo_gl
from ssdo_gl import Scene
from ssdo_gl.scene.scene_error import SceneError

trimesh = pytest.importorskip("trimesh")


def test_a_textured_model_looks_like_its_file(tmp_path):
    from trimesh.visual.material import PBRMaterial

    rng = np.random.default_rng(3)
    image = Image.fromarray(rng.integers(0, 255, (8, 8, 3), dtype=np.uint8))
    box = trimesh.creation.box()
    flat = trimesh.Trimesh(
        box.vertices[box.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False
    )
    flat.visual = trimesh.visual.TextureVisuals(
        uv=rng.random((36, 2)).astype(np.float32),
        material=PBRMaterial(
            baseColorTexture=image, metallicFactor=0.25, roughnessFactor=0.5, doubleSided=True
        ),
    )
    flat.export(tmp_path / "box.glb")
    made, read = Scene.from_trimesh(flat), ssdo_gl.load_scene(tmp_path / "box.glb")
    ours, theirs = made.materials[0], read.materials[0]
    for field in ("albedo", "metallic", "roughness", "specular", "single_sided", "alpha"):
        assert getattr(ours, field) == getattr(theirs, field), field
    np.testing.assert_array_equal(ours.albedo_texture.pixels, theirs.albedo_texture.pixels)
    shown = picture(made, "albedo")
    # Coordinates of float32 are another texel's at edges of texels; half of 8 bits.
    np.testing.assert_allclose(shown, picture(read, "albedo"), atol=2e-3)
    assert np.unique(shown.reshape(-1, 3), axis=0).shape[0] > 20


def test_a_scene_keeps_places_and_colours():
    box = trimesh.creation.box()
    box.visual.face_colors = [255, 0, 0, 255]
    scene = trimesh.Scene()
    scene.add_geometry(box, geom_name="box")
    place = trimesh.transformations.translation_matrix((3.0, 0, 0))
    scene.graph.update(frame_to="second", matrix=place, geometry="box")
    made = Scene.from_trimesh(scene)
    assert made.triangle_count == 24 and len(made.meshes) == 1
    np.testing.assert_array_equal(made.meshes[0].colors[0], [1.0, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(made.bounds()[1], [3.5, 0.5, 0.5])


def test_what_has_no_triangles_beside_others_is_named():
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box(), geom_name="box")
    scene.add_geometry(trimesh.PointCloud([[0, 0, 2.0]]), geom_name="scan")
    note = "scan: not drawn, a PointCloud of trimesh without triangles"
    made = Scene.from_trimesh(scene)
    assert note in made.notes
    ball = trimesh.creation.icosphere()
    assert note in made.add(ball).notes
    assert note in Scene.from_trimesh(ball).add(scene).notes


def test_what_has_no_triangles_is_refused():
    with pytest.raises(SceneError, match="the PointCloud of trimesh holds no triangles"):
        Scene.from_trimesh(trimesh.PointCloud([[0, 0, 0]]))


def test_of_three_texture_coordinates_two_are_of_an_image():
    box = trimesh.creation.box()
    box.visual = trimesh.visual.TextureVisuals(uv=np.full((8, 3), 0.25))
    (mesh,) = Scene.from_trimesh(box).meshes
    assert mesh.uvs.shape[1] == 2 and np.ptp(mesh.uvs, axis=0).tolist() == [0.0, 0.0]
