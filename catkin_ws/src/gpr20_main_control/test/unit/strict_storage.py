"""A storage in memory that refuses what the real one refuses."""

from __future__ import annotations

import json
from collections import defaultdict

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import OpenedSurvey
from gpr20_survey.results.reopened_survey import ReopenedSurvey


class StrictStorage:
    """Stores every survey; one at a time is open."""

    def __init__(self):
        self.records = {}
        self.samples = defaultdict(dict)
        self.reports = {}
        self.notes = defaultdict(list)
        self.outcomes = {}
        self.opened = ""
        self.broken = False

    def open(self, record):
        self._check_disk()
        interrupted = self._interrupt_other(record.survey_id)
        self.records[record.survey_id] = record
        self.opened = record.survey_id
        return OpenedSurvey(folder_of(record.survey_id), interrupted)

    def reopen(self, survey):
        found = [one for one in self.records if survey in (one, folder_of(one))]
        if not found:
            raise DeviceError(Message("there is no survey {survey}", survey=survey))
        (survey_id,) = found
        if self.outcomes.get(survey_id) == "finished":
            raise DeviceError(Message("survey {survey} is finished and complete", survey=survey))
        self._check_disk()
        interrupted = self._interrupt_other(survey_id)
        self.opened = survey_id
        self.outcomes.pop(survey_id, None)
        stored = self.samples[survey_id]
        in_order = list(stored.values())
        return ReopenedSurvey(
            survey_id,
            folder_of(survey_id),
            self.records[survey_id].metadata_json,
            self.reports.get(survey_id, ""),
            tuple(sorted(stored)),
            (*in_order[:-8][:4], *in_order[-8:]),
            interrupted=interrupted,
        )

    def report(self, survey_id, report_json):
        self._check_open(survey_id)
        json.loads(report_json)
        self.reports[survey_id] = report_json
        return len(self.samples[survey_id])

    def note(self, survey_id, note):
        self._check_open(survey_id)
        self.notes[survey_id].append(note)

    def store(self, sample):
        self._check_open(sample.survey_id)
        stored = self.samples[sample.survey_id].setdefault(sample.index, sample)
        if stored is not sample:
            raise DeviceError(
                Message("index {index} is stored with other content", index=sample.index)
            )

    def close(self, survey_id, end):
        if not self.opened and self.outcomes.get(survey_id) == end.outcome:
            return
        self._check_open(survey_id)
        self.opened = ""
        self.outcomes[survey_id] = end.outcome

    def restart(self):
        """Forget which survey is open, as a restarted process does."""
        self.opened = ""

    def _interrupt_other(self, survey_id):
        other, self.opened = self.opened, ""
        if other in ("", survey_id):
            return ""
        self.outcomes[other] = "interrupted"
        return folder_of(other)

    def _check_disk(self):
        if self.broken:
            raise DeviceError(Message("the disk of the robot is full"))

    def _check_open(self, survey_id):
        self._check_disk()
        if self.opened != survey_id:
            raise DeviceError(Message("survey {survey} is not open", survey=survey_id))


def folder_of(survey_id):
    return f"20260101T000000_{survey_id[:8]}"
