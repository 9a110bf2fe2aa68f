"""What a bench found, as tables, plots, pictures and one HTML file."""

from __future__ import annotations

from ssdo_gl.bench.report.key import COLORS, MARKERS
from ssdo_gl.bench.report.outputs import check_libraries, print_outcome, write_report
from ssdo_gl.bench.report.page import split_results
from ssdo_gl.bench.report.pictures import chosen_results, take_pictures, with_hdr_flip
from ssdo_gl.bench.report.plots import as_bytes, drawn_in_style
