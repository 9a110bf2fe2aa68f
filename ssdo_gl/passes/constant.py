"""An image that is known without looking at anything."""

from __future__ import annotations

from collections.abc import Hashable

from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class ConstantPass(RenderPass):
    """Fills a resource with one value; depends on nothing, so it runs once.

    Parameters
    ----------
    resource : str
        What it writes; also names the pass.
    value : tuple of float
        Of each channel.
    """

    def __init__(self, resource: str, value: tuple[float, ...]) -> None:
        self.name = f"constant_{resource}"
        self.value = value
        self.writes = {resource: TextureSpec(len(value))}

    def settings_key(self) -> Hashable:
        return self.value

    def execute(self, context: PassContext) -> None:
        assert context.target is not None
        red, green, blue, alpha = (*self.value, 0.0, 0.0, 0.0)[:4]
        context.target.clear(red, green, blue, alpha)
