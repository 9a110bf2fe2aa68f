"""A widget that flies through a scene in Jupyter, VS Code and marimo."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import anywidget
import traitlets

from ssdo_gl.notebook.kernel_flight import KernelFlight
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings


class FlyWidget(anywidget.AnyWidget):
    """The fly-through of a scene, with the keys and the mouse of the window.

    JPEG in motion, lossless at rest. Parameters are those of `KernelFlight`; `size` is the
    largest in CSS pixels, and `still` a PNG file for readers that show no widgets.
    """

    _esm = "\n".join(
        files("ssdo_gl").joinpath(name).read_text(encoding="utf-8")
        for name in ("serve/page/mouse.js", "notebook/fly_widget.js")
    )
    width = traitlets.Int(640).tag(sync=True)
    height = traitlets.Int(360).tag(sync=True)

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        camera: Camera,
        size: tuple[int, int],
        still: bytes,
        **options: Any,
    ) -> None:
        super().__init__(width=size[0], height=size[1])
        self._still = still
        self._flight = KernelFlight(scene, settings, camera, size, self._tell_pages, **options)
        self.on_msg(lambda _widget, content, _buffers: self._flight.hear(content))

    @property
    def camera(self) -> Camera:
        """Where one has flown to."""
        return self._flight.camera

    def close(self) -> None:
        """End the drawing, and the widget."""
        self._flight.stop()
        super().close()

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        bundle = super()._repr_mimebundle_(**kwargs)
        data = bundle[0] if isinstance(bundle, tuple) else bundle
        if data is not None:
            data["image/png"] = self._still
        return bundle

    def _tell_pages(self, message: Mapping[str, Any], files: list[bytes]) -> None:
        self.send(dict(message), files)
