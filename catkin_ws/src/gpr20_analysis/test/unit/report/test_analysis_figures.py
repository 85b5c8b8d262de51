"""Figures show what they say, in the units they say, and hide nothing."""

from __future__ import annotations

import argparse
import math

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from matplotlib.backends.backend_agg import FigureCanvasAgg

from gpr20_analysis import faults
from gpr20_analysis.commands import plot_command
from gpr20_analysis.commands.outputs import save_figure
from gpr20_analysis.dataset import Quality
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.plotting import maps, projections, ranges, scans
from gpr20_analysis.plotting.style import NOT_MEASURED, relative_db, remarks_of
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.delay import to_time
from gpr20_common.catalogue import Catalogue
from gpr20_survey.results.candidates import Candidate

PLACES_MM = np.linspace(160.0, 320.0, 9)
SURVEY = survey_of(scene([point(243.7, 236.2, 0.083)]), PLACES_MM, PLACES_MM)
IN_TIME = to_time(remove_background(SURVEY))
IMAGE = image_survey(remove_background(SURVEY), ImageOptions(permittivity=4.0))
CANDIDATES = [
    Candidate(
        "C01", 0.2437, 0.2362, 0.083, 0.001, 0.001, 0.005, 30.0, 1e-6, (0.0, 90.0), 0.0,
        flags=(),
    )
]  # fmt: skip
HOLED = SURVEY.copy(deep=True)
HOLED.s21[0, 2, 3] = np.nan
HOLED.quality[0, 2, 3] = int(Quality.MISSING)
HOLED.attrs["missing"] = ["missing: x 220 mm, y 200 mm, 0 deg"]

FIGURES = {
    "a-scan": lambda: scans.a_scan_figure(IN_TIME, 0.24, 0.24),
    "b-scan along x": lambda: scans.b_scan_figure(IN_TIME, "x", 0.24),
    "b-scan along y, real": lambda: scans.b_scan_figure(IN_TIME, "y", 0.24, scans.Value.REAL),
    "c-scan in time": lambda: scans.c_scan_figure(IN_TIME, 2.4e-9),
    "c-scan of an image": lambda: scans.c_scan_figure(IMAGE, 0.083),
    "projections": lambda: projections.projection_figure(IMAGE, 0),
    "candidates": lambda: projections.candidate_map_figure(IMAGE, CANDIDATES),
    "coverage": lambda: maps.coverage_figure(SURVEY),
    "height": lambda: maps.height_figure(SURVEY),
}


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.axison]


def test_every_axis_has_a_unit_and_simulated_data_say_so():
    for name, made in FIGURES.items():
        figure = made()
        for axes in panels(figure):
            # Panels beside each other may share one label.
            labels = [label for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
            assert labels
            for label in labels:
                assert any(unit in label for unit in ("[mm]", "[ns]", "linear")), (name, label)
        assert "SIMULATED" in figure._supxlabel.get_text(), name


def test_figures_are_written_in_each_format_and_in_no_other(tmp_path):
    figure = FIGURES["b-scan along x"]()
    for ending, begin in ((".png", b"\x89PNG\r"), (".svg", b"<?xml"), (".pdf", b"%PDF-")):
        path = tmp_path / f"figure{ending}"
        save_figure(figure, path)
        assert path.read_bytes()[:5] == begin
    with raises_fault(faults.OUTPUT):
        save_figure(figure, tmp_path / "figure.bmp")


def test_c_scan_is_brightest_over_the_target():
    axes = panels(FIGURES["c-scan of an image"]())[0]
    drawn = axes.collections[0].get_array().reshape(9, 9)
    row, column = np.unravel_index(np.argmax(drawn), drawn.shape)
    assert abs(PLACES_MM[column] - 243.7) <= 10.0 and abs(PLACES_MM[row] - 236.2) <= 10.0


def test_b_scan_has_delay_downwards():
    low, high = panels(FIGURES["b-scan along x"]())[0].get_ylim()
    assert low > high


def test_figures_end_where_the_ground_ends_unless_all_is_wanted():
    deepest_ns = 2.0 * (0.2 + 0.3 * 3.0) / 0.299792458
    for figure, axis in ((FIGURES["a-scan"](), "x"), (FIGURES["b-scan along x"](), "y")):
        last_ns = max(getattr(panels(figure)[0], f"get_{axis}lim")())
        assert deepest_ns < last_ns < deepest_ns + 1.0
    every = panels(scans.b_scan_figure(IN_TIME, "x", 0.24, last_s=math.inf))[0]
    assert max(every.get_ylim()) > float(IN_TIME.delay[-1]) * 1e9
    assert len(panels(scans.b_scan_figure(IN_TIME, "x", 0.24, last_s=0.0))) == 2


def test_b_scan_has_an_axis_of_depth_if_the_permittivity_is_given():
    figure = scans.b_scan_figure(IN_TIME, "x", 0.24, permittivity=4.0)
    figure.canvas.draw()
    (depth,) = [one for axes in panels(figure) for one in axes.child_axes]
    assert "[mm]" in depth.get_ylabel() and "4" in depth.get_ylabel()
    depth_mm, at_ns = depth.get_yticks(), depth.get_yaxis().get_majorticklocs()
    np.testing.assert_array_equal(depth_mm, at_ns)
    assert min(depth_mm) >= 0.0
    transform = depth._functions[1]
    expected_ns = 2.0 * (0.2 + 0.1 * 2.0) / 0.299792458
    assert float(transform(np.array(100.0))) == pytest.approx(expected_ns, abs=0.01)
    blind = IN_TIME.assign(height=IN_TIME.height * np.nan)
    assert not panels(scans.b_scan_figure(blind, "x", 0.24, permittivity=4.0))[-1].child_axes


def test_a_disturbed_trace_does_not_darken_the_others():
    disturbed = IN_TIME.copy(deep=True)
    disturbed.a_scan[0, :, 4] *= 1e4
    before, after = (
        panels(scans.b_scan_figure(one, "x", 0.24))[1].collections[0].get_array()
        for one in (IN_TIME, disturbed)
    )
    assert np.max(np.abs(np.asarray(after) - np.asarray(before))) < 6.0


@pytest.mark.parametrize("scale", [1.0, 1e-9, 0.0])
def test_the_colours_reach_down_to_what_half_of_the_values_are_below(scale):
    values = scale * np.random.default_rng(1).rayleigh(size=100_000)
    reference = 30.0 * scale
    reach_db = ranges.range_db(values, reference)
    assert 20.0 <= reach_db <= 50.0
    if scale:
        assert np.mean(values < reference * 10.0 ** (-reach_db / 20.0)) == pytest.approx(
            0.4, abs=0.15
        )


def test_missing_samples_are_grey_and_counted_never_filled_in():
    figure = scans.b_scan_figure(to_time(HOLED), "x", 0.2)
    drawn = panels(figure)[0].collections[0].get_array()
    assert np.ma.getmaskarray(drawn).reshape(-1, 9)[:, 3].all()
    assert panels(figure)[0].get_facecolor()[:3] == pytest.approx((0.827, 0.827, 0.827), abs=0.01)
    assert NOT_MEASURED == "lightgrey"
    assert "1 samples missing" in figure._supxlabel.get_text()


def test_coverage_counts_what_is_usable():
    assert "161 of 162" in maps.coverage_figure(HOLED)._suptitle.get_text()
    drawn = panels(maps.coverage_figure(HOLED))[0].collections[0].get_array().reshape(9, 9)
    assert drawn[2, 3] == 3 and np.count_nonzero(drawn) == 1


def test_a_scan_of_a_missing_place_is_refused():
    alone = to_time(HOLED.isel(polarization=[0]))
    with raises_fault(faults.OPTION):
        scans.a_scan_figure(alone, float(PLACES_MM[3]) / 1e3, float(PLACES_MM[2]) / 1e3)


def test_decibels_are_below_the_maximum_and_keep_nan():
    values = relative_db(np.array([1.0, 0.1, np.nan, 0.0]))
    np.testing.assert_allclose(values[:2], [0.0, -20.0])
    assert np.isnan(values[2]) and values[3] < -200.0


def test_notes_of_the_data_stand_below_the_figure():
    noted = IMAGE.assign_attrs(notes=["3 samples were left out"])
    assert "3 samples were left out" in [str(one) for one in remarks_of(noted)]


@pytest.mark.parametrize("across", ["x", "y"])
def test_a_single_line_has_one_panel_with_its_section_and_candidates(across):
    image = IMAGE.isel({across: [5]})
    for figure in (
        projections.projection_figure(image, 0, CANDIDATES),
        projections.candidate_map_figure(image, CANDIDATES),
    ):
        (axes,) = panels(figure)
        assert axes.get_xlabel() == f"{'y' if across == 'x' else 'x'} [mm]"
        assert axes.get_ylabel() == "depth [mm]"
        # Depth goes down, and the image fills the panel.
        first, last = axes.get_ylim()
        assert first > last and abs(np.ptp(axes.get_xlim())) > 100.0
        assert len(axes.texts) == 1


OF_KIND = ("along", "x", "y", "value", "depth", "delay", "until", "all_delays", "permittivity")


@pytest.mark.parametrize("across", ["x", "y"])
def test_no_panel_of_a_single_line_is_blank(across):
    survey, image = SURVEY.isel({across: [5]}), IMAGE.isel({across: [5]})
    options = dict.fromkeys((*OF_KIND, "rotation"))
    for kind, data, given in (
        ("a-scan", survey, {}),
        ("b-scan", survey, {}),
        ("b-scan", survey, {"along": across}),
        ("c-scan", survey, {"delay": 2.0}),
        ("c-scan", image, {"depth": 80.0}),
        ("coverage", survey, {}),
        ("height", survey, {}),
        ("projection", image, {}),
    ):
        chosen = argparse.Namespace(kind=kind, **{**options, **given})
        figure = plot_command.figure_of(data, chosen, Catalogue())
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
        for axes in panels(figure):
            left, low, right, high = (round(one) for one in axes.get_window_extent().extents)
            inside = pixels[low + 3 : high - 3, left + 3 : right - 3].reshape(-1, 3)
            assert right - left > 150 and high - low > 50, (kind, given)
            # Light grey is what was not measured.
            assert np.mean((inside == 211).all(axis=1)) < 0.01, (kind, given)
        shown = panels(figure)[0].get_xlabel()
        if kind in ("b-scan", "projection") and not given:
            assert shown == f"{'y' if across == 'x' else 'x'} [mm]"
