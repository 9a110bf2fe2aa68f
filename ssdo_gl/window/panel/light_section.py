"""The section of the panel that edits lights and environment."""

from __future__ import annotations

import dataclasses

from imgui_bundle import imgui

from ssdo_gl.scene.defaults import SKY
from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    Daylight,
    Environment,
    GradientEnvironment,
    SkyEnvironment,
    sky,
)
from ssdo_gl.scene.light_edits import new_light
from ssdo_gl.scene.lights import KINDS
from ssdo_gl.scene.material import Color
from ssdo_gl.window.panel.light_handle import LightHandle, can_turn
from ssdo_gl.window.viewer import Viewer

# A light is turned up or down within these factors of the value one sees.
_STRENGTH_SPEED = 0.01
# A place is dragged by this part of the scene's diagonal per pixel.
_MOVE_SPEED = 0.002


def lights_section(viewer: Viewer, handle: LightHandle) -> None:
    """Draw a row of widgets for each light, and for the environment."""
    changed = _add_light(viewer)
    for index, light in enumerate(list(viewer.lights)):
        imgui.push_id(str(index))
        has_other_lights = False
        was_on = viewer.lights_on[index]
        toggled, viewer.lights_on[index] = imgui.checkbox("##on", was_on)
        imgui.same_line()
        is_open = imgui.tree_node(f"{light.name or light.kind} {index + 1}###light")
        changed |= toggled
        if is_open:
            changed |= _light(viewer, index)
            has_other_lights = _handle_row(viewer, index, handle)
            imgui.tree_pop()
        imgui.pop_id()
        if has_other_lights:
            changed = True
            handle.hide()
            break
    if changed:
        viewer.apply_lights()
    _environment(viewer)


def _light(viewer: Viewer, index: int) -> bool:
    light = viewer.lights[index]
    strength, color = split(light.emitted)
    changed_color, new_color = imgui.color_edit3("colour", list(color))
    changed, new = imgui.drag_float(
        f"{light.emitted_field}, {light.emitted_unit}",
        strength,
        _STRENGTH_SPEED * max(strength, 1e-3),
        0.0,
        0.0,
        "%.4g",
    )
    if changed or changed_color:
        r, g, b = (max(new, 0.0) * c for c in new_color[:3])
        light = light.with_emitted((r, g, b))
    place = light.place
    moved = False
    if place is not None:
        moved, where = imgui.drag_float3(
            "place", list(place), _MOVE_SPEED * viewer.diagonal, 0.0, 0.0, "%.3g"
        )
        if moved:
            light = light.moved_to((where[0], where[1], where[2]))
    imgui.text_disabled(f"shadow: {light.shadow}")
    begun = viewer.original.lights[index]
    if light != begun:
        imgui.same_line()
        if imgui.small_button("as loaded" if begun in viewer.loaded.lights else "as added"):
            light, moved = begun, True
    viewer.lights[index] = light
    return bool(changed or changed_color or moved)


def _handle_row(viewer: Viewer, index: int, handle: LightHandle) -> bool:
    """Offer what can be done with a light as a whole; return whether there are others now."""
    light = viewer.lights[index]
    shown = handle.turns if handle.light == index else None
    if light.place is not None:
        if imgui.small_button("hide handle" if shown is False else "move"):
            handle.toggle(index, turns=False)
        imgui.set_item_tooltip("drag its arrows in the picture")
        imgui.same_line()
    if can_turn(light):
        if imgui.small_button("hide handle" if shown is True else "turn"):
            handle.toggle(index, turns=True)
        imgui.set_item_tooltip("drag its rings in the picture")
        imgui.same_line()
    copies = imgui.small_button("duplicate")
    imgui.same_line()
    removes = imgui.small_button("delete")
    if copies:
        still = light.at(viewer.clock.seconds)
        viewer.add_light(dataclasses.replace(still, motion=None))
    elif removes:
        viewer.remove_light(index)
    return copies or removes


def _add_light(viewer: Viewer) -> bool:
    """Offer a light of each kind; return whether one was added."""
    imgui.text_disabled("add")
    for name, kind in KINDS.items():
        imgui.same_line()
        if imgui.small_button(f"{name}##add"):
            viewer.add_light(new_light(kind, viewer.camera, 0.3 * viewer.diagonal))
            return True
    return False


def _environment(viewer: Viewer) -> None:
    environment = viewer.scene.environment
    if environment is None:
        imgui.text_disabled("no environment")
        imgui.same_line()
        if imgui.small_button("add a sky"):
            viewer.change_environment(SKY)
        return
    if not imgui.tree_node("environment"):
        return
    new: Environment = environment
    if isinstance(environment, ConstantEnvironment):
        new = dataclasses.replace(environment, radiance=_color("radiance", environment.radiance))
    elif isinstance(environment, GradientEnvironment):
        new = dataclasses.replace(
            environment,
            zenith=_color("zenith", environment.zenith),
            horizon=_color("horizon", environment.horizon),
            ground=_color("ground", environment.ground),
        )
    elif isinstance(environment, SkyEnvironment):
        daylight = _time_of_day(environment.daylight)
        if daylight != environment.daylight and daylight.is_day:
            new = sky(daylight)
    else:
        imgui.text_disabled(f"image {environment.name or 'map'}")
        turned, degrees = imgui.drag_float("turn (deg)", environment.rotation_y, 0.5)
        if turned:
            new = dataclasses.replace(environment, rotation_y=degrees)
    if new is not environment and new != environment:
        viewer.change_environment(new)
    if imgui.small_button("remove"):
        viewer.change_environment(None)
    if environment is not viewer.loaded.environment:
        imgui.same_line()
        if imgui.small_button("as loaded"):
            viewer.change_environment(viewer.loaded.environment)
    imgui.tree_pop()


def _time_of_day(daylight: Daylight) -> Daylight:
    """Edit the hour of a day and what it is like."""
    for name, label, low, high, digits in (
        ("hour", "hour (solar)", 0.0, 24.0, "%.2f"),
        ("day", "day of the year", 1.0, 366.0, "%.0f"),
        ("latitude", "latitude (deg)", -90.0, 90.0, "%.1f"),
        ("turbidity", "turbidity", 2.0, 10.0, "%.1f"),
        ("north", "north (deg)", -180.0, 180.0, "%.0f"),
    ):
        changed, value = imgui.slider_float(label, getattr(daylight, name), low, high, digits)
        if changed:
            daylight = dataclasses.replace(daylight, **{name: value})
    return daylight


def _color(label: str, color: Color) -> Color:
    """Edit a radiance, W/sr/m^2, which may exceed 1."""
    flags = imgui.ColorEditFlags_.float | imgui.ColorEditFlags_.hdr
    changed, new = imgui.color_edit3(label, list(color), flags)
    return (new[0], new[1], new[2]) if changed else color


def split(power: Color) -> tuple[float, Color]:
    """Return (strength, colour) of a light: the colour's largest part is 1."""
    strength = max(power)
    if strength <= 0.0:
        return 0.0, (1.0, 1.0, 1.0)
    r, g, b = (part / strength for part in power)
    return strength, (r, g, b)
