"""The published topics: each sentence as English text, and as template with values."""

from dataclasses import replace

import pytest

pytest.importorskip("gpr20_msgs.msg")

from graph_in_process import Graph

from gpr20_common.faults import PART_SILENT
from gpr20_common.high.answers import message_from
from gpr20_common.message import Message
from gpr20_main_control.high.survey_topics import SurveyTopics
from gpr20_main_control.mid.survey.survey_status import Status
from gpr20_survey.faults import NO_GROUND
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.plan.survey_state import SurveyState as State


@pytest.fixture
def graph(monkeypatch):
    return Graph(monkeypatch)


@pytest.fixture
def topics(graph):
    topics = SurveyTopics()
    topics.simulated = True
    return topics


@pytest.mark.parametrize("missing", [None, PART_SILENT])
@pytest.mark.parametrize("fault", [None, NO_GROUND])
def test_a_status_has_its_message_with_the_warning_and_the_code_of_its_json(
    graph, topics, fault, missing
):
    reason = Message("no answer", details="get_height").with_fault(fault)
    warning = None if missing is None else Message("the node is silent").with_fault(missing)
    status = Status(State.PAUSED, Message("Paused: {reason}", reason=reason), missing=warning)
    status = replace(status, end=State.STOPPED, ended_us=12_500_000)
    topics.publish_status(status)
    (published,) = graph.published["control_status"]
    assert published.message == str(status.full_message)
    assert message_from(published) == status.full_message
    assert message_from(published).fault_code == published.fault.code
    assert published.fault.code == (fault.code if fault else missing.code if missing else "")
    assert published.simulated is True
    assert (published.end, published.ended.to_sec()) == (State.STOPPED, 12.5)


def test_a_change_publishes_only_what_has_changed(graph, topics):
    names = ("control_target_coordinate", "control_survey_data", "control_status")
    targets, progress, statuses = (graph.published[name] for name in names)
    point = SurveyPoint(3, 100.0, 50.0, 90.0)
    topics.publish_change(Status(), Status(target=point))
    assert len(targets) == 1
    assert progress == []
    topics.publish_change(Status(target=point), Status(target=point, visited_points=1))
    assert len(targets) == len(progress) == 1
    assert targets[0].x_mm == 100.0
    topics.publish_change(Status(target=point), Status())
    assert targets[1].x_mm == -1.0
    assert statuses == []
    topics.publish_change(Status(), Status(message=Message("Measuring")))
    assert len(statuses) == 1
