"""A scene and a camera that flies through it: everything that needs no device."""

from __future__ import annotations

import copy
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.light_edits import with_added_light, without_light
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.material_edits import with_edited
from ssdo_gl.scene.scene import Scene
from ssdo_gl.window.animation_clock import Clock
from ssdo_gl.window.camera import (
    KEEP_AWAY,
    Controls,
    Flight,
    Obstacles,
    Tour,
    advance,
    jump_to,
    speed_of,
    start_flight,
    views_file,
)
from ssdo_gl.window.messages import Messages


class SceneFlight:
    """A scene as a file gave it and as it was edited, and a camera in it.

    Parameters
    ----------
    folder : Path
        Where bookmarks, pictures and films go.

    Attributes
    ----------
    source : str
        The scene as it was named.
    loaded, original, scene : Scene
        As it was loaded; with another environment and other materials, lights added or
        removed; and with edited lights, too.
    lights, lights_on : lists
        As edited; one for each light of `original`.
    material : int or None
        Which one is edited, an index into those of `loaded`.
    bounds : (ndarray, ndarray)
        Corners of the scene, world space.
    fit_bounds : (ndarray, ndarray)
        The same, of a scene that is framed those of its main part; `diagonal` is the distance
        between them.
    tour : Tour
        Bookmarks and camera path.
    """

    # All that a file or a key may change, for a way back.
    _STATE: tuple[str, ...] = (
        *("source", "loaded", "original", "scene", "lights", "lights_on", "bounds"),
        *("fit_bounds", "diagonal", "flight", "clock", "tour", "material", "_obstacles"),
    )

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.messages = Messages()

    def _take(self, scene: Scene, source: str, camera: Camera | None) -> None:
        """Begin anew in `scene`, at its own camera if none is given."""
        self.source = source
        self.loaded = self.original = self.scene = scene
        self.lights: list[Light] = list(scene.lights)
        self.lights_on = [True] * len(scene.lights)
        self.material: int | None = None
        self.bounds: tuple[FloatArray, FloatArray] = scene.bounds()
        part = scene.main_part()
        self.fit_bounds = (part.low, part.high) if scene.is_framed else self.bounds
        self.diagonal = float(np.linalg.norm(self.fit_bounds[1] - self.fit_bounds[0]))
        self.flight: Flight = start_flight(camera or scene.camera, self.diagonal)
        own = scene.camera.position, scene.camera.target
        places = [(item.camera.position, item.camera.target) for item in scene.cameras]
        # Of the file's cameras the last one that was asked for.
        self.camera_number = places.index(own) if own in places else -1
        self.clock = Clock.of(scene.moves)
        self._obstacles: Obstacles | None = None
        self.tour = Tour(views_file(source, self.folder), scene.camera)
        if self.tour.fault:
            self.say(self.tour.fault, is_fault=True)
        for note in scene.notes:
            self.say(note)

    @property
    def light_sources(self) -> list[int | None]:
        """For each light, which one of `loaded` it is; None: it was added."""
        numbers = {id(light): number for number, light in enumerate(self.loaded.lights)}
        return [numbers.get(id(light)) for light in self.original.lights]

    def add_light(self, light: Light) -> None:
        """Add a light to those that can be edited; `apply_lights` shows it."""
        self.original = with_added_light(self.original, light)
        self.lights.append(light)
        self.lights_on.append(True)

    def remove_light(self, index: int) -> None:
        """Take a light away, with all that are one body with it."""
        self.original, gone = without_light(self.original, index)
        del self.lights[gone.start : gone.stop], self.lights_on[gone.start : gone.stop]

    def change_material(self, index: int, material: Material) -> None:
        """Let surfaces be made of another material; `apply_lights` shows it."""
        self.original = with_edited(self.original, index, material)

    def _state(self) -> dict[str, Any]:
        """Return what `_restore` takes."""
        state = {name: getattr(self, name) for name in self._STATE}
        return {k: copy.copy(v) if isinstance(v, (list, Clock)) else v for k, v in state.items()}

    def _restore(self, state: dict[str, Any]) -> None:
        vars(self).update(state)

    def say(self, text: str, *, is_fault: bool = False, key: str = "") -> None:
        """Show a line for a while; it replaces one of the same `key`."""
        self.messages.say(text, is_fault=is_fault, key=key)

    @property
    def camera(self) -> Camera:
        """The camera of the next frame."""
        return self.tour.camera() or self.flight.camera()

    @property
    def collides(self) -> bool:
        """Whether the camera is kept out of walls."""
        return self._obstacles is not None

    def toggle_collisions(self) -> None:
        """Keep the camera out of walls, as they stand now, or no longer."""
        if self._obstacles is not None:
            self._obstacles = None
            self.say("flies through walls")
            return
        try:
            self._obstacles = Obstacles(scene_at(self.scene, self.clock.seconds))
            self.say("stops at walls")
        except ValueError as error:
            self.say(str(error), is_fault=True)

    def fly(self, controls: Controls, seconds: float, clearance: float | None) -> None:
        """Let the camera move, by hand or along the path that is played.

        Parameters
        ----------
        clearance : float or None
            Distance of the nearest surface ahead, scene units; None: nothing is near.
        """
        if self.tour.played_s is not None:
            self.tour.advance(seconds)
            if not controls.is_idle or self.tour.has_ended:
                self.stop_path()
            return
        before = self.flight
        self.flight = advance(before, controls, seconds, clearance)
        if controls.speed:
            self._say_speed()
        if self._obstacles is not None and self.flight.position != before.position:
            keep_away = KEEP_AWAY * self.diagonal
            place = self._obstacles.moved(before.position, self.flight.position, keep_away)
            self.flight = dataclasses.replace(self.flight, position=place)
        self.tour.record(seconds, self.flight.camera())

    def _say_speed(self) -> None:
        speed = speed_of(self.flight)
        factor = self.flight.speed_factor
        self.say(f"speed {factor:.2g}: {speed:.3g} units a second", key="speed")

    def stop_path(self) -> None:
        """Go on by hand from where the path has come to."""
        self.flight = jump_to(self.flight, self.camera)
        self.tour.stop()
