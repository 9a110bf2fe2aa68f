"""Runs a compiled graph: owns its textures, reuses what cannot have changed, times."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.graph import Plan
from ssdo_gl.graph.render_pass import PassContext, ProgressCallback, RenderPass

if TYPE_CHECKING:
    import moderngl

    from ssdo_gl.gpu.context import Device
    from ssdo_gl.gpu.geometry import Geometry
    from ssdo_gl.gpu.shader import ShaderLibrary


@dataclass(frozen=True)
class PassTiming:
    """What one pass did in one frame.

    Attributes
    ----------
    name : str
    ran : bool
        False if its result of an earlier frame still held.
    gpu_ms : float or None
        Milliseconds by the executor's timer; None when timing was off or it was reused.
    cpu_ms : float
        Milliseconds until the pass had issued its commands.
    """

    name: str
    ran: bool
    gpu_ms: float | None
    cpu_ms: float


@dataclass
class _Slot:
    """What the executor remembers of a pass between frames."""

    key: Hashable
    version: int
    textures: dict[str, moderngl.Texture]
    made_here: tuple[moderngl.Texture, ...]
    target: moderngl.Framebuffer | None


class Executor:
    """Runs plans on one device and keeps the textures between frames.

    A pass runs again only when its settings, the size, a domain it depends on or
    one of the resources it reads has changed since its last run. Two passes of the
    same name in different plans replace each other.
    """

    def __init__(self, device: Device, shaders: ShaderLibrary) -> None:
        self._device = device
        self._shaders = shaders
        self._slots: dict[str, _Slot] = {}
        self._next_version = 1
        self.timer = Timer(device)

    def run(
        self,
        plan: Plan,
        frame: Frame,
        geometry: Geometry,
        *,
        time_passes: bool = False,
        progress: ProgressCallback | None = None,
    ) -> list[PassTiming]:
        """Run `plan` for `frame` and return one timing per pass, in order.

        Parameters
        ----------
        time_passes : bool
            Bracket every pass by the timer. On a software renderer this waits for
            each pass to finish, so passes no longer overlap.
        progress : ProgressCallback or None
            Handed to the passes.
        """
        textures: dict[str, moderngl.Texture] = {}
        versions: dict[str, int] = {}
        timings = []
        for item in plan.order:
            key = self._key(item, frame, versions)
            slot = self._slots.get(item.name)
            if slot is not None and slot.key == key:
                timings.append(PassTiming(item.name, False, None, 0.0))
            else:
                slot = self._prepare(item, frame.view.size)
                context = PassContext(
                    gl=self._device.gl,
                    shaders=self._shaders,
                    geometry=geometry,
                    frame=frame,
                    inputs={name: textures[name] for name in item.reads},
                    target=slot.target,
                    progress=progress,
                )
                timings.append(self._execute(item, slot, context, time_passes))
                slot.key = key
            textures.update(slot.textures)
            versions.update(dict.fromkeys(item.writes, slot.version))
        self._drop_unused({item.name for item in plan.order})
        return timings

    def texture(self, resource: str) -> moderngl.Texture:
        """Return the texture that the last run left in `resource`."""
        for slot in self._slots.values():
            if resource in slot.textures:
                return slot.textures[resource]
        raise KeyError(resource)

    def forget(self, names: Iterable[str] | None = None) -> None:
        """Make the named passes (all if None) run again in the next frame."""
        for name in list(self._slots) if names is None else names:
            if name in self._slots:
                self._slots[name].key = None

    def release(self) -> None:
        """Free every texture and framebuffer."""
        self._drop_unused(set())

    @staticmethod
    def _key(item: RenderPass, frame: Frame, versions: Mapping[str, int]) -> Hashable:
        return (
            type(item).__name__,
            item.settings_key(),
            tuple((name, spec) for name, spec in item.writes.items()),
            frame.view.size,
            tuple((name, versions[name]) for name in item.reads),
            tuple((domain, frame.versions.get(domain)) for domain in item.depends_on),
        )

    def _execute(
        self, item: RenderPass, slot: _Slot, context: PassContext, time_passes: bool
    ) -> PassTiming:
        if slot.target is not None:
            slot.target.use()
            slot.target.clear()
        start = time.perf_counter()
        gpu_ms = None
        if time_passes:
            with self.timer as timer:
                own = item.execute(context)
            gpu_ms = timer.elapsed_ms
        else:
            own = item.execute(context)
        cpu_ms = (time.perf_counter() - start) * 1e3
        slot.textures.update(own or {})
        missing = [name for name in item.writes if name not in slot.textures]
        if missing:
            raise RuntimeError(f"pass {item.name!r} did not return {', '.join(missing)}")
        slot.version = self._next_version
        self._next_version += 1
        return PassTiming(item.name, True, gpu_ms, cpu_ms)

    def _prepare(self, item: RenderPass, frame_size: tuple[int, int]) -> _Slot:
        """Return the slot of `item` with textures that fit its declaration."""
        gl = self._device.gl
        wanted = {name: spec for name, spec in item.writes.items() if not spec.own}
        slot = self._slots.get(item.name)
        if slot is not None:
            fits = list(wanted) == [n for n in slot.textures if n in wanted] and all(
                slot.textures[name].size == spec.size(frame_size)
                and slot.textures[name].components == spec.components
                and slot.textures[name].dtype == spec.dtype
                for name, spec in wanted.items()
            )
            if fits and len(wanted) == len(slot.made_here):
                slot.textures = {name: slot.textures[name] for name in wanted}
                return slot
            self._free(slot)
        made = {
            name: make_texture(gl, spec.size(frame_size), spec.components, spec.dtype)
            for name, spec in wanted.items()
        }
        target = make_framebuffer(gl, list(made.values()), item.needs_depth) if made else None
        slot = _Slot(None, 0, dict(made), tuple(made.values()), target)
        self._slots[item.name] = slot
        return slot

    def _drop_unused(self, names: set[str]) -> None:
        for name in [n for n in self._slots if n not in names]:
            self._free(self._slots.pop(name))

    @staticmethod
    def _free(slot: _Slot) -> None:
        if slot.target is not None:
            depth = slot.target.depth_attachment
            slot.target.release()
            if depth is not None:
                depth.release()
        for texture in slot.made_here:
            texture.release()
