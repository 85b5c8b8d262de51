"""The page of the stored surveys over a real storage, and an imaging node that a test answers."""

from __future__ import annotations

import json
from types import SimpleNamespace

from candidate_examples import candidate
from map_kit import focused
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import METADATA, POINTS, STARTED_US, SURVEY, planned_trace
from web_kit import route_of

from gpr20_imaging.mid.imaging import Imaging
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import Exported, StoredSurvey, SurveysListed
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.results.candidates import Flag
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys
from gpr20_web.calls import Call, Person, Role
from gpr20_web.mid.surveys_page import SurveysPage

DAY_US = 86_400_000_000
NOW_US = STARTED_US + DAY_US
PLACES = (candidate(1, 15.0, 14.0), candidate(2, 18.0, 12.0, flags=[Flag.CLUTTER]))


class Services:
    """What the robot's services do, without ROS.

    Attributes:
        searched: The surveys that were searched.
    """

    def __init__(self, data, processing=None, worker=None) -> None:
        self._processing, self._archive = processing, StoredSurveys(data)
        nothing = {name: lambda: None for name in ("start", "end", "close")}
        usual = SimpleNamespace(has_analysis=True, ask=self._search, **nothing)
        self._imaging = Imaging(data, worker or usual, lambda *_: None)
        self.asked, self.cancelled, self.searched = [], [], []
        self.focus = lambda survey: focused(PLACES, survey)
        self.export = lambda survey, _fields: Exported((f"{survey}_report.pdf",), b"%PDF")
        self.failure = None
        # What happens between the reading of a survey and what is made of it.
        self.after_read = lambda: None

    def ask(self, service, survey="", **fields):
        self.asked.append((service, survey, dict(fields)))
        if self.failure is not None:
            raise self.failure
        if service is Service.LIST:
            found, more = self._archive.list(**fields)
            return SurveysListed(tuple(found), more)
        if service is Service.READ:
            found = self._archive.survey(survey)
            then, self.after_read = self.after_read, lambda: None
            then()
            return StoredSurvey(json.dumps(found.description), tuple(found.stored_indices))
        if service is Service.FACT:
            values_json = json.dumps(fields["values"])
            return self._processing.add_fact(survey, fields["kind"].value, values_json)
        if service is Service.EXPORT:
            return self.export(survey, fields)
        assert service is Service.FOCUS
        # A field that is left out is 0 on the graph.
        fields = {"request_id": "", "permittivity": 0.0, **fields}
        return self._imaging.focus(survey=survey, **fields)

    def _search(self, _limit_s, _report, _name, folder, _permittivity):
        self.searched.append(read_description(folder)["survey_id"])
        return self.focus(self.searched[-1])

    def cancel(self, request_id):
        self.cancelled.append(request_id)

    def close(self):
        self._imaging.close()


class Surveys:
    """A data folder with a whole survey and a newer one that was cut off, and the page."""

    def __init__(self, data) -> None:
        self.data = data
        self.kit = Kit(data, now_ns=NOW_US * 1000)
        self.services = Services(data, self.kit.processing)
        self.page = SurveysPage(self.services.ask, self.services.cancel, data, lambda: NOW_US)
        self.whole = self._add(SURVEY, STARTED_US, len(POINTS), "finished")
        self.part = self._add(OTHER_SURVEY, STARTED_US + DAY_US, 4, "stopped")

    def _add(self, survey_id, started_us, count, outcome):
        folder = self.kit.open(survey_id, started_us=started_us, metadata_json=METADATA)
        for index in range(count):
            self.kit.processing.store(planned_trace(index, survey_id))
        self.kit.processing.close_survey(survey_id, outcome)
        named = Annotation("Ana Pérez", "El Carmen", "wet ground", name=f"Lane-{count}")
        self.kit.annotate(survey_id, named)
        return folder.name

    def ask(self, method, path, name="berta", role=Role.WATCH, **values):
        """Return what the page answers a person."""
        route, parts = route_of(self.page.routes, method, path)
        assert route.blocking and route.right is Role.WATCH
        return route.answer(Call(Person(name, role, "s", "::1"), "::1", values, parts))

    def get(self, folder, rest="", **values):
        return self.ask("GET", f"/api/surveys/{folder}{rest}", **values)

    def post(self, folder, rest, **values):
        return self.ask("POST", f"/api/surveys/{folder}/{rest}", **values)

    def search(self, folder):
        """Search a survey, and return its details."""
        self.post(folder, "candidates")
        return self.get(folder)

    def close(self):
        self.services.close()
        self.kit.processing.shut_down()
