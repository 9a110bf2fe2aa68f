"""Turns images on the device into the picture on the screen."""

from __future__ import annotations

import dataclasses

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.shader import FULLSCREEN, ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.images.display import ColorMapping
from ssdo_gl.math3d import FloatArray
from ssdo_gl.render_result import Drawing, Plane
from ssdo_gl.scene.camera import Camera
from ssdo_gl.window.live import KeptPlanes, LiveImage
from ssdo_gl.window.views import View

# Width of the divider's line, pixels of the framebuffer.
DIVIDER_PX = 2
_DIVIDER_COLOR = (1.0, 0.85, 0.3, 1.0)


def error_color(t: float) -> tuple[float, float, float]:
    """Return the sRGB colour of a difference, -1 (too dark) to 1 (too bright).

    The same as in ``shaders/window/error_colors.frag``, for the legend.
    """
    neutral = np.full(3, 0.08)
    middle = np.array([0.10, 0.36, 0.90] if t < 0.0 else [0.88, 0.24, 0.10])
    tip = np.array([0.78, 0.93, 1.00] if t < 0.0 else [1.00, 0.92, 0.62])
    size = min(abs(t), 1.0)
    start, end, u = (neutral, middle, 2 * size) if size < 0.5 else (middle, tip, 2 * size - 1)
    r, g, b = (float(c) for c in start + (end - start) * u)
    return r, g, b


class Presenter:
    """Draws one or two images, or their difference, into a picture of the window's size.

    Attributes
    ----------
    picture : moderngl.Framebuffer or None
        8-bit sRGB, what `draw` made last.
    draw_count : int
        Pictures that were made: tells a new one from the last.
    """

    def __init__(self, device: Device, shaders: ShaderLibrary) -> None:
        self.picture: moderngl.Framebuffer | None = None
        self.draw_count = 0
        self._texture: moderngl.Texture | None = None
        self._gl = device.gl
        self._shaders = shaders
        self._constants: dict[float, moderngl.Texture] = {}
        self._seen = KeptPlanes(device)
        # Where the line between two methods is, 0..1 from the left; at 1 there is one method.
        self._line = 1.0
        self._ready_for: object = None

    def draw(
        self,
        size: tuple[int, int],
        view: View,
        left: LiveImage,
        right: LiveImage | None,
        *,
        kinds: tuple[ColorMapping, ColorMapping],
        bounds: tuple[FloatArray, FloatArray],
        exposure: float,
        curve: str = "plain",
    ) -> None:
        """Draw `view` into `picture`.

        Parameters
        ----------
        size : (int, int)
            Pixels of the window's framebuffer.
        left, right : LiveImage
            Both drawn at least once; `right` if the view compares.
        kinds : (ColorMapping, ColorMapping)
            How the numbers of left and right become colours.
        bounds : (ndarray, ndarray)
            Corners of the scene, world space.
        exposure : float
            EV, for images that are still linear.
        curve : str
            Tone curve for those, one of `passes.tone_map.CURVES`.
        """
        self._fit(size)
        assert self.picture is not None
        self.draw_count += 1
        self._line = view.divider if view.is_split and right is not None else 1.0
        if view.is_error and right is not None:
            self._draw_error(view, left, right, exposure)
            return
        split = round(self._line * size[0])
        self._draw_image(left, kinds[0], (0, 0, split, size[1]), bounds, exposure, curve)
        if right is not None and split < size[0]:
            rest = (split, 0, size[0] - split, size[1])
            self._draw_image(right, kinds[1], rest, bounds, exposure, curve)
            self._draw_line(DIVIDER_PX)

    def _draw_line(self, thickness: int) -> None:
        assert self.picture is not None
        width, height = self.picture.size
        left = round(self._line * width) - thickness // 2
        self.picture.clear(*_DIVIDER_COLOR, viewport=(left, 0, thickness, height))

    def copy_to(self, target: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Copy the picture to `target` (the screen), whose size is `size` pixels."""
        assert self.picture is not None and self._texture is not None, "nothing was drawn yet"
        if self.picture.size == size:
            # In software, a tenth of the time that a shader takes. It heeds the scissor, too.
            target.use()
            target.scissor = (0, 0, *size)
            self._gl.copy_framebuffer(target, self.picture)
            return
        program = self._shaders.program(FULLSCREEN, "passes/copy.frag")
        program.set({}, {"t_image": self._texture})
        self._fill(program, target, size, None)

    def remember(self, drawing: Drawing | None, camera: Camera) -> None:
        """Keep the depth of what the picture shows to `camera`, for `follow`; None: nothing."""
        if drawing is None:
            self._seen.release()
            return
        planes = {"depth": drawing.planes["depth"]}
        self._seen.keep(dataclasses.replace(drawing, planes=planes))
        assert self.picture is not None
        sizes = self.picture.size, drawing.view.size
        if sizes != self._ready_for:
            # Its first pixel takes a driver a tenth of a second, which nobody waits for now.
            self._ready_for = sizes
            for item in self._followed(camera, (1, 1)):
                item.release()

    def follow(self, camera: Camera, size: tuple[int, int]) -> bool:
        """Make the picture, once, one that `camera` might see; return whether that is possible.

        It is some milliseconds' work. What comes into view is made of what is beside it.
        """
        seen = self._seen.drawing
        if seen is None or seen.view.is_orthographic != (camera.height is not None):
            return False
        assert self.picture is not None
        before = self.picture.width
        picture, texture = self._followed(camera, size)
        self._free_picture()
        self._texture, self.picture = texture, picture
        if self._line < 1.0:
            self._draw_line(max(1, round(DIVIDER_PX * size[0] / before)))
        self.draw_count += 1
        self._seen.release()
        return True

    def _followed(
        self, camera: Camera, size: tuple[int, int]
    ) -> tuple[moderngl.Framebuffer, moderngl.Texture]:
        assert self._seen.drawing is not None and self._texture is not None
        view = self._seen.drawing.view
        texture = self._made(size)
        picture = make_framebuffer(self._gl, [texture])
        program = self._shaders.program(FULLSCREEN, "window/follow.frag", {}, view.choices)
        # None of the line comes along; beyond the frame there is no line.
        gap = DIVIDER_PX / self._texture.width
        ends = (self._line - gap, self._line + gap) if self._line < 1.0 else (2.0, 2.0)
        program.set(
            {
                **view.uniforms(),
                # The picture is of all places in a pixel.
                "u_jitter_ndc": (0.0, 0.0),
                "u_seen_from_now": view.view_from_world @ camera.view_from_world_rotation().T,
                "u_camera_seen_vs": view.view_from_world @ (camera.position - view.position_ws),
                "u_tan_half_fov_now": camera.tan_half_fov(size[0] / size[1]),
                "u_half_frame_now": camera.half_frame(size[0] / size[1]),
                "u_left_right": ends,
            },
            {"t_picture": self._texture, "t_z_vs": self._z_vs(self._seen.drawing)},
        )
        self._fill(program, picture, size, None)
        return picture, texture

    def show(self, pixels: NDArray[np.uint8]) -> None:
        """Take a picture made elsewhere, in the form of `pixels`."""
        height, width = pixels.shape[:2]
        self._fit((width, height))
        assert self._texture is not None
        opaque = np.full((height, width, 4), 255, np.uint8)
        opaque[:, :, :3] = pixels[::-1]
        self._texture.write(opaque.tobytes())

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture, shape (height, width, 3), sRGB, row 0 at the top."""
        assert self.picture is not None, "nothing was drawn yet"
        width, height = self.picture.size
        # What is bound may have been freed by now, and reading binds it again.
        self.picture.use()
        data = np.frombuffer(self.picture.read(components=3, alignment=1), np.uint8)
        return np.ascontiguousarray(data.reshape(height, width, 3)[::-1])

    def release(self) -> None:
        """Free every device object."""
        self._free_picture()
        self._seen.release()
        for texture in self._constants.values():
            texture.release()
        self._constants.clear()

    def _fit(self, size: tuple[int, int]) -> None:
        if self.picture is not None and self.picture.size == size:
            return
        self._free_picture()
        self._texture = self._made(size)
        self.picture = make_framebuffer(self._gl, [self._texture])

    def _made(self, size: tuple[int, int]) -> moderngl.Texture:
        texture = make_texture(self._gl, size, 4, "nu1")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return texture

    def _free_picture(self) -> None:
        for item in (self.picture, self._texture):
            if item is not None:
                item.release()
        self.picture = self._texture = None

    def _draw_image(
        self,
        image: LiveImage,
        kind: ColorMapping,
        region: tuple[int, int, int, int],
        bounds: tuple[FloatArray, FloatArray],
        exposure: float,
        curve: str,
    ) -> None:
        assert self.picture is not None and image.drawing is not None
        view = image.drawing.view
        plane, texture = self._plane(image)
        # A pixel of a picture that is stretched is several here, which have no edges between them.
        smoothing = image.edge_smoothing if texture.size == self.picture.size else 0.0
        defines = {
            "KIND": int(kind),
            "TONE_CURVE": int(curve == "aces"),
            "SMOOTH_EDGES": int(smoothing > 0.0),
        }
        program = self._shaders.program(FULLSCREEN, "window/present.frag", defines, view.choices)
        program.set(
            {
                "u_weight": image.weight if plane.texture is not None else 1.0,
                "u_smoothing": smoothing,
                "u_first_channel": plane.first_channel,
                "u_exposure_scale": 2.0**exposure,
                "u_world_from_view": view.view_from_world.T,
                **view.uniforms(),
                # In float64, because float32 cannot tell a room at 1e5 from its corner.
                "u_scene_low_rel_ws": bounds[0] - view.position_ws,
                "u_scene_high_rel_ws": bounds[1] - view.position_ws,
                "u_near_far": (view.near, view.far),
            },
            {"t_image": texture, "t_z_vs": self._z_vs(image.drawing)},
        )
        self._fill(program, self.picture, self.picture.size, region)

    def _draw_error(self, view: View, left: LiveImage, right: LiveImage, exposure: float) -> None:
        assert self.picture is not None
        defines = {"KIND": int(view.kind == ColorMapping.VISIBILITY)}
        program = self._shaders.program(FULLSCREEN, "window/error_colors.frag", defines)
        plane, texture = self._plane(left)
        other_plane, other_texture = self._plane(right)
        program.set(
            {
                "u_weight": left.weight if plane.texture is not None else 1.0,
                "u_other_weight": right.weight if other_plane.texture is not None else 1.0,
                "u_first_channel": plane.first_channel,
                "u_other_first_channel": other_plane.first_channel,
                "u_exposure_scale": 2.0**exposure,
                "u_range": view.error_range,
            },
            {"t_image": texture, "t_other": other_texture, "t_z_vs": self._z_vs(left.drawing)},
        )
        self._fill(program, self.picture, self.picture.size, None)

    def _plane(self, image: LiveImage) -> tuple[Plane, moderngl.Texture]:
        plane = image.plane
        if plane.texture is not None:
            return plane, plane.texture
        value = plane.neutral
        if value not in self._constants:
            data = np.full((1, 1, 4), value)
            self._constants[value] = make_texture(self._gl, (1, 1), 4, "f4", data)
        return plane, self._constants[value]

    @staticmethod
    def _z_vs(drawing: Drawing | None) -> moderngl.Texture:
        assert drawing is not None
        texture = drawing.planes["depth"].texture
        assert texture is not None, "the G-buffer always has depth"
        return texture

    def _fill(
        self,
        program: Program,
        target: moderngl.Framebuffer,
        size: tuple[int, int],
        region: tuple[int, int, int, int] | None,
    ) -> None:
        """Draw over `region` (x, y, width, height) of `target`, or all of it."""
        program.check_complete()
        self._gl.enable_only(moderngl.NOTHING)
        target.use()
        # Not target.size: that of the screen was read when its context was made.
        target.viewport = (0, 0, *size)
        target.scissor = region or (0, 0, *size)
        program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
        target.scissor = (0, 0, *size)
