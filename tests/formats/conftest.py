"""Fixtures that write small model files."""

from __future__ import annotations

import pytest
from glb_writer import GlbWriter


@pytest.fixture
def glb() -> GlbWriter:
    """An empty .glb with one node that shows mesh 0."""
    return GlbWriter()
