"""The contract of a pass: what it reads, what it writes, what it depends on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.resource import TextureSpec

if TYPE_CHECKING:
    import moderngl

    from ssdo_gl.gpu.geometry import Geometry
    from ssdo_gl.gpu.shader import ShaderLibrary


# Called with (what is being done, steps done, steps in all) by long passes.
ProgressCallback = Callable[[str, int, int], None]


class TextureWithFacts(NamedTuple):
    """An ``own`` texture, and what its readers need to know of it on the host.

    Facts are kept with the texture and are as old as it is, so that nobody looks up
    again what was known when it was made.
    """

    texture: moderngl.Texture
    facts: object


Produced = Mapping[str, "moderngl.Texture | TextureWithFacts"]


# Not frozen, which would take another 1.6 us for each pass.
@dataclass
class PassContext:
    """What a pass gets in order to run.

    Attributes
    ----------
    geometry : Geometry
        The scene's triangles on the device.
    inputs : mapping of resource name to moderngl.Texture
        Exactly the resources that the pass declared in ``reads``.
    target : moderngl.Framebuffer or None
        Colour attachments in the order of ``writes`` (those not ``own``); cleared
        to zero unless the pass ``overwrites``; viewport set. None if the pass writes none.
    progress : ProgressCallback or None
        For passes of many draws.
    facts : mapping of resource name to object
        Of those ``inputs`` whose producer gave some.
    last : mapping of resource name to TextureWithFacts
        Of a gradual pass in a live frame, and of one that draws over, what it returned last
        time; facts may be None.
    is_complete : bool
        Whether no pass before it in this frame has left to later frames what is missing now.
    """

    gl: moderngl.Context
    shaders: ShaderLibrary
    geometry: Geometry
    frame: Frame
    inputs: Mapping[str, moderngl.Texture]
    target: moderngl.Framebuffer | None
    progress: ProgressCallback | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    last: Mapping[str, TextureWithFacts] = field(default_factory=dict)
    is_complete: bool = True


class RenderPass(ABC):
    """One step of a frame.

    A pass is one small class and one shader of the same stem. It declares what it
    reads and writes and never reaches for anything else. It holds no image state:
    running it twice with the same inputs gives the same bytes. Passes of one name and class that
    were made of equal arguments make the same.

    Attributes
    ----------
    name : str
        Unique in a graph; the stem of its file and shader unless it runs twice.
    reads : tuple of str
        Resource names.
    steady_reads : tuple of str
        Those whose change makes nothing stale: of all frames of a steady view the first
        one's are read, and the domain ``steady_view`` stands for them.
    depends_on : tuple of str
        Domains of ``Frame.versions`` that change the result beyond ``reads``.
    needs_depth : bool
        Whether its framebuffer gets a 24-bit depth attachment.
    overwrites : bool
        Whether it writes every pixel of its target, which is then not cleared before:
        that takes .94 to .98 of a frame's time in software.
    draws_over : bool
        It draws anew into what it returned last, which nobody reads any more.
    is_gradual : bool
        In live frames it does part of its work at a time.
    lags : bool
        What it leaves to later frames is missing until then, not only noisier.
    is_settled : bool
        False after a part of the work: the pass runs again in the next frame.
    statistics : mapping
        What a Monte-Carlo pass has to say of its last run (samples per pixel,
        standard errors, whether it was interrupted); empty for all others.
    given, named : tuple, mapping
        The arguments that it was made of.
    """

    name: str
    reads: tuple[str, ...] = ()
    writes: Mapping[str, TextureSpec]
    steady_reads: tuple[str, ...] = ()
    depends_on: tuple[str, ...] = ()
    needs_depth: ClassVar[bool] = False
    overwrites: ClassVar[bool] = False
    draws_over: ClassVar[bool] = False
    is_gradual: ClassVar[bool] = False
    lags: ClassVar[bool] = True
    is_settled: bool = True
    statistics: Mapping[str, Any] = MappingProxyType({})
    given: tuple[Any, ...]
    named: Mapping[str, Any]

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """Note what the pass is made of."""
        item = super().__new__(cls)
        item.given, item.named = given, named
        return item

    def settings_key(self) -> Hashable:
        """Return what tells passes of one class apart."""
        return _hashable((self.given, self.named))

    def changed(self, **others: Any) -> Self:
        """Return one that is made of `others` of its arguments by name."""
        return type(self)(*self.given, **{**self.named, **others})

    def gets_last(self, frame: Frame) -> bool:
        """Return whether it is given what it returned last."""
        return self.draws_over or (frame.is_live and self.is_gradual)

    @abstractmethod
    def execute(self, context: PassContext) -> Produced | None:
        """Run; return the textures of ``own`` resources, newly made or kept."""


def _hashable(value: Any) -> Hashable:
    """Return arguments with tuples for the containers that could change."""
    if isinstance(value, Mapping):
        return tuple((name, _hashable(item)) for name, item in value.items())
    if isinstance(value, list | tuple):
        return tuple(map(_hashable, value))
    return frozenset(value) if isinstance(value, set) else value
