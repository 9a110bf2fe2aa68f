"""What an effect declares: when a frame calls for it, its passes, and its part of the picture."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from ssdo_gl.effects.request import Decision, Request, Shortcut
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.composite import OcclusionMode

# A pass, and why it runs, in words for the user.
ReasonedPass = tuple[RenderPass, str]


@dataclass(frozen=True)
class Term:
    """Light that an effect adds to the picture.

    Attributes
    ----------
    name : str
        As ``--aov`` knows it.
    resource : str
        The image of the frame graph that holds it, full size, rgb.
    kind : str
        ``irradiance`` (W m^-2) is reflected by the surface; ``radiance`` (W sr^-1 m^-2)
        is added as it is, and its alpha is 1 where senders pass it on.
    glossy : bool
        There only where `Request.is_glossy`.
    """

    name: str
    resource: str
    kind: Literal["irradiance", "radiance"] = "irradiance"
    glossy: bool = False


@dataclass(frozen=True)
class ImageSource:
    """Where an image comes from: channels of a resource, or a neutral constant."""

    resource: str | None
    channels: int
    first_channel: int = 0
    neutral: float = 0.0


class Effect(ABC):
    """One effect: a class, a shader and a test.

    Attributes
    ----------
    name : str
        Unique; how other effects ask whether it runs.
    after : tuple of str
        Effects that are decided before it, because it asks about them, and whose terms come
        before its own in sums. What serves others (no `methods`, no `shown_by`) comes last.
    methods : frozenset of str
        The methods whose picture it is part of.
    shown_by : frozenset of str
        Methods in which its images may be asked for, beyond `methods`.
    terms : tuple of Term
        What it adds to the picture; each is an image of its own, too.
    images : tuple of str
        Further images that it can show.
    shortcuts : tuple of Shortcut
        Those that it may take; all are settled before any pass is made.
    settings : mapping of str to type
        Settings class of each of its passes, for ``--set PASS.FIELD=VALUE``.
    picture : str or None
        The resource that is the whole picture; None: the terms are added up.
    gathers_from_senders : bool
        Reads ``sender_radiance``: what other effects send on.
    looks_around : bool
        Looks for what blocks directions in the depth buffer (`ScreenSpaceSettings`).
    traces : bool
        Traces rays, and needs the scene as tables.
    sent_irradiance : str or None
        A resource that stands in for the irradiance of all terms where surfaces send it on.
    reads_surface_cache : bool
        Looks up what light surfaces receive (``rays/surface_cache.glsl``).
    """

    name: ClassVar[str]
    after: ClassVar[tuple[str, ...]] = ()
    methods: ClassVar[frozenset[str]] = frozenset()
    shown_by: ClassVar[frozenset[str]] = frozenset()
    terms: ClassVar[tuple[Term, ...]] = ()
    images: ClassVar[tuple[str, ...]] = ()
    shortcuts: ClassVar[tuple[Shortcut, ...]] = ()
    settings: ClassVar[Mapping[str, type[Any]]] = MappingProxyType({})
    picture: ClassVar[str | None] = None
    gathers_from_senders: ClassVar[bool] = False
    looks_around: ClassVar[bool] = False
    traces: ClassVar[bool] = False
    sent_irradiance: ClassVar[str | None] = None
    reads_surface_cache: ClassVar[bool] = False

    def is_asked(self, request: Request) -> bool:
        """Return whether the picture, an image or another effect asks for this one.

        By default: it is part of the picture, one of its images is wanted, or another
        effect gathers what it sends. Effects that only serve others say here whom.
        """
        return self.name in request.asked

    @abstractmethod
    def need(self, request: Request) -> Decision:
        """Return whether it can matter in this frame, and why."""

    @abstractmethod
    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield its passes, each with its reason; called once all is decided."""

    def terms_of(self, request: Request) -> list[Term]:
        """Return those of `terms` that it adds in this frame."""
        return [term for term in self.terms if request.is_glossy or not term.glossy]

    def sends(self, request: Request) -> bool:
        """Return whether what its terms add is sent on to other surfaces."""
        return bool(self.terms)

    def sent_terms(self, request: Request) -> Iterable[Term]:
        """Return its terms as senders read them: these need no filter."""
        return self.terms

    def image(self, request: Request, name: str) -> ImageSource | None:
        """Return where one of `images` is read from; None if another effect has it."""
        return None

    def occlusion(self, request: Request) -> tuple[str, OcclusionMode] | None:
        """Return a visibility by which the composite multiplies light, and which light."""
        return None

    def marches(self, request: Request) -> str | None:
        """Return whose settings its march through all directions follows; None: none does."""
        return None
