"""Ray-traced references: what the screen-space estimators are held to."""

from __future__ import annotations

from ssdo_gl.effects.references.reference_ao import ReferenceAo
from ssdo_gl.effects.references.reference_gi import ReferenceGi
from ssdo_gl.effects.references.reference_near import ReferenceNear
