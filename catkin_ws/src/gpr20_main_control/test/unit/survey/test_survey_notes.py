"""What a survey notes in its log: zeros, pauses, decisions, the clock."""

from __future__ import annotations

import pytest

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.survey.engine import Accepted
from gpr20_main_control.mid.survey.survey_notes import SurveyNotes
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState as State


def kinds(notes):
    return [one.kind for one in notes]


def test_a_pause_its_end_and_what_the_operator_accepted_are_noted_in_their_order(bench):
    bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 2 and bench.control.pause()
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.analyzer.on_sweep = lambda: None
    bench.control.resume("", Accepted(zeros=True))
    bench.wait_for(State.FINISHED)
    expected = [Kind.EPOCH, Kind.PAUSE, Kind.DECISION, Kind.CONTINUE]
    assert kinds(bench.storage.notes) == expected
    pause, decision = bench.storage.notes[1:3]
    assert pause.values["text"].startswith("Paused on request")
    assert decision.values["zeros"] is True
    assert all(one.values["time"] for one in bench.storage.notes)


def test_a_clock_that_was_set_is_noted(bench):
    def set_back():
        if bench.analyzer.sweeps == 3:
            bench.clock.set_s -= 3600.0

    bench.analyzer.on_sweep = set_back
    bench.start()
    bench.wait_for(State.FINISHED)
    (note,) = [one for one in bench.storage.notes if one.kind is Kind.CLOCK]
    assert note.values["message"]["fault"]["code"] == faults.CLOCK_SET.code


def test_a_note_that_could_not_be_stored_waits_and_keeps_its_place():
    notes, stored = SurveyNotes(), []
    notes.add(Kind.EPOCH, number=1)
    notes.add_message(Kind.PAUSE, Message("Paused"))

    def refuse(_note):
        raise DeviceError(Message("the disk is full"))

    with pytest.raises(DeviceError):
        notes.send(refuse)
    notes.send(stored.append)
    notes.send(stored.append)
    assert kinds(stored) == [Kind.EPOCH, Kind.PAUSE]
