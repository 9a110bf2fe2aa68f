"""What can be decided about a frame: which effects are simulated, and how."""

from __future__ import annotations

from dataclasses import dataclass


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
    emission : bool
        Surfaces emit, so the picture needs their emission.
    sender_emission : bool
        No light delivers some of it, so the bounce needs it, too.
    is_open : bool
        Nothing within R blocks any direction of any visible point.
    is_scalar : bool
        Directional light is one colour times visibility.
    shares_directions : bool
        The bounce takes over what the first estimator found blocked.
    samples_hemisphere : bool
        The directional estimator looks in all directions, not only at lights.
    lights, shadow_maps : tuple of bool, or None
        For each light of the scene, whether it can matter, and whether it needs a shadow
        map. None: as the scene says.
    simplifies_environment : bool
        An environment that is black or of one colour is treated as such.
    """

    direct: bool = False
    shadow_map: bool = False
    traced_shadows: bool = False
    visibility: bool = False
    directional: bool = False
    bounce: bool = False
    back_layer: bool = False
    emission: bool = True
    sender_emission: bool = True
    is_open: bool = False
    is_scalar: bool = False
    shares_directions: bool = False
    samples_hemisphere: bool = True
    lights: tuple[bool, ...] | None = None
    shadow_maps: tuple[bool, ...] | None = None
    simplifies_environment: bool = False
    decisions: tuple[Decision, ...] = ()
