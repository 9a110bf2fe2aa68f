"""Decides from a scene's content and what was asked for which effects can matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ssdo_gl.scene.content import SceneContent
from ssdo_gl.settings import Combine, Settings


@dataclass(frozen=True)
class Decision:
    """One effect, whether it is simulated, and why, in a sentence for the user."""

    effect: str
    run: bool
    reason: str


@dataclass(frozen=True)
class Effects:
    """What the pipeline has to compute.

    Attributes
    ----------
    direct : bool
        Light of the lights that are not marked ``ssdo``.
    shadow_map, traced_shadows : bool
    visibility : bool
        A scalar visibility is wanted or multiplies something.
    directional : bool
        Light of the environment or of ``ssdo`` lights through open directions.
    bounce : bool
    back_layer : bool
        The nearest back face bounds the thickness of closed bodies.
    """

    direct: bool
    shadow_map: bool
    traced_shadows: bool
    visibility: bool
    directional: bool
    bounce: bool
    back_layer: bool
    decisions: tuple[Decision, ...]


class _Decider:
    """Collects decisions; with ``effects = full`` every effect that was asked for runs."""

    def __init__(self, full: bool) -> None:
        self.full = full
        self.rows: list[Decision] = []

    def wanted(self, effect: str, why: str, skips: Sequence[tuple[bool, str]]) -> bool:
        """Record `effect`: skipped for the first true reason in `skips`, else run."""
        for holds, reason in skips:
            if holds and not self.full:
                self.rows.append(Decision(effect, False, reason))
                return False
        self.rows.append(Decision(effect, True, why))
        return True

    def never(self, effect: str, reason: str) -> bool:
        """Record that nothing asked for `effect`."""
        self.rows.append(Decision(effect, False, reason))
        return False


def decide(content: SceneContent, settings: Settings, wanted: Sequence[str]) -> Effects:
    """Return what must be computed for the images `wanted` of a scene.

    Parameters
    ----------
    content : SceneContent
    settings : Settings
        ``effects="full"`` takes no notice of the content.
    wanted : sequence of str
        AOV names or ``display``.
    """
    decider = _Decider(settings.effects == "full")
    method = settings.method
    shaded = bool({"beauty", "display"} & set(wanted))
    sends = (method in ("bounce", "reference-near") and shaded) or (
        method not in ("direct", "ssao", "ssdo") and "bounce" in wanted
    )
    reads_direct = (shaded and method != "reference-gi") or sends or "direct" in wanted
    reads_directional = (method in ("ssdo", "bounce", "reference-near") and (shaded or sends)) or (
        method not in ("direct", "ssao") and (sends or "directional" in wanted)
    )
    multiplies = method in ("ssao", "reference-ao") and shaded

    direct = reads_direct and decider.wanted(
        "direct light",
        "the scene has lights",
        [(not content.has_direct_lights, "the scene has no light of its own but its environment")],
    )
    mapped = direct and settings.chosen_shadows == "map"
    shadow_map = mapped and decider.wanted(
        "shadow maps",
        "lights cast shadows",
        [(not content.has_shadowed_lights, "no light is marked shadow = map")],
    )
    directional = reads_directional and decider.wanted(
        "directional occlusion",
        "light comes from the environment or from lights marked shadow = ssdo",
        [(not content.has_distant_light, "there is neither an environment nor an ssdo light")],
    )
    lit = content.has_direct_lights or content.has_distant_light or content.has_unlit_emission
    bounce = sends and decider.wanted(
        "bounce",
        "lit surfaces send light to their neighbours",
        [
            (not content.has_albedo, "every surface is black, nothing is sent on"),
            (not lit, "nothing is lit"),
        ],
    )
    visibility = "visibility" in wanted or (
        multiplies
        and decider.wanted(
            "ambient visibility",
            "visibility multiplies light",
            [
                (
                    effective_combine(content, settings) == "ambient"
                    and content.environment == "none",
                    "there is no environment light for it to multiply",
                )
            ],
        )
    )
    marches = settings.chosen_estimator == "march" and not settings.is_reference
    screen_space = (directional or bounce or visibility) and marches
    back_layer = screen_space and decider.wanted(
        "back-face layer",
        "closed bodies have a back that bounds their thickness",
        [(not content.has_closed_meshes, "no mesh is closed, so there is no back to find")],
    )
    return Effects(
        direct=direct,
        shadow_map=shadow_map,
        traced_shadows=direct and settings.chosen_shadows == "traced",
        visibility=visibility,
        directional=directional,
        bounce=bounce,
        back_layer=back_layer,
        decisions=tuple(decider.rows),
    )


def effective_combine(content: SceneContent, settings: Settings) -> Combine:
    """Return what visibility multiplies: the chosen mode, or by the scene's light.

    Environment light alone where there is one (the physical reading), else direct
    light too, as common viewers do.
    """
    if settings.combine is not None:
        return settings.combine
    return "multiply" if content.environment == "none" else "ambient"
