"""A result without ROS: what the storage and the imaging node are asked, and their answers."""

import json
from types import SimpleNamespace

import numpy as np
from candidate_examples import candidate, candidate_list
from view_kit import SURVEY, description

from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import Imaging, Sticks, StoredSurvey
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.robot.service_model import PARTS, AxisAction
from gpr20_survey.results.answers import FocusedImage, Volume
from gpr20_survey.results.candidates import Flag

BLUE = Volume("/media/gpr/BLUE", "BLUE", 7_900_000_000, True)
RED = Volume("/media/gpr/RED", "RED STICK WITH A LONG NAME", 123_000_000, True)
LOCKED = Volume("/media/gpr/LOCKED", "LOCKED", 10**9, False)
TIME_US = 1_795_000_000_000_000
PLANNED = 40
ELEVEN = [
    candidate(1, 125.0, 90.0, 85.0, 31.0, [Flag.EDGE]),
    *(candidate(number, 174.0, 62.0, 60.0, 14.0, [Flag.CLUTTER]) for number in range(2, 12)),
]


class Requests:
    """In place of the clients: keeps the tickets, which a test answers."""

    def __init__(self):
        self.asked = []
        self.cancelled = []

    def ask(self, service, ticket, **fields):
        self.asked.append((service.name.lower(), ticket, fields))

    def cancel(self, request_id):
        self.cancelled.append(request_id)

    def of(self, name):
        found = [fields for kind, _ticket, fields in self.asked if kind == name]
        if name == "export":
            return [SimpleNamespace(**one) for one in found]
        return [tuple(one.values()) for one in found]

    def ticket(self, name):
        return [one[1] for one in self.asked if one[0] == name][-1]


class Now:
    s = 100.0

    def __call__(self):
        return self.s


def new_result(requests):
    return SurveyResult(Imaging(requests, Now()), lambda: TIME_US)


def image_of(found, traces=PLANNED):
    x_mm, y_mm, depth_mm = np.linspace(100, 200, 5), np.linspace(50, 110, 4), np.arange(4.0)
    return FocusedImage(traces, x_mm, y_mm, depth_mm, np.zeros((4, 4, 5), np.float32), found)


def stored(count=PLANNED, log=(), **changes):
    values = {"outcome": "finished", "log": list(log), **changes}
    return StoredSurvey(description(**values), tuple(range(count)))


def noted(kind, values):
    return {"kind": kind, "values": json.loads(json.dumps(values))}


def begin_search(result, requests, record=None):
    """Open the survey, and answer up to the search."""
    result.open(SURVEY)
    result.keep()
    requests.ticket("read").done(record or stored())
    result.keep()


def search(result, requests, candidates=ELEVEN, record=None, **changes):
    """Open the survey, and answer until its places are known."""
    begin_search(result, requests, record)
    found = candidate_list(candidates, survey_id=SURVEY, **changes)
    requests.ticket("focus").done(image_of(found))
    return found


def plug_in(requests, *volumes):
    requests.ticket("sticks").done(Sticks("gpr20-server", volumes))


class ServiceTools:
    """In place of the clients of ROBOT: remembers what it was asked, and answers by a test."""

    def __init__(self):
        self.asked = []
        self._tickets = {}

    def examine(self, _nodes, thorough):
        self.asked.append(("examine", thorough))

    def ask(self, service, ticket, **fields):
        self._tickets[service] = ticket
        if service is Service.MOVE:
            action = AxisAction(fields["action"]).name
            self.asked.append((fields["axis"], action, fields["distance"]))
        elif service is Service.DAILY:
            self.asked.append(("daily check", PARTS[fields["step"]]))
        else:
            self.asked.append(service.name.lower())

    def done(self, service, result):
        if service in self._tickets:
            self._tickets[service].done(result)

    def fail(self, service, problem):
        self._tickets[service].fail(problem)
