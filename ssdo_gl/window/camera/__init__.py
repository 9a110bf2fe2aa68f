"""How the camera moves: flight, recorded paths, bookmarks, collisions."""

from __future__ import annotations

from ssdo_gl.film.bookmarks import views_file
from ssdo_gl.window.camera.collisions import KEEP_AWAY, Obstacles
from ssdo_gl.window.camera.controls import Controls
from ssdo_gl.window.camera.destinations import (
    fit,
    focus_on,
    glide_to,
    go_home,
    jump_to,
    stilled,
    switch_projection,
)
from ssdo_gl.window.camera.fly_camera import (
    Flight,
    advance,
    set_pivot,
    speed_of,
    start_flight,
)
from ssdo_gl.window.camera.orientation import direction_point
from ssdo_gl.window.camera.tour import Tour
