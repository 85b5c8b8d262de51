"""MAP and RADAR with 25,000 traces of 501 points: time to take a trace, to draw, and memory.

Draws off screen, without ROS; the traces are made, not measured.

    scripts/bench.sh window_views [--columns 158 --rows 158]
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from typing import Callable, List

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import resident_mib

from gpr20_survey.plan.markers import Marker
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace
from gpr20_user_interface.mid.additions_presenter import AdditionsPresenter
from gpr20_user_interface.mid.map_coverage import CoverageRuns
from gpr20_user_interface.mid.map_grid import Stop, SurveyGrid
from gpr20_user_interface.mid.shown_survey import ShownSurvey
from gpr20_user_interface.views.map_view import MapView
from gpr20_user_interface.views.radar_view import RadarView

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
FREQUENCY_HZ = np.linspace(0.6e9, 6.0e9, 501)
NOW_US = 1_795_000_000_000_000
PAGE_PX = (800, 370)  # what the frame leaves to a tab
REPETITIONS = 20


def make_grid(columns: int, rows: int) -> SurveyGrid:
    return SurveyGrid(
        SURVEY,
        SurveyParameters(
            "127.0.0.1",
            *(0.6e9, 6.0e9, 501),
            *(0.0, 600.0, columns),
            *(0.0, 600.0, rows),
            polarizations_deg=(0.0,),
        ),
        TRAVEL,
        simulated=True,
    )


def make_trace(grid: SurveyGrid, index: int) -> Trace:
    stop = grid.cell(index).stop
    delay_s = 2e-9 + 1e-12 * ((stop.row - 80) ** 2 + (stop.column - 80) ** 2) ** 0.5
    turns = 2.0 * np.pi * FREQUENCY_HZ * delay_s
    return Trace(
        survey_id=SURVEY,
        index=index,
        sample_id=f"sample-{index}",
        timestamp_us=NOW_US,
        x_coord_mm=float(grid.xs_mm[stop.column]),
        y_coord_mm=float(grid.ys_mm[stop.row]),
        z_coord_deg=0.0,
        antennae_height_m=0.2,
        frequency_hz=FREQUENCY_HZ,
        s21_real=np.cos(turns),
        s21_imag=-np.sin(turns),
        sweep_started_us=NOW_US - 200_000,
        sweep_ended_us=NOW_US,
        quality=(),
        analyzer=AnalyzerSettings(),
    )


def milliseconds(action: Callable[[], None]) -> str:
    took: List[float] = []
    for _ in range(REPETITIONS):
        begin_s = time.perf_counter()
        action()
        took.append((time.perf_counter() - begin_s) * 1e3)
    return f"{statistics.median(took):8.2f} ms median, {max(took):8.2f} ms at most"


class NoStorage:
    """Answers nothing."""

    def read_additions(self, survey: str) -> None:
        """Ask for nothing."""

    def add_marker(self, survey: str, marker: Marker) -> None:
        """Store nothing."""

    def remove_marker(self, survey: str, marker_id: str, author: str) -> None:
        """Remove nothing."""


def draw(view: QWidget, change: Callable[[], None]) -> None:
    change()
    view.refresh()
    QApplication.processEvents()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--columns", type=int, default=158)
    parser.add_argument("--rows", type=int, default=158)
    arguments = parser.parse_args()
    application = QApplication([])
    survey = ShownSurvey()
    grid = make_grid(arguments.columns, arguments.rows)
    additions = AdditionsPresenter(NoStorage(), str)
    views = (MapView(survey.map, survey.radar, additions), RadarView(survey.radar))
    for view in views:
        view.resize(*PAGE_PX)
        view.show()
    survey.begin(grid)
    empty_mb = resident_mib()
    took_s = 0.0
    for index in range(grid.planned):
        trace = make_trace(grid, index)
        begin_s = time.perf_counter()
        survey.take_trace(trace)
        took_s += time.perf_counter() - begin_s
    coverage = CoverageRuns(SURVEY, grid.planned, (0, grid.planned // 2), (1, 0))
    print(f"stops                    {grid.planned}")
    print(f"memory of the traces     {resident_mib() - empty_mb:8.1f} MB")
    print(f"take a trace             {took_s / grid.planned * 1e3:8.2f} ms mean")
    print("take the coverage       ", milliseconds(lambda: survey.map.set_coverage(coverage)))
    survey.map.set_target((300.0, 300.0))
    touched = iter(range(REPETITIONS))
    again = make_trace(grid, grid.planned // 2)
    map_view, radar_view = views
    print(
        "MAP, touch and draw     ",
        milliseconds(lambda: draw(map_view, lambda: map_view.select_stop(Stop(next(touched), 3)))),
    )
    print(
        "RADAR, trace and draw   ",
        milliseconds(lambda: draw(radar_view, lambda: survey.take_trace(again))),
    )
    depth = iter(range(REPETITIONS))
    print(
        "RADAR, slider and draw  ",
        milliseconds(
            lambda: draw(radar_view, lambda: radar_view.depth_slider.setValue(next(depth)))
        ),
    )
    del application


if __name__ == "__main__":
    main()
