"""Storage and imaging node, for pages that wait: refusals keep what they say."""

import json
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from map_kit import MARKER
from view_kit import SURVEY

from gpr20_common.high.answers import message_fields
from gpr20_common.high.service_client import ServiceUnavailableError
from gpr20_common.message import Fault, verbatim
from gpr20_operator.high import storage_client
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import Senders
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.markers import Marker
from gpr20_web.errors import NotNowError
from gpr20_web.high.survey_services import RosSurveyServices

REFUSED = verbatim("it is damaged").with_fault(Fault("storage.test", verbatim("Repair it.")))


@pytest.fixture
def answers(monkeypatch):
    """What each service answers, or raises, and what it was asked."""
    answers = SimpleNamespace(of={}, asked=[])

    def client(name, _kind):
        def call(_timeout_s, **fields):
            answers.asked.append((name, fields))
            found = answers.of[name]
            if isinstance(found, Exception):
                raise found
            return SimpleNamespace(**{"success": True, **found})

        return SimpleNamespace(call=call)

    monkeypatch.setattr(storage_client, "ServiceClient", client)
    return answers


@pytest.fixture
def services(answers):
    return RosSurveyServices(storage_client.StorageClient(lambda _event: None, Senders("/")))


def test_a_refusal_keeps_its_sentence_its_fault_and_its_remedy(services, answers):
    answers.of["read_survey"] = {"success": False, **message_fields(REFUSED)}
    with pytest.raises(NotNowError) as refused:
        services.ask(Service.READ, survey=SURVEY)
    assert refused.value.message == REFUSED
    assert refused.value.message.fault_code == "storage.test"
    answers.of["add_fact"] = ServiceUnavailableError(verbatim("no answer"))
    with pytest.raises(NotNowError, match="the storage does not answer"):
        services.ask(Service.FACT, survey=SURVEY, kind=Kind.FOUND, values={})


def test_what_is_asked_is_sent_by_its_fields_and_what_is_answered_returned(services, answers):
    answers.of["list_surveys"] = {"surveys": [], "more": True}
    page = services.ask(Service.LIST, before="", max_surveys=50)
    assert (page.surveys, page.more) == ((), True)
    answers.of["add_fact"] = message_fields(verbatim("stored"))
    said = services.ask(Service.FACT, survey=SURVEY, kind=Kind.MARKER, values=MARKER.request())
    assert str(said) == "stored"
    _list, (_, added) = answers.asked
    assert (added["survey"], added["kind"]) == (SURVEY, "marker")
    assert Marker(**json.loads(added["values_json"])).same_request(MARKER)
