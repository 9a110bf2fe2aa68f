"""An effect is one class and one shader: registered, it is everywhere without another edit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.registry import effects, image_names, pass_settings, registered, term_names
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.options.pass_settings import overrides_from_text
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, setting
from ssdo_gl.window.panel.control_rows import pass_rows

GLOW = """#version 330 core
// The same irradiance on every surface.
uniform sampler2D t_z_vs;
uniform float u_gain;
layout(location = 0) out vec4 o_glow;
void main()
{
    bool is_surface = texelFetch(t_z_vs, ivec2(gl_FragCoord.xy), 0).x > 0.0;
    o_glow = is_surface ? vec4(vec3(u_gain), 1.0) : vec4(0.0);
}
"""


@dataclass(frozen=True)
class GlowSettings:
    """Settings of the glow."""

    gain: float = setting(1.0, "how much arrives everywhere", unit="W m^-2", low=0.0, high=9.0)


class GlowPass(RenderPass):
    """Writes `glow_irradiance`."""

    name = "glow"
    reads = ("z_vs",)
    writes: ClassVar[Mapping[str, TextureSpec]] = {"glow_irradiance": TextureSpec(4)}
    depends_on = ("view",)

    def __init__(self, settings: GlowSettings) -> None:
        self.settings = settings

    def execute(self, context: PassContext) -> None:
        draw_fullscreen(
            context.gl,
            fullscreen_source(context.shaders, GLOW),
            context.target,
            {"u_gain": self.settings.gain},
            {"t_z_vs": context.inputs["z_vs"]},
        )


class Glow(Effect):
    """Light from nowhere, where surfaces could show it."""

    name = "glow"
    methods = frozenset({"direct", "bounce"})
    terms = (Term("glow", "glow_irradiance"),)
    settings: ClassVar[Mapping[str, type]] = {"glow": GlowSettings}

    def need(self, request: Request) -> Decision:
        skips = [(not request.content.has_albedo, "every surface is black")]
        return request.decision("glow", "surfaces are not black", skips, ("glow",))

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        yield GlowPass(request.settings_of("glow", GlowSettings)), "a glow was asked for"


@pytest.fixture
def glow():
    with registered(Glow()):
        yield


def rendered(device, shaders, wanted, gain=1.0, **flags):
    scene = load_scene("corner")
    given = {"method": "bounce", "size": (48, 32), "overrides": {"glow.gain": gain}, **flags}
    chosen = settings_for(scene.render, given)
    with Renderer(scene, chosen, device=device, shaders=shaders) as renderer:
        return renderer.render(wanted)


def test_it_is_in_the_picture_and_an_image_of_its_own(glow, device, shaders):
    images = rendered(device, shaders, ["beauty", "glow", "albedo"], method="direct").images
    np.testing.assert_allclose(images["glow"], images["albedo"] / np.pi, rtol=1e-6)
    surface = images["albedo"][..., :1] > 0.0
    added = np.where(surface, images["glow"], 0.0)
    assert added.max() > 0.1
    doubled = rendered(device, shaders, ["beauty"], 2.0, method="direct").images
    difference = doubled["beauty"][..., :3] - images["beauty"][..., :3]
    np.testing.assert_allclose(difference, added, rtol=1e-4, atol=1e-6)


def test_senders_pass_it_on(glow, device, shaders):
    dim, bright = (
        rendered(device, shaders, ["bounce"], gain, radius=1.0).images["bounce"]
        for gain in (0.0, 4.0)
    )
    assert bright.sum() > 1.1 * dim.sum() > 0.0


def test_it_can_be_set_and_is_checked(glow):
    assert overrides_from_text(["glow.gain=0.5"]) == {"glow.gain": 0.5}
    with pytest.raises(SettingError, match=r"gain = 10\.0: expected a number from 0 to 9 W m\^-2"):
        overrides_from_text(["glow.gain=10"])


def test_it_is_explained(glow, device, shaders):
    result = rendered(device, shaders, ["beauty"], method="direct")
    assert [row.reason for row in result.decisions if row.effect == "glow"] == [
        "surfaces are not black"
    ]
    assert [row.reason for row in result.passes if row.name == "glow"] == ["a glow was asked for"]


def test_other_methods_are_without_it(glow, device, shaders):
    result = rendered(device, shaders, ["beauty", "glow"], method="ssdo")
    assert not any(row.name == "glow" for row in result.passes)
    assert np.all(result.images["glow"] == 0.0)


def test_the_panel_has_its_settings(glow):
    (row,) = pass_rows()["glow"]
    assert (row.key, row.low, row.high) == ("glow.gain", 0.0, 9.0)


def test_lists_have_it_only_while_it_is_registered():
    with registered(Glow()):
        assert "glow" in term_names() and "glow" in image_names() and "glow" in pass_settings()
        assert [effect.name for effect in effects()].count("glow") == 1
        with pytest.raises(ValueError, match="there is an effect called"), registered(Glow()):
            pass
    assert "glow" not in term_names() + image_names() and "glow" not in pass_settings()
    assert Settings(method="direct").checked()
