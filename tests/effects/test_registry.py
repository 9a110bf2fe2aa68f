"""The registry is sound: names are unique, methods and images exist, settings are declared."""

from __future__ import annotations

import pytest

from ssdo_gl.effects.registry import effects, image_names, pass_settings, term_names
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings
from ssdo_gl.settings.estimators import DEFAULT_ESTIMATOR, ESTIMATORS
from ssdo_gl.settings.fields import describe
from ssdo_gl.settings.methods import METHODS


def test_names_are_unique():
    names = [effect.name for effect in effects()]
    assert len(names) == len(set(names))
    settings = [name for effect in effects() for name in effect.settings]
    assert len(settings) == len(set(settings))


@pytest.mark.parametrize("effect", effects(), ids=lambda effect: effect.name)
def test_effects_name_methods_that_exist(effect):
    assert effect.methods | effect.shown_by <= set(METHODS)
    assert effect.__doc__ and type(effect).need.__doc__ and type(effect).passes.__doc__


@pytest.mark.parametrize("method", METHODS)
def test_a_term_of_a_picture_is_made_by_one_effect_or_by_either_of_two(method):
    """Shadows by maps or by rays are the one choice between effects of the same term.

    With `gi`, rays to glowing bodies bring direct light besides.
    """
    makers: dict[str, list[str]] = {}
    for effect in effects():
        # One effect may bring a term in several images.
        for name in {term.name for term in effect.terms}:
            if method in effect.methods:
                makers.setdefault(name, []).append(effect.name)
    either = {name: found for name, found in makers.items() if len(found) > 1}
    two = ["direct", "traced_shadows"]
    # What glossy surfaces reflect of lights and of their surroundings has one name.
    assert either.pop("specular", two) in (two, [*two, "reflections"], [*two, "reference_near"])
    with_glow = {"direct": [*two, "emitters"]}
    assert either in ({}, {"direct": two}) if method != "gi" else either == with_glow


def test_images_begin_with_the_picture_and_its_terms():
    names = image_names()
    assert names[: 1 + len(term_names())] == ("beauty", *term_names())
    # Files have these by name, keys of the window by place; others may come between them.
    promised = (
        "beauty", "emission", "direct", "specular", "directional", "bounce", "visibility",
        "albedo", "normal_ws", "position_ws", "depth",
    )  # fmt: skip
    assert tuple(name for name in names if name in promised) == promised


@pytest.mark.parametrize("name", pass_settings())
def test_every_setting_of_a_pass_says_what_it_does(name):
    infos = describe(pass_settings()[name])
    assert infos and all(info.doc for info in infos.values())


def test_effects_that_look_around_have_an_estimator_to_choose():
    for effect in effects():
        classes = [c for c in effect.settings.values() if issubclass(c, ScreenSpaceSettings)]
        assert bool(classes) == effect.looks_around


@pytest.mark.parametrize("method", METHODS.values(), ids=lambda method: method.name)
def test_methods_may_use_what_gives_what_they_estimate(method):
    chosen = [ESTIMATORS[name] for name in method.estimators]
    assert bool(chosen) == (method.estimates != "nothing")
    assert all(e.gives_light for e in chosen) or method.estimates == "visibility"
    assert not chosen or chosen[0].name == DEFAULT_ESTIMATOR
