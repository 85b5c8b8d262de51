"""Planning a survey, and putting together what carries it out."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_main_control.mid.background import DeviceTurns
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.measurement import PointMeasurement
from gpr20_main_control.mid.node_book import NodeBook
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import InstrumentState, Preparation
from gpr20_main_control.mid.recovery import Recovery
from gpr20_main_control.mid.robot import ReopenedSurvey, Robot, SurveyRecord
from gpr20_main_control.mid.status_board import StatusBoard
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey_report import SurveyReport
from gpr20_main_control.mid.survey_run import SurveyRun
from gpr20_survey.plan.coverage import Coverage
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import planned_durations_s
from gpr20_survey.plan.survey_estimate import needed_bytes
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.survey_settings import SurveySettings


@dataclass(frozen=True)
class Surroundings:
    """What every survey of a control works with."""

    robot: Robot
    facts: RobotConfig
    settings: SurveySettings
    nodes: NodeBook
    board: StatusBoard
    clock: Clock
    utc_now_us: Callable[[], int]
    on_coverage: Callable[[Coverage], None]


class SurveyFactory:
    """Makes plans and the runs that carry them out."""

    def __init__(
        self,
        surroundings: Surroundings,
        positioner: Positioner,
        interruption: Interruption,
        turns: DeviceTurns,
    ) -> None:
        self._surroundings = surroundings
        self._positioner = positioner
        self._interruption = interruption
        self._turns = turns

    def plan(self, parameters: SurveyParameters, survey_id: str) -> SurveyPlan:
        """Return the points of a survey and how long each takes."""
        facts, settings = self._surroundings.facts, self._surroundings.settings
        points = survey_points(parameters, facts.travel)
        durations_s = planned_durations_s(points, parameters.frequency_points, facts, settings)
        return SurveyPlan(survey_id, points, durations_s)

    def run(
        self, plan: SurveyPlan, parameters: SurveyParameters, reopened: Optional[ReopenedSurvey]
    ) -> SurveyRun:
        """Put together what carries out a plan.

        Raises:
            SurveyError: The report of the survey that is resumed cannot be read.
        """
        around = self._surroundings
        preparation = self._preparation(plan, parameters, reopened)
        former_json = "" if reopened is None else reopened.report_json
        coverage = Coverage(len(plan.points), plan.stored)
        return SurveyRun(
            plan,
            around.robot,
            self._positioner,
            preparation,
            self._measurement(preparation),
            SurveyReport(coverage, former_json, around.on_coverage),
            self._recovery(),
            around.board,
            self._interruption,
            self._turns.storage,
            around.clock,
            around.utc_now_us,
        )

    def _preparation(
        self, plan: SurveyPlan, parameters: SurveyParameters, reopened: Optional[ReopenedSurvey]
    ) -> Preparation:
        def make_record(instrument: InstrumentState) -> SurveyRecord:
            return self._record(plan, parameters, instrument)

        around = self._surroundings
        return Preparation(
            parameters,
            around.settings,
            around.robot,
            self._positioner,
            self._interruption,
            self._turns,
            make_record,
            reopened,
        )

    def _measurement(self, preparation: Preparation) -> PointMeasurement:
        around = self._surroundings
        # Vibrations of a robot that runs N times faster die down N times faster.
        settle_s = around.settings.settle_s / around.facts.time_scale
        return PointMeasurement(
            around.robot,
            self._positioner,
            preparation,
            replace(around.settings, settle_s=settle_s),
            self._interruption,
            around.clock,
        )

    def _recovery(self) -> Recovery:
        around = self._surroundings
        return Recovery(
            around.nodes,
            self._positioner,
            around.board,
            self._interruption,
            around.clock,
            around.settings.return_limit_s,
        )

    def _record(
        self, plan: SurveyPlan, parameters: SurveyParameters, instrument: InstrumentState
    ) -> SurveyRecord:
        around = self._surroundings
        metadata = {
            "simulated": around.facts.simulated,
            "parameters": asdict(parameters),
            "planned_traces": len(plan.points),
            "estimated_duration_s": sum(plan.durations_s),
            "instrument": {
                "identity": instrument.identity,
                "address": parameters.vna_address,
                "calibration_status": int(instrument.calibration),
                "calibration": instrument.calibration.meaning,
                "sweep": asdict(instrument.settings),
            },
            "axes": {axis_id.value: asdict(one) for axis_id, one in around.facts.axes.items()},
            "settings": asdict(around.settings),
        }
        size = needed_bytes(len(plan.points), parameters.frequency_points, sum(plan.durations_s))
        return SurveyRecord(plan.survey_id, around.utc_now_us(), json.dumps(metadata), size)
