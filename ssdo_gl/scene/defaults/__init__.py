"""What a scene gets that brings none of its own: light, camera, exposure, floor."""

from __future__ import annotations

from ssdo_gl.scene.defaults.default_light import (
    BACKDROP,
    METERING_SLACK,
    MODEL_REACH,
    MOST_TRACED,
    MOST_TRACED_MOVING,
    NEUTRAL_SKY,
    RAYLESS_METHOD,
    ROOM_REACH,
    SKY,
    STUDIO,
    image_light,
    soft_light,
    studio,
)
from ssdo_gl.scene.defaults.exposure import lighting_for, seen_metal
from ssdo_gl.scene.defaults.floor import ground, has_floor
from ssdo_gl.scene.defaults.framing import frame, is_room, parallel, seen_from
from ssdo_gl.scene.defaults.interior import room_around
from ssdo_gl.scene.defaults.upright import guessed_up, turned_up, up_on_earth
