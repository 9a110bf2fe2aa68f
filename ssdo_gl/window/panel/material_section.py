"""The section of the panel that edits what surfaces are made of."""

from __future__ import annotations

from typing import Any

from imgui_bundle import imgui

from ssdo_gl.scene.material import Color, Material
from ssdo_gl.scene.material_edits import EDITED, edited_material, material_name, shows_light
from ssdo_gl.window.viewer import Viewer

_LARGEST_IOR = 3.0
_LABELS = {"albedo": "base colour", "emission": "emission (W/sr/m^2)", "alpha": "opacity"}
_NEEDS_GLOSS = "neither metallic nor specular"


class MaterialSection:
    """Sliders and colours of one material of a viewer."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._last = viewer.material

    def draw(self) -> None:
        """Issue the section; it opens for a material that was pointed at in the picture."""
        viewer = self._viewer
        if viewer.material not in (None, self._last):
            imgui.set_next_item_open(True)
        self._last = viewer.material
        if not imgui.collapsing_header("Materials"):
            return
        loaded = viewer.loaded
        used = sorted({item.material for item in loaded.objects})
        if not used:
            return
        index = used[0] if viewer.material is None else viewer.material
        names = [material_name(loaded, i) for i in used]
        changed, place = imgui.combo("material", used.index(index), names)
        imgui.set_item_tooltip("K: that of the surface under the cursor")
        if changed:
            index = viewer.material = self._last = used[place]
        begun, now = loaded.materials[index], viewer.original.materials[index]
        new = _controls(begun, now, is_light=shows_light(viewer.original, index))
        if now is not begun and imgui.small_button("as loaded"):
            new = begun
        if new is not now:
            viewer.change_material(index, new)
            viewer.apply_lights()


def _controls(begun: Material, now: Material, *, is_light: bool) -> Material:
    """Edit the numbers of a material; those that have no effect are grey, and say why."""
    reasons: dict[str, str] = {}
    if is_light:
        reasons["emission"] = "its light is edited under Lights"
    if now.is_unlit:
        reasons |= dict.fromkeys(("metallic", "roughness", "specular", "ior"), "unlit")
    elif not now.is_glossy:
        reasons["roughness"] = _NEEDS_GLOSS
    if now.specular == 0.0 or now.metallic == 1.0:
        reasons["ior"] = "all metal" if now.metallic == 1.0 else "specular is 0"
    changes: dict[str, Any] = {}
    for name in EDITED:
        value, reason = getattr(now, name), reasons.get(name, "")
        imgui.begin_disabled(bool(reason))
        changed, new = _control(name, value)
        imgui.end_disabled()
        if reason and imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_disabled):
            imgui.set_tooltip(f"no effect: {reason}")
        if changed:
            changes[name] = new
    if not changes:
        return now
    return edited_material(begun, {name: getattr(now, name) for name in EDITED} | changes)


def _control(name: str, value: Any) -> tuple[bool, Any]:
    label = _LABELS.get(name, name)
    if name == "albedo":
        flags = imgui.ColorEditFlags_.float
        changed, new = imgui.color_edit3(label, list(value), flags)
        return changed, _clamped(new, 1.0)
    if name == "emission":
        flags = imgui.ColorEditFlags_.float | imgui.ColorEditFlags_.hdr
        changed, new = imgui.color_edit3(label, list(value), flags)
        return changed, _clamped(new, float("inf"))
    low, high = (1.0, _LARGEST_IOR) if name == "ior" else (0.0, 1.0)
    changed, new = imgui.slider_float(label, value, low, high, "%.3f")
    return changed, min(max(new, low), max(high, value))


def _clamped(color: list[float], high: float) -> Color:
    r, g, b = (min(max(part, 0.0), high) for part in color[:3])
    return r, g, b
