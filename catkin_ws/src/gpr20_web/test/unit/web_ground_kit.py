"""A web page of the ground without ROS, and surveys for it."""

import io
import json

import numpy as np
import view_kit
from PIL import Image
from result_kit import Requests
from view_kit import FOLDER, PAST, SURVEY, depth_echo, description, past_survey, snapshot, trace_at
from web_kit import route_of

from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import grid_from_description
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.jobs.pictures import StoredSurvey, SurveysListed, TracesRead
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import TraceBlock
from gpr20_web.calls import Body, Call, Person, Role
from gpr20_web.low.event_streams import json_text
from gpr20_web.mid.ground_page import PERIOD_S, GroundPage

PLANNED = 40
ANA = Person("Ana", Role.WATCH, "secret", "10.0.0.7")


class Server:
    """A page with what its node does for it."""

    def __init__(self):
        self.now_s = 1000.0
        self.node, self.problems = Requests(), []
        self.page = GroundPage(
            self.node, lambda: self.now_s, lambda one: self.problems.append(str(one))
        )
        self.snapshot = snapshot()

    def tick(self, seconds=PERIOD_S, **state):
        """Let time pass while somebody watches; say what the robot does."""
        self.page.live(str)
        if state:
            self.snapshot = snapshot(**state)
        self.now_s += seconds
        self.page.show_state(self.snapshot)

    def ask(self, path="/api/ground", method="GET", **values):
        route, parts = route_of(self.page.routes, method, path)
        asked = {one: values.pop(one) for one in ("survey", "known", "again") if one in values}
        asked["choice"] = json.dumps(values)
        answer = route.answer(Call(ANA, ANA.address, asked, parts))
        if not isinstance(answer, Body):
            # As it is sent: nothing in it is infinite or unknown to JSON.
            assert json.loads(json_text(answer)) == answer
        return answer

    def pixels(self, kind="map", **values):
        """Return red, green, blue and alpha of a picture."""
        body = self.ask(f"/api/ground/{kind}.png", **values)
        assert body.kind == "image/png"
        return np.array(Image.open(io.BytesIO(body.content)).convert("RGBA"))

    def look(self):
        """Look at the map until an image is asked for."""
        self.ask()
        self.tick()
        return self.node.of("focus")

    def run(self, stored=PLANNED, s21=None, code=SurveyState.SURVEYING, **described):
        """Let a survey run of which the first traces are stored and here."""
        text = description(**described)
        grid = grid_from_description(text)
        self.page.on_event(SurveyDescribed(text))
        runs = ((0, stored), (1, 0)) if stored < PLANNED else ((0,), (1,))
        self.page.on_event(CoverageRuns(SURVEY, PLANNED, *runs))
        for index in range(stored):
            self.page.on_event(trace_at(grid, index, s21=depth_echo(0.1) if s21 is None else s21))
        state = None if code is None else view_kit.state_of(code, survey_id=SURVEY)
        self.snapshot = snapshot(state=state)
        self.tick()
        return grid

    def open_past(self, stored=PLANNED, depth_m=0.2, **asked):
        """Ask for a past survey, and let the storage answer."""
        self.ask(survey=FOLDER, **asked)
        self.node.ticket("list").done(SurveysListed((past_survey(),), False))
        text = description(survey_id=PAST)
        self.node.ticket("read").done(StoredSurvey(text, tuple(range(stored))))
        # The first time they may still be on their way.
        self.tick()
        self.tick()
        grid = grid_from_description(text)
        traces = [trace_at(grid, index, s21=depth_echo(depth_m)) for index in range(stored)]
        self.node.ticket("traces").done(TracesRead(TraceBlock.of(PAST, traces), {}))
        self.tick()
        return grid
