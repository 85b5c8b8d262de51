"""The client of the storage: every answer and every failure is an event with its reason."""

import queue
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from gpr20_common.high.service_client import ServiceUnavailableError
from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import message_fields
from gpr20_operator import faults
from gpr20_operator.ground.additions import (
    AdditionsFailed,
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
)
from gpr20_operator.ground.trace_events import (
    ReadingFailed,
    SurveyRead,
    SurveysListed,
)
from gpr20_operator.high import storage_client
from gpr20_operator.robot.senders import Senders
from gpr20_survey.plan.markers import Marker

MARKER = Marker("6ba7b810-9dad-11d1-80b4-00c04fd430c8", 1.0, 2.0, None, "here", "Ana")
ASKED = {
    "list": lambda one: one.list_surveys(""),
    "survey": lambda one: one.read_survey("folder"),
    "traces": lambda one: one.read_traces("id", (3, 4)),
    "additions": lambda one: one.read_additions("id"),
    "marker": lambda one: one.add_marker("id", MARKER),
    "removal": lambda one: one.remove_marker("id", MARKER.marker_id, "Ana"),
}
FAILED = {
    **dict.fromkeys(("list", "survey", "traces"), ReadingFailed),
    "additions": AdditionsFailed,
    **dict.fromkeys(("marker", "removal"), MarkingFailed),
}


class Storage:
    """In place of the services of the storage."""

    def __init__(self):
        self.text, self.failure, self.asked = "{}", None, []

    def client(self, name, _kind):
        def call(_timeout_s, **fields):
            self.asked.append((name, fields))
            if isinstance(self.failure, Exception):
                raise self.failure
            return SimpleNamespace(
                **(self.failure or {"success": True}),
                **{"metadata_json": self.text, "stored_indices": [0, 3]},
                **{"surveys": [], "more": False, "markers_json": "[]", "survey_id": "id"},
            )

        return SimpleNamespace(call=call)


@pytest.fixture
def storage(monkeypatch):
    storage = Storage()
    monkeypatch.setattr(storage_client, "ServiceClient", storage.client)
    return storage


@pytest.fixture
def answer(storage):
    events = queue.Queue()
    client = storage_client.StorageClient(events.put, Senders("/"))

    def ask(what):
        ASKED[what](client)
        return events.get(timeout=10.0)

    yield ask
    client.close()


def test_answers_become_events(answer):
    assert answer("list") == SurveysListed("", (), False)
    assert answer("survey") == SurveyRead("folder", "{}", (0, 3))
    assert answer("additions") == AdditionsRead("id", (), ())
    assert answer("marker") == answer("removal") == MarkersStored("id", ())


@pytest.mark.parametrize("what", list(ASKED))
def test_silence_and_refusals_are_failures_with_a_reason(answer, storage, what):
    storage.failure = ServiceUnavailableError(Message("no answer"))
    silent = answer(what)
    assert isinstance(silent, FAILED[what])
    assert silent.reason.cause == faults.PART_SILENT and silent.reason.remedy is not None
    storage.failure = {"success": False, **message_fields(verbatim("refused"))}
    refused = answer(what)
    assert isinstance(refused, FAILED[what])
    assert str(refused.reason) == "refused" and refused.reason.cause is None
