"""GROUND: the running survey, or a past one, as the window shows it."""

from __future__ import annotations

import math
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.message import Message
from gpr20_common.mid.codec import record_of_json
from gpr20_operator.ground.past_surveys import survey_label
from gpr20_operator.ground.sources import Layer
from gpr20_operator.jobs.job import Requests
from gpr20_operator.jobs.pictures import Imaging, Pictures
from gpr20_operator.jobs.result_texts import headline
from gpr20_operator.robot.snapshot import Snapshot, percent_of
from gpr20_operator.words import local_time
from gpr20_survey.folder.survey_folder import FOLDER_NAME
from gpr20_survey.trace.trace import Trace
from gpr20_web.calls import Body, Call, Role, Route, Text, WebPage
from gpr20_web.faults import BusyError, no_survey
from gpr20_web.mid.shown_ground import GroundChoice, ShownGround

# What has come is taken so often: each picture is made at most so often, for all browsers.
PERIOD_S = 1.0
# Of past surveys, whose echoes need up to 256 MB each.
MOST_PAST = 3
# A past survey at which nobody has looked for so long gives room, or is forgotten.
ROOM_S, FORGOTTEN_S = 10.0, 120.0
PNG, WHOLE = "image/png", 100


class GroundPage(WebPage):
    """What the page Ground asks for, and its words.

    Args:
        requests: The storage and the imaging node.
        now_s: A clock that never goes back [s].
        report: Called with the reason why a trace or a survey cannot be shown.
    """

    words: Mapping[str, Message] = {
        "title": Message("Ground"),
        "keys": Message(
            "Touch a place, or use the arrow keys; Page Up and Page Down change the depth."
        ),
        "back": Message("Back to the robot's survey"),
        "age": Message("Last trace {seconds} s ago", seconds="{seconds}"),
        "layer": Message("Layer"),
        "options": Message("Options"),
        "echoes": Message("Echoes"),
        "focused": Message("Focused image"),
        "depth": Message("Depth: {depth} mm", depth="{depth}"),
        "polarization": Message("Antenna"),
        "along": Message("Section"),
        "x": Message("along X"),
        "y": Message("along Y"),
        "follow": Message("Follow the last trace"),
        "marks": Message("Candidates and markers"),
        "no_marks": Message("none here"),
        "text": Message("Text of the marker"),
        "add": Message("Set marker"),
    }

    def __init__(
        self,
        requests: Requests,
        now_s: Callable[[], float],
        report: Callable[[Message], None],
    ) -> None:
        self._now_s, self._report = now_s, report
        self._requests, self._pictures = requests, Pictures()
        self._live = self._new_ground()
        self._past: Dict[str, ShownGround] = {}
        self._snapshot: Optional[Snapshot] = None
        self._refreshed_s = self._traced_s = self._looked_s = -math.inf
        self.routes = (
            Route("GET", "/api/ground", Role.WATCH, self._ground),
            Route("GET", r"/api/ground/(?P<kind>map|section|bar)\.png", Role.WATCH, self._png),
        )

    def on_event(self, event: object) -> None:
        """Take traces, and what belongs to surveys."""
        if isinstance(event, Trace):
            self._traced_s = self._now_s()
        for ground in (self._live, *self._past.values()):
            ground.on_event(event)

    def show_state(self, snapshot: Snapshot) -> None:
        """Follow the running survey."""
        self._snapshot, now_s = snapshot, self._now_s()
        if now_s - self._refreshed_s < PERIOD_S:
            return
        self._refreshed_s, live = now_s, self._live
        live.traces.note_state(snapshot)
        if now_s - live.used_s <= ROOM_S:
            live.refresh()
            # The result of a survey that has ended is for every page.
            rests = snapshot.state is not None and not snapshot.running
            if rests or now_s - self._looked_s <= ROOM_S:
                live.model.keep_image(live.imaging)
        for folder, ground in tuple(self._past.items()):
            ground.refresh()
            if now_s - ground.used_s <= ROOM_S:
                ground.model.keep_image(ground.imaging)
            if now_s - ground.used_s > FORGOTTEN_S:
                del self._past[folder]

    def live(self, text: Text) -> Mapping[str, Any]:
        """Return which pictures of the running survey are the newest, and its result at the end."""
        live, self._live.used_s = self._live, self._now_s()
        survey = "" if live.shown.map.stop_states is None else live.survey_id
        image, snapshot = live.additions.image, self._snapshot
        result = None
        if image is not None and snapshot is not None and not snapshot.running:
            said = headline(image.found)
            result = {"folder": live.folder, "text": text(said)}
        # What is measured, until all is and the traces are here; then what it shows.
        is_whole = snapshot is not None and percent_of(snapshot) == WHOLE
        layer = Layer.ECHOES if is_whole and live.shown.radar.count else Layer.COVERAGE
        ground = {"survey": survey, "revision": live.revision, "layer": layer.value}
        return {"ground": ground, "result": result}

    def _ground(self, call: Call) -> Mapping[str, Any]:
        """Return a survey; if its revision is known already, only what changes all the time."""
        ground, choice = self._shown(call), _choice(call)
        ground.is_outdated |= call.values.get("again") == "1"
        found = self._about(ground, call.text)
        if call.values.get("known") != ground.revision:
            found["ground"] = ground.document(choice, call.text)
        return found

    def _png(self, call: Call) -> Body:
        return Body(self._shown(call).png(call.parts["kind"], _choice(call)), PNG)

    def _about(self, ground: ShownGround, text: Text) -> Dict[str, Any]:
        """Return which survey is shown, so that none is taken for another one."""
        is_live, snapshot, plan = ground is self._live, self._snapshot, ground.shown.map
        current = snapshot.current if is_live and snapshot is not None else None
        target = plan.grid.place_of(plan.current) if plan.grid and plan.current else None
        age_s = self._now_s() - self._traced_s
        return {
            "title": text(self._title(ground)),
            "past": not is_live,
            "folder": ground.folder if ground.survey_id else "",
            "revision": ground.revision,
            "carriage": None if current is None else [current.x_mm, current.y_mm],
            "target": None if target is None else [target.x_mm, target.y_mm],
            "age_s": int(age_s) if is_live and math.isfinite(age_s) else None,
        }

    def _title(self, ground: ShownGround) -> Message:
        snapshot, loading = self._snapshot, Message("Loading…")
        running = "" if snapshot is None else snapshot.running_survey
        if ground is not self._live:
            return ground.traces.band or ground.problem or loading
        if not ground.survey_id:
            return loading if running else Message("No survey yet.")
        if running == ground.survey_id:
            return Message("The survey that runs")
        listed = ground.listed
        if listed is None:
            return Message("The last survey; it does not run now")
        begun = local_time(listed.started, listed.folder)
        return Message(
            "Last survey: {name}", name=survey_label(listed.name, listed.survey_id, begun)
        )

    def _shown(self, call: Call) -> ShownGround:
        """Return the survey that a browser asks for; a past one is read first."""
        folder, live, now_s = call.values.get("survey", ""), self._live, self._now_s()
        live.used_s = now_s
        if folder:
            if folder not in self._past:
                if not FOLDER_NAME.fullmatch(folder):
                    raise no_survey(folder)
                self._make_room()
                self._past[folder] = self._new_ground(folder)
            ground = self._past[folder]
            ground.used_s = now_s
            # Of the running survey the live one knows more.
            if not ground.survey_id or ground.survey_id != live.survey_id:
                return ground
        self._looked_s = now_s
        return live

    def _new_ground(self, folder: str = "") -> ShownGround:
        imaging = Imaging(self._requests, self._now_s, self._pictures)
        return ShownGround(imaging, self._report, folder)

    def _make_room(self) -> None:
        """Forget the past survey that was looked at longest ago, if there are many."""
        if len(self._past) < MOST_PAST:
            return
        oldest = min(self._past.values(), key=lambda one: one.used_s)
        if self._now_s() - oldest.used_s < ROOM_S:
            raise BusyError(
                Message(
                    "{count} past surveys are looked at now; wait until one is closed",
                    count=MOST_PAST,
                )
            )
        del self._past[oldest.opened]


def _choice(call: Call) -> GroundChoice:
    """Return what a browser wants to see, which is JSON in its query."""
    return record_of_json(GroundChoice, call.values.get("choice", "{}").encode(), "choice")
