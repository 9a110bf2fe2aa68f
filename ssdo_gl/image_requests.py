"""What a caller asks to have rendered, checked: images by name, from a camera."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral

from ssdo_gl.effects.registry import effects, image_names
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.suggestion import suggestion


def checked_images(wanted: Iterable[str], frames: int = 1) -> tuple[str, ...]:
    """Return the images that are asked for, each once; raises SettingError, on `frames` too."""
    if not isinstance(frames, Integral) or frames < 1:
        raise SettingError(f"frames = {frames!r}: expected a whole number from 1")
    if isinstance(wanted, str) or not hasattr(wanted, "__iter__"):
        raise SettingError(f"images = {shown(wanted)}: expected a list of names")
    names, known = tuple(wanted), (*image_names(), "display")
    for name in names:
        if name not in known:
            hint = suggestion(str(name), known, lists=False)
            raise SettingError(f"image {shown(name)}: choose of {', '.join(known)}{hint}")
    return tuple(dict.fromkeys(names))


def images_of(aov: str | Iterable[str]) -> tuple[str, ...]:
    """Return the images that a caller names: one, several or ``all``; raises SettingError."""
    names = image_names() if aov == "all" else (aov,) if isinstance(aov, str) else tuple(aov)
    if not names:
        raise SettingError("aov: name at least one image")
    return checked_images(names)


def images_of_other_methods(wanted: Iterable[str], method: str) -> list[str]:
    """Return which of the images no effect of a method makes: they are the same everywhere."""
    of_others, of_method = set[str](), set[str]()
    for effect in effects():
        is_shown = method in effect.methods | effect.shown_by
        names = of_method if is_shown else of_others
        names.update(effect.images, (term.name for term in effect.terms))
    return [name for name in wanted if name in of_others - of_method]


def check_camera(camera: Camera | None, name: str = "camera") -> None:
    """Raise SettingError unless `camera` is one; None stands for the scene's."""
    if not isinstance(camera, Camera | None):
        raise SettingError(f"{name}: expected a Camera, got {shown(camera)}")
