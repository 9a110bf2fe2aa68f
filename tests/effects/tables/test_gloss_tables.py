"""Reflectance of the glossy layer, against sampled facets."""

from __future__ import annotations

import numpy as np
from oracle import brdf as oracle

from ssdo_gl.effects.tables.gloss_tables import TABLE_SIZE, cosine_of_node, reflectance_table

COUNT = 1 << 16
# Of the mean of COUNT weights in [0, 1]: 5 standard errors.
TOLERANCE = 2.5 / COUNT**0.5


def test_the_table_is_the_mean_over_the_lobe():
    table = reflectance_table()
    u = np.random.default_rng(1).uniform(0.0, 1.0, (COUNT, 2))
    normal = np.tile([0.0, 0.0, 1.0], (COUNT, 1))
    for row, column in ((2, 3), (8, 1), (12, 20), (31, 16), (31, 31)):
        roughness, cosine = row / (TABLE_SIZE - 1), column / (TABLE_SIZE - 1)
        other = float(cosine_of_node(np.array([cosine]), roughness**2)[0])
        for f0, f90, view, wanted in (
            (1.0, 1.0, cosine, table[row, column, :2].sum()),
            (0.0, 1.0, cosine, table[row, column, 1]),
            (1.0, 1.0, other, table[row, column, 2]),
        ):
            w_out = np.tile([np.sqrt(1.0 - view**2), 0.0, view], (COUNT, 1))
            surface = oracle.Brdf.glossy(
                albedo=np.zeros((COUNT, 3)),
                f0=np.full((COUNT, 3), f0),
                f90=np.full(COUNT, f90),
                roughness=np.full(COUNT, roughness),
            )
            _, weight, _ = surface.sample(normal, w_out, u)
            assert abs(weight[:, 0].mean() - wanted) < TOLERANCE


def test_smooth_layers_reflect_as_fresnel_says():
    table = reflectance_table()[0, :, :2]
    power = (1.0 - np.linspace(0.0, 1.0, TABLE_SIZE)) ** 5
    np.testing.assert_allclose(table[1:], np.stack([1.0 - power, power], 1)[1:], atol=5e-3)


def test_no_layer_reflects_more_than_it_gets():
    table = reflectance_table()
    assert table.min() >= 0.0
    assert table[..., :2].sum(axis=-1).max() <= 1.0 + 1e-4
    assert table[..., 2].max() <= 1.0 + 1e-4
