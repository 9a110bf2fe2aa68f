"""One image of the window: redrawn while something moves, refined while nothing does."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import moderngl

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.average import middle_index
from ssdo_gl.images.display import ColorMapping
from ssdo_gl.render_result import Drawing, Plane
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings import Settings
from ssdo_gl.window.views import is_averaged

# Frames averaged at rest. Sixteen sub-pixel offsets leave edges with steps of a
# sixteenth of the contrast, and a quarter of the estimators' noise.
REFINE_FRAMES = 16
# In which order: the one nearest to the pixel's centre first, because that is what is
# seen while moving, then in steps that spread over the pixel early.
_ORDER = tuple((middle_index(REFINE_FRAMES) + 7 * k) % REFINE_FRAMES for k in range(REFINE_FRAMES))
# A reference in the background may keep input waiting this long.
CHUNK_MS = 60.0
# A reference takes at most so many samples per frame.
MAX_CHUNK = 64
# Larger values are faults, which frames to come make good: no light brings so much.
VALUE_BOUND = 1e18


@dataclass(frozen=True)
class FrameRequest:
    """What a frame is to show; two equal requests refine one another.

    Attributes
    ----------
    image : str
        AOV name or ``display``.
    settings : Settings
        With the size in pixels; ``spp`` of a reference is when it counts as refined.
    seconds : float
        Of the animation.
    extra : tuple of str
        Images that are drawn besides and not averaged.
    """

    image: str
    kind: ColorMapping
    camera: Camera
    settings: Settings
    seconds: float = 0.0
    extra: tuple[str, ...] = ()

    @property
    def samples_wanted(self) -> int:
        """How many samples (frames, or a reference's rays per pixel) make it refined."""
        if not is_averaged(self.kind):
            return 1
        return self.settings.spp if self.settings.is_reference else REFINE_FRAMES


class LiveImage:
    """Draws what is requested and averages it for as long as the request stays the same.

    Attributes
    ----------
    drawing : Drawing or None
        The last frame.
    sample_count : int
        Samples in the sum.
    last_samples : int
        Samples of the last frame: a reference takes several while nothing moves.
    """

    def __init__(self, renderer: Renderer, device: Device, shaders: ShaderLibrary) -> None:
        self.renderer = renderer
        self.drawing: Drawing | None = None
        self.sample_count = 0
        self.last_samples = 0
        self._device = device
        self._shaders = shaders
        self._request: FrameRequest | None = None
        self._applied: Settings | None = None
        self._frames = 0
        # Samples per frame of a reference: what the time allows, and what this round takes.
        self._chunk = self._samples = 1
        # Two sums: what a frame is added to, and what comes of it.
        self._sums: list[moderngl.Texture] = []
        self._targets: list[moderngl.Framebuffer] = []

    @property
    def is_refined(self) -> bool:
        """Whether another frame would not add anything that was asked for."""
        wanted = None if self._request is None else self._request.samples_wanted
        return wanted is not None and self.sample_count >= wanted and self._is_settled

    @property
    def _is_settled(self) -> bool:
        return self.drawing is None or self.drawing.is_settled

    def has_offsets_of(self, other: LiveImage) -> bool:
        """Return whether both images average the same sub-pixel offsets, alike."""
        are_whole = self._frames % REFINE_FRAMES == other._frames % REFINE_FRAMES == 0
        return are_whole or self._frames == other._frames

    @property
    def samples_wanted(self) -> int:
        """How many samples make the present image refined."""
        return 0 if self._request is None else self._request.samples_wanted

    @property
    def shows(self) -> FrameRequest | None:
        """What the sum is of; None before the first frame."""
        return self._request

    @property
    def plane(self) -> Plane:
        """The image: a sum over `sample_count` samples, or the last frame itself."""
        assert self.drawing is not None and self._request is not None, "nothing was drawn yet"
        plane = self.drawing.planes[self._request.image]
        if plane.texture is None or not is_averaged(self._request.kind):
            return plane
        return Plane(self._sums[0], plane.first_channel)

    @property
    def last_plane(self) -> Plane:
        """The image as the last frame drew it: a sum leaves out what is not finite."""
        assert self.drawing is not None and self._request is not None, "nothing was drawn yet"
        return self.drawing.planes[self._request.image]

    @property
    def weight(self) -> float:
        """What the plane's numbers have to be multiplied with."""
        assert self._request is not None, "nothing was drawn yet"
        return 1.0 / self.sample_count if is_averaged(self._request.kind) else 1.0

    @property
    def edge_smoothing(self) -> float:
        """How much of the steps of edges is to be taken away from what is shown.

        All of it of a picture in motion, whose pixels show one point each; less and less of an
        average, which has smooth edges once it is of all offsets; none of the samples of a
        reference, and of numbers.
        """
        assert self._request is not None, "nothing was drawn yet"
        is_picture = self._request.kind is ColorMapping.DISPLAY
        if not is_picture or self._request.settings.is_reference or self._frames >= REFINE_FRAMES:
            return 0.0
        return 1.0 / self._frames

    def restart(self) -> None:
        """Forget what was drawn: shaders or the scene have changed."""
        self.drawing = None
        self._request = self._applied = None
        self.sample_count = 0

    def update(
        self,
        request: FrameRequest,
        *,
        time_passes: bool = False,
        progress: ProgressCallback | None = None,
    ) -> bool:
        """Draw one frame towards `request`; return whether there was anything to draw.

        Whatever `progress` or a shader raises leaves an average as it was. Of another
        request nothing is left then, and nothing of the one before: there is no `drawing`.
        """
        if request == self._request and self.is_refined:
            return False
        # What is not settled yet must not stay in the average.
        goes_on = request == self._request and self._is_settled
        frame = self._frames if goes_on else 0
        index = _ORDER[frame % REFINE_FRAMES] + frame // REFINE_FRAMES * REFINE_FRAMES
        samples = 1
        settings = request.settings
        if settings.is_reference:
            samples = self._samples_of_round(request, frame)
            settings = dataclasses.replace(settings, spp=samples)
        # Not the renderer's own settings: it has filled in what the scene decides.
        if settings != self._applied:
            self.renderer.use(settings)
            self._applied = settings
        try:
            drawing = self.renderer.draw(
                [request.image, *request.extra],
                camera=request.camera,
                seconds=request.seconds,
                index=index if is_averaged(request.kind) else 0,
                count=REFINE_FRAMES if is_averaged(request.kind) else 1,
                time_passes=time_passes,
                progress=progress,
            )
        except BaseException:
            if not goes_on:
                # Other passes, or another size: the textures of the drawing may be freed.
                self.restart()
            raise
        if not goes_on:
            self._request, self._frames, self.sample_count = request, 0, 0
        if settings.is_reference:
            self._choose_chunk(samples, drawing.frame_ms)
        self.drawing = drawing
        self._add(drawing.planes[request.image], samples)
        self._frames += 1
        self.sample_count += samples
        self.last_samples = samples
        if progress is not None:
            # To turn the sum into colours takes as long again.
            self._device.gl.finish()
            progress("sum", 1, 1)
        return True

    def release(self) -> None:
        """Free the sums and the renderer."""
        self._free_sums()
        self.renderer.release()

    def _samples_of_round(self, request: FrameRequest, frame: int) -> int:
        """Return how many samples of a reference the next frame takes.

        Each round of REFINE_FRAMES frames takes as many through every sub-pixel offset:
        only then do edges agree with those of the other methods' average.
        """
        if frame == 0:
            # A view that may change with the next frame gets the least there is.
            self._samples = 1
        elif frame % REFINE_FRAMES == 0:
            left = request.samples_wanted - self.sample_count
            self._samples = max(1, min(self._chunk, left // REFINE_FRAMES))
        return self._samples

    def _choose_chunk(self, samples: int, frame_ms: float) -> None:
        """Take as many samples per frame as fit the time one may wait for the input map."""
        if frame_ms > CHUNK_MS:
            self._chunk = max(1, samples // 2)
        elif frame_ms < 0.4 * CHUNK_MS:
            self._chunk = min(2 * samples, MAX_CHUNK)

    def _add(self, plane: Plane, samples: int) -> None:
        if plane.texture is None:
            return
        if not self._sums or self._sums[0].size != plane.texture.size:
            self._make_sums(plane.texture.size)
        is_encoded = self._request is not None and self._request.kind is ColorMapping.DISPLAY
        program = self._shaders.fullscreen("window/live_sum.frag", {"IS_ENCODED": int(is_encoded)})
        draw_fullscreen(
            self._device.gl,
            program,
            self._targets[1],
            {
                "u_weight": float(samples),
                "u_count": float(self.sample_count),
                "u_bound": VALUE_BOUND,
            },
            {"t_image": plane.texture, "t_sum": self._sums[0]},
        )
        self._sums.reverse()
        self._targets.reverse()

    def _make_sums(self, size: tuple[int, int]) -> None:
        self._free_sums()
        gl = self._device.gl
        self._sums = [make_texture(gl, size, 4, "f4") for _ in range(2)]
        for item in self._sums:
            # A picture that is smaller than the window is stretched smoothly.
            item.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._targets = [make_framebuffer(gl, [item]) for item in self._sums]

    def _free_sums(self) -> None:
        for target in self._targets:
            target.release()
        for texture in self._sums:
            texture.release()
        self._targets, self._sums = [], []
