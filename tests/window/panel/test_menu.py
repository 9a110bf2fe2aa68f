"""The menu opens built-in scenes, and says what each is for."""

from __future__ import annotations

from window.overlay.drawn_overlay import DrawnOverlay

from ssdo_gl.scene.load import builtin_names, builtin_scenes


def test_the_menu_opens_a_built_in_scene(gl, drawn: DrawnOverlay) -> None:
    drawn.settled()
    drawn.click(22.0, 10.0)
    # Over the entry, into its menu, to the first scene.
    for x in (60.0, 340.0, 420.0):
        drawn.overlay.cursor(x, 78.0)
        drawn.frames(12)
    drawn.click(420.0, 78.0)
    assert drawn.overlay._host.opened == ["carousel"]


def test_every_built_in_scene_says_what_it_is_for() -> None:
    scenes = builtin_scenes()
    assert list(scenes) == builtin_names()
    assert all(title and len(purpose) > 20 for title, purpose in scenes.values())
