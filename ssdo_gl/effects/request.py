"""What one frame is asked for, and what is known and decided about it so far."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

from ssdo_gl.facts.content import SceneContent
from ssdo_gl.facts.view import ViewFacts
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import describe
from ssdo_gl.settings.settings import Settings

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


@dataclass(frozen=True)
class Decision:
    """One effect, whether it is simulated, and why, in a sentence for the user.

    Attributes
    ----------
    passes : tuple of str
        The passes of the full pipeline that it decides about.
    instead : tuple of str
        What runs in their place.
    """

    effect: str
    run: bool
    reason: str
    passes: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()


@dataclass(frozen=True)
class Decided:
    """All that was decided about a frame: two frames with equal ones run the same passes.

    Attributes
    ----------
    running : frozenset of str
        Names of the effects that run.
    lights : tuple of bool, or None
        For each light of the scene, whether it can matter. None: as the scene says.
    rows : tuple of Decision
        In the order in which they were taken.
    """

    running: frozenset[str]
    lights: tuple[bool, ...] | None
    rows: tuple[Decision, ...]

    def runs(self, *names: str) -> bool:
        """Return whether any of the effects of these names runs."""
        return not self.running.isdisjoint(names)

    def spares(self, effect: str) -> bool:
        """Return whether a row says that `effect`, as users know it, is not simulated."""
        return any(row.effect == effect and not row.run for row in self.rows)


PassSettings = TypeVar("PassSettings", bound="DataclassInstance")


def overridden(settings: Settings, name: str, base: PassSettings) -> PassSettings:
    """Return `base` with the values of ``--set NAME.FIELD=VALUE`` for the pass called `name`."""
    prefix = f"{name}."
    own = {
        key.removeprefix(prefix): value
        for key, value in settings.overrides.items()
        if key.startswith(prefix)
    }
    return dataclasses.replace(base, **own)


@dataclass(frozen=True)
class Shortcut:
    """A cheaper way to the same image, open only where the scene or the view allows it.

    Attributes
    ----------
    name : str
        What is spared, for the user.
    reason : callable
        Says for a `Request` why the shortcut may be taken, or returns None.
    passes, instead : tuple of str
        As in `Decision`.
    """

    name: str
    reason: Callable[[Request], str | None]
    passes: tuple[str, ...]
    instead: tuple[str, ...] = ()


class Request:
    """The question that effects answer, one after the other.

    Parameters
    ----------
    scene : Scene
        At rest.
    settings : Settings
        With its radius filled in. ``effects="full"`` takes no notice of content and view.
    wanted : sequence of str
        Image names, or ``display``.
    view : ViewFacts or None
        What is known of the view; without it, the view rules nothing out.
    is_live : bool
        Of the frames of a window, which may be averaged with those before them.

    Attributes
    ----------
    asked : frozenset of str
        Names of the effects that picture or images ask for.
    pass_settings : mapping of str to type
        The settings classes of all passes, by pass name; whoever asks the effects fills it in,
        and what follows.
    running : list of str
        Names of the effects that were decided to run, in the order of the registry.
    traces : bool
        Whether rays are traced: their tables hold the scene as it is.
    looks_around, reads_surface_cache : bool
        Whether an effect runs that does.
    anything_is_sent : bool
        Whether any effect that runs gives surfaces something to send on.
    marches : list of callable
        `Effect.marches` of those that run.
    kept_refinements : int or None
        A later effect takes over which directions the first march finds blocked, refined
        by so many bisections; None: nobody does.
    """

    def __init__(
        self,
        scene: Scene,
        content: SceneContent,
        settings: Settings,
        wanted: Sequence[str],
        view: ViewFacts | None = None,
        *,
        is_live: bool = False,
    ) -> None:
        assert settings.radius is not None, "the renderer fills the radius in"
        self.scene = scene
        self.content = content
        self.settings = settings
        self.radius: float = settings.radius
        self.wanted = tuple(wanted)
        self.is_full = settings.effects == "full"
        # Rays leave the view: what it does not show may matter to them.
        self.view = None if self.is_full or settings.is_reference else view
        self.pass_settings: Mapping[str, type[Any]] = {}
        self.is_live = is_live
        self.asked: frozenset[str] = frozenset()
        self.kept_refinements: int | None = None
        self.running: list[str] = []
        self.traces = settings.is_reference
        self.looks_around = self.reads_surface_cache = self.anything_is_sent = False
        self.marches: list[Callable[[Request], str | None]] = []
        self._shortcuts: dict[str, bool] = {}
        self._rows: list[Decision] = []
        self._is_decided = False

    @property
    def shows_picture(self) -> bool:
        """Whether the picture itself is wanted, linear or tone-mapped."""
        return bool({"beauty", "display"} & set(self.wanted))

    @property
    def is_glossy(self) -> bool:
        """Whether any surface in view may reflect more than diffuse light.

        If none does, a frame of a scanned rabbit takes .76 of the time with `gi`.
        """
        in_view = self.view is None or self.view.gloss_region is not None
        return self.is_full or (self.content.has_gloss and in_view)

    @cached_property
    def ray_features(self) -> RayFeatures:
        """What rays can meet, in view or not."""
        glossy = self.is_full or self.content.has_gloss
        features = RayFeatures.of(self.scene)
        return dataclasses.replace(features, glossy=glossy, lobes=glossy and features.lobes)

    @cached_property
    def cache_features(self) -> RayFeatures:
        """The same for what looks light up in the surface cache.

        What tilted normals receive depends on how grazing it arrives, which gloss asks for, too.
        """
        features = self.ray_features
        return dataclasses.replace(features, glossy=features.glossy or features.normal_maps)

    @property
    def is_view_empty(self) -> bool:
        """Whether no surface is in view."""
        return self.view is not None and self.view.is_empty

    @cached_property
    def lights(self) -> tuple[bool, ...]:
        """For each light of the scene, whether it can matter."""
        return tuple(self.is_full or light.is_on for light in self.content.lights)

    def has_light(self, *shadows: str) -> bool:
        """Return whether any light that can matter has one of these kinds of shadow."""
        pairs = zip(self.content.lights, self.lights, strict=True)
        return any(chosen and light.shadow in shadows for light, chosen in pairs)

    def settings_of(self, name: str, kind: type[PassSettings], **known: Any) -> PassSettings:
        """Return the settings of the pass called `name`.

        The user's own for that pass, else those `known` of this frame, else what `Settings` holds
        under the same name for the whole rendering, else their defaults.
        """
        shared = {field.name for field in dataclasses.fields(kind)} & describe(Settings).keys()
        common = {field: getattr(self.settings, field) for field in shared}
        return overridden(self.settings, name, kind(**{**common, **known}))

    def override(self, name: str, default: Any) -> Any:
        """Return the user's value of ``PASS.FIELD``, or `default`."""
        return self.settings.overrides.get(name, default)

    def decision(
        self,
        effect: str,
        why: str,
        skips: Sequence[tuple[bool, str]],
        passes: tuple[str, ...] = (),
    ) -> Decision:
        """Return the decision on `effect`: skipped for the first true reason, else run.

        With ``effects="full"`` it runs whatever the reasons say.
        """
        reason = None if self.is_full else next((text for holds, text in skips if holds), None)
        return Decision(effect, reason is None, reason or why, passes)

    def record(self, decision: Decision) -> None:
        """Add a row to what the user is told."""
        if decision not in self._rows:
            self._rows.append(decision)

    def runs(self, *names: str) -> bool:
        """Return whether any of these effects was decided to run."""
        return any(name in names for name in self.running)

    @property
    def averages(self) -> bool:
        """Whether images of a window are averaged over frames."""
        is_wanted = self.settings.temporal == "on" and not self.settings.is_reference
        return self.is_live and is_wanted and self.looks_around

    @property
    def first_march(self) -> str | None:
        """The pass that looks in all directions first, by whose settings it does so."""
        return next(filter(None, (marches(self) for marches in self.marches)), None)

    def takes(self, shortcut: Shortcut) -> bool:
        """Return whether a shortcut is taken; asked for the first time, it is recorded.

        Raises
        ------
        LookupError
            Once all is decided, of a shortcut that no running effect declares: plans are
            kept by what was decided.
        """
        known = self._shortcuts.get(shortcut.name)
        if known is not None:
            return known
        if self._is_decided:
            raise LookupError(f"no running effect declares the shortcut {shortcut.name!r}")
        reason = None if self.is_full or self.settings.is_reference else shortcut.reason(self)
        self._shortcuts[shortcut.name] = reason is not None
        if reason is not None:
            self.record(Decision(shortcut.name, False, reason, shortcut.passes, shortcut.instead))
        return reason is not None

    def decided(self) -> Decided:
        """Return all that was decided; nothing is decided after that."""
        self._is_decided = True
        spares_lights = not (self.is_full or self.traces)
        return Decided(
            running=frozenset(self.running),
            lights=self.lights if spares_lights else None,
            rows=tuple(self._rows),
        )
