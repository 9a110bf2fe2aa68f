"""References of the command: what they reached, and whether that is enough."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_scenes import TINY

from ssdo_gl.cli import main
from ssdo_gl.passes.rays import accumulate


@pytest.mark.parametrize(("more", "rays"), [([], 4), (["--spp", "6"], 6), (["--snapshot"], 256)])
def test_a_reference_that_is_only_explained_takes_few_rays(tmp_path, capsys, more, rays):
    out = [str(tmp_path / "a.npz")] if more == ["--snapshot"] else []
    assert main(["corner", "--method", "reference-ao", "--explain", *more, *out, *TINY]) == 0
    assert f"{rays} samples per pixel" in capsys.readouterr().out


def test_ctrl_c_keeps_what_a_reference_has_reached(tmp_path, capsys, monkeypatch):
    """The second draw is interrupted; the first one's samples are in the file."""
    draws = []
    draw = accumulate.draw_fullscreen

    def interrupted(*args, **kwargs):
        draws.append(1)
        if len(draws) == 3:
            raise KeyboardInterrupt
        draw(*args, **kwargs)

    monkeypatch.setattr(accumulate, "draw_fullscreen", interrupted)
    out = tmp_path / "a.npz"
    command = ["corner", "--method", "reference-ao", "--aov", "visibility", "--spp", "4096"]
    assert main([*command, "--snapshot", str(out), "--antialias", "4", *TINY]) == 130
    captured = capsys.readouterr()
    assert "interrupted" in captured.err
    assert "partial" in captured.out
    with np.load(out) as file:
        meta = json.loads(str(file["meta"]))
        assert 0.0 < file["visibility"].mean() <= 1.0
    assert meta["partial"] is True
    assert meta["references"]["reference_ao"]["spp"] < 4096


REFERENCE_AO = ("corner", "--method", "reference-ao", "--aov", "visibility", "--spp", "4")


def test_ctrl_c_before_a_reference_s_first_sample_leaves_no_file(tmp_path, capsys, monkeypatch):
    """It was a black picture that held "what the reference had reached"."""

    def interrupted(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("ssdo_gl.passes.rays.accumulate.draw_fullscreen", interrupted)
    out = tmp_path / "a.npz"
    assert main([*REFERENCE_AO, "--snapshot", str(out), *TINY]) == 130
    assert capsys.readouterr().err == "ssdo-gl: interrupted; nothing was written\n"
    assert not list(tmp_path.iterdir())


def test_a_frame_without_a_sample_does_not_darken_those_before_it(tmp_path, capsys, monkeypatch):
    draw, draws = accumulate.draw_fullscreen, []

    def counted(*args, **kwargs):
        draws.append(1)
        if len(draws) > stops_after:
            raise KeyboardInterrupt
        draw(*args, **kwargs)

    monkeypatch.setattr(accumulate, "draw_fullscreen", counted)
    stops_after = 1_000_000
    out = tmp_path / "a.npz"
    assert main([*REFERENCE_AO, "--snapshot", str(out), *TINY]) == 0
    stops_after = len(draws)
    draws.clear()
    one = np.load(out)["visibility"]
    words = [*REFERENCE_AO, "--snapshot", str(out), "--antialias", "2", *TINY]
    assert main(words) == 130
    assert "holds what the reference had reached" in capsys.readouterr().err
    with np.load(out) as file:
        assert file["visibility"].mean() == pytest.approx(one.mean(), rel=0.05)
        assert json.loads(str(file["meta"]))["partial"] is True


REFERENCE = ["corner", "--method", "reference-ao", "--aov", "visibility"]


@pytest.mark.parametrize("spp", ["1", "2"])
def test_an_error_that_nobody_can_know_is_said_to_be_unknown(tmp_path, capsys, spp):
    out = str(tmp_path / "a.npz")
    assert main([*REFERENCE, "--spp", spp, "--snapshot", out, *TINY]) == 0
    said = capsys.readouterr().out
    assert ("visibility unknown" in said) == (spp == "1")
    # A bound that nobody can say to be met is not.
    assert main([*REFERENCE, "--spp", spp, "--max-error", "0.9", "--snapshot", out, *TINY]) == (
        4 if spp == "1" else 0
    )
    missed = "relative standard error of visibility is unknown after 1 sample per pixel"
    assert (missed in capsys.readouterr().err) == (spp == "1")


@pytest.mark.parametrize("method", ["reference-ao", "reference-near", "reference-gi"])
def test_a_view_without_surfaces_has_no_error(tmp_path, capsys, method):
    out = str(tmp_path / "a.npz")
    away = ["--camera", "0,0,100 0,0,200", "--spp", "4"]
    assert main(["corner", "--method", method, *away, "--snapshot", out, *TINY]) == 0
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("quiet", [False, True])
def test_a_bound_out_of_reach_is_said_before_all_samples_are_drawn(
    tmp_path, capsys, monkeypatch, quiet
):
    """It was said after a million of them: hours, without a word where no terminal is."""
    for module in ("options.resolve", "passes.rays.accumulate"):
        monkeypatch.setattr(f"ssdo_gl.{module}.MAX_SPP", 64)
    said_by = []
    draw = accumulate.draw_fullscreen

    def drawn(*args, **kwargs):
        said_by.append(capsys.readouterr().err)
        draw(*args, **kwargs)

    monkeypatch.setattr(accumulate, "draw_fullscreen", drawn)
    command = [*REFERENCE, "--max-error", "1e-9", "--antialias", "2", *["--quiet"] * quiet]
    assert main([*command, "--snapshot", str(tmp_path / "a.npz"), *TINY]) == 4
    said = [i for i, text in enumerate(said_by) if text]
    assert len(said) == (not quiet)
    if said:
        assert said[0] < len(said_by) / 2
        (line,) = said_by[said[0]].splitlines()
        assert "1e-07 % would take about" in line and "ends at 64" in line


def test_a_bound_within_reach_is_said_to_be_nothing_else(tmp_path, capsys):
    command = [*REFERENCE, "--max-error", "0.02", "--snapshot", str(tmp_path / "a.npz"), *TINY]
    assert main(command) == 0
    assert "would take" not in capsys.readouterr().err


def test_a_reference_goes_on_until_its_bound_holds(tmp_path, capsys):
    """256 rays, the usual number, leave 1.5 % here: four times as many are needed."""
    stats = tmp_path / "s.json"
    command = [*REFERENCE, "--size", "32x18", "--stats", str(stats)]
    assert main([*command, "--explain", "--spp", "256"]) == 0
    first = json.loads(stats.read_text())["references"]["reference_ao"]
    bound = 0.5 * first["relative_standard_error"]["visibility"]
    capsys.readouterr()
    assert main([*command, "--explain", "--max-error", repr(bound)]) == 0
    content = json.loads(stats.read_text())["references"]["reference_ao"]
    assert first["spp"] == 256 < content["spp"]
    assert content["relative_standard_error"]["visibility"] <= bound
    assert content["stopped_by"] == "max_error"
    # A number that was asked for is the limit, and that it was met is said.
    assert main([*command, "--explain", "--max-error", repr(bound), "--spp", "256"]) == 4
    captured = capsys.readouterr()
    assert "after 256 samples per pixel, --max-error asked for" in captured.err
    assert len(captured.err.strip().splitlines()) == 1
