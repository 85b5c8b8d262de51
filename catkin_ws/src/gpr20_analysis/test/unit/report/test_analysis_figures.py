"""Figures show what they say, in the units they say, hide nothing, and no texts overlap."""

import itertools
import random

import numpy as np
from case_kit import each_case
from ground_kit import point, scene, survey_of

from gpr20_analysis.dataset import Quality
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.plotting import maps, scans
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.delay import to_time
from gpr20_survey.results.candidates import Candidate

PLACES_MM = np.linspace(160.0, 320.0, 9)
SURVEY = survey_of(scene([point(243.7, 236.2, 0.083)]), PLACES_MM, PLACES_MM)
IN_TIME = to_time(remove_background(SURVEY))
IMAGE = image_survey(remove_background(SURVEY), ImageOptions(permittivity=4.0))
CANDIDATES = [
    Candidate("C01", 0.2437, 0.2362, 0.083, 0.001, 0.001, 0.005, 30.0, (0.0, 90.0), 0.0, ())
]
HOLED = SURVEY.copy(deep=True)
HOLED.s21[0, 2, 3] = np.nan
HOLED.quality[0, 2, 3] = int(Quality.MISSING)
HOLED.attrs["missing"] = ["missing: x 220 mm, y 200 mm, 0 deg"]

FIGURES = {
    "a-scan": lambda: scans.a_scan_figure(IN_TIME, 0.24, 0.24),
    "b-scan along x": lambda: scans.b_scan_figure(IN_TIME, "x", 0.24),
    "b-scan along y": lambda: scans.b_scan_figure(IN_TIME, "y", 0.24),
    "c-scan in time": lambda: scans.c_scan_figure(IN_TIME, 2.4e-9),
    "c-scan of an image": lambda: scans.c_scan_figure(IMAGE, 0.083),
    "projections": lambda: maps.projection_figure(IMAGE, 0),
    "candidates": lambda: maps.candidate_map_figure(IMAGE, CANDIDATES),
    "coverage": lambda: maps.coverage_figure(SURVEY),
    "height": lambda: maps.height_figure(SURVEY),
}


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.axison]


def title_and_notes(figure):
    return figure.texts[:2]


def drawn_in(axes):
    return axes.collections[0].get_array().reshape(9, 9)


@each_case("name", FIGURES)
def test_every_axis_has_a_unit_and_simulated_data_say_so(name):
    figure = FIGURES[name]()
    for axes in panels(figure):
        # Panels beside each other may share one label.
        labels = [label for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
        assert labels
        for label in labels:
            assert any(unit in label for unit in ("[mm]", "[ns]", "linear")), label
    assert "SIMULATED" in title_and_notes(figure)[1].get_text()


def test_missing_samples_are_grey_and_counted_never_filled_in():
    figure = scans.b_scan_figure(to_time(HOLED), "x", 0.2)
    drawn = panels(figure)[0].collections[0].get_array()
    assert np.ma.getmaskarray(drawn).reshape(-1, 9)[:, 3].all()
    assert abs(panels(figure)[0].get_facecolor()[0] - 0.83) < 0.01
    assert "1 samples missing" in title_and_notes(figure)[1].get_text()
    coverage = maps.coverage_figure(HOLED)
    assert "161 of 162" in title_and_notes(coverage)[0].get_text()
    drawn = drawn_in(panels(coverage)[0])
    assert drawn[2, 3] == 3 and np.count_nonzero(drawn) == 1


@each_case("name", ["c-scan of an image", "candidates", "projections"])
def test_the_brightest_of_a_map_is_where_the_target_is(name):
    drawn = drawn_in(panels(FIGURES[name]())[0])
    row, column = np.unravel_index(np.argmax(drawn), drawn.shape)
    assert drawn.max() <= 0.0
    assert abs(PLACES_MM[column] - 243.7) <= 10.0 and abs(PLACES_MM[row] - 236.2) <= 10.0


@each_case("across", ["x", "y"])
def test_a_single_line_has_one_panel_with_its_section_and_candidates(across):
    image = IMAGE.isel({across: [5]})
    for figure in (
        maps.projection_figure(image, 0, CANDIDATES),
        maps.candidate_map_figure(image, CANDIDATES),
    ):
        (axes,) = panels(figure)
        assert axes.get_xlabel() == f"{'y' if across == 'x' else 'x'} [mm]"
        assert axes.get_ylabel() == "depth [mm]"
        # Depth goes down, and the image fills the panel.
        first, last = axes.get_ylim()
        assert first > last and abs(np.ptp(axes.get_xlim())) > 100.0
        (mark,) = axes.texts
        at_mm = 236.2 if across == "x" else 243.7
        assert mark.get_text() == "C01" and np.allclose(mark.xy, (at_mm, 83.0))


def test_b_scan_has_an_axis_of_depth_if_the_permittivity_is_given():
    figure = scans.b_scan_figure(IN_TIME, "x", 0.24, permittivity=4.0)
    figure.draw_without_rendering()
    (depth,) = [one for axes in panels(figure) for one in axes.child_axes]
    assert "[mm]" in depth.get_ylabel() and "4" in depth.get_ylabel()
    # The surface is 200 mm below the antennas, and waves in the ground are half as fast.
    surface_ns = 2.0 * 0.2 / 0.299792458
    last_ns, first_ns = panels(figure)[0].get_ylim()
    expected_mm = [(one - surface_ns) * 149.896229 / 2.0 for one in (last_ns, first_ns)]
    assert np.allclose(depth.get_ylim(), expected_mm, atol=1.0)
    assert min(depth.get_yticks()) == 0.0
    blind = IN_TIME.assign(height=IN_TIME.height * np.nan)
    assert not panels(scans.b_scan_figure(blind, "x", 0.24, permittivity=4.0))[-1].child_axes


def test_texts_are_apart_with_random_notes():
    draw = random.Random(6)
    letters = "abcdefghilmnoprstuvzáéñ0123456789./$_^{}%WM    "
    notes = ["".join(draw.choices(letters, k=draw.choice((4, 90, 600)))) for _ in range(8)]
    figures = [
        scans.b_scan_figure(IN_TIME.assign_attrs(one), "x", 0.24) for one in ({}, {"notes": notes})
    ]
    for figure in figures:
        figure.draw_without_rendering()
    title, note = (one.get_window_extent() for one in title_and_notes(figure))
    page, drawn = figure.bbox, [axes.get_tightbbox() for axes in figure.axes if axes.axison]
    for text in (title, note):
        assert page.x0 <= text.x0 and text.x1 <= page.x1
        assert page.y0 <= text.y0 and text.y1 <= page.y1
    for one, other in itertools.combinations([title, note, *drawn], 2):
        wide = min(one.x1, other.x1) - max(one.x0, other.x0)
        assert wide <= 1.0 or min(one.y1, other.y1) - max(one.y0, other.y0) <= 1.0
    # The axes keep their size, because the figure grows.
    plain, high = (one.axes[0].get_window_extent().height for one in figures)
    assert high > 0.75 * plain
