"""Heights are measured at every point, never assumed."""

import pytest
from fake_robot import Bench

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_survey.plan.survey_state import SurveyState as State


def test_the_height_of_every_trace_is_the_one_measured_at_its_own_point(bench, monkeypatch):
    def ground_below():
        return 0.1 + bench.x.coordinate / 1000.0 + bench.y.coordinate / 100.0

    monkeypatch.setattr(bench.height, "height_m", ground_below)
    bench.start()
    bench.wait_for(State.FINISHED)
    heights = {(s.x_coord_mm, s.y_coord_mm): s.antennae_height_m for s in bench.storage.samples}
    assert len(set(heights.values())) == 12
    for (x_mm, y_mm), height_m in heights.items():
        assert height_m == pytest.approx(0.1 + x_mm / 1000.0 + y_mm / 100.0)


def test_the_reason_of_a_missing_height_is_a_remark_whatever_characters_it_has(monkeypatch):
    def fail():
        raise DeviceError(Message("no answer:\nthe node died"))

    bench = Bench(on_height_failure="store_without")
    monkeypatch.setattr(bench.height, "height_m", fail)
    bench.start()
    bench.complete()
    assert bench.storage.samples[0].quality == ("no height: no answer:?the node died",)
