"""Two clients that set and start different plans: a START measures its own plan or nothing."""

import contextlib
import json
import random
import threading
from dataclasses import replace

import pytest
from fake_robot import LIMIT_S
from run_seed import draws
from survey_examples import PARAMETERS

from gpr20_main_control.errors import RequestRefusedError
from gpr20_survey.plan.survey_parameters import SurveyParametersError

OTHER = replace(PARAMETERS, y_points=3)
ROUNDS = draws(5)


def test_status_and_description_say_whose_plan_it_is(bench):
    plan = bench.control.set_parameters(replace(PARAMETERS, vna_address=""), "/window")
    # The id is that of the address of the configuration, too.
    assert plan.parameters.vna_address
    shown = bench.board.status
    assert (shown.plan_id, shown.plan_set_by) == (plan.parameters.plan_id, "/window")
    # A plan that is refused replaces none.
    with pytest.raises(SurveyParametersError):
        bench.control.set_parameters(replace(PARAMETERS, x_points=2), "/other")
    assert bench.board.status == shown
    bench.control.start(plan_id=plan.parameters.plan_id)
    bench.complete()
    ended = bench.board.status
    assert (ended.plan_id, ended.plan_set_by) == (plan.parameters.plan_id, "/window")


def test_of_two_clients_none_measures_the_plan_of_the_other(bench):
    drawn = random.Random(7)
    for number in range(ROUNDS):
        together = threading.Barrier(2)
        started = {}

        def ask(client, x_start_mm, wait_s, together=together, started=started):
            together.wait(LIMIT_S)
            with contextlib.suppress(RequestRefusedError):
                parameters = replace(PARAMETERS, x_start_mm=x_start_mm)
                plan = bench.control.set_parameters(parameters, client)
                # Not for a condition: the calls of both mix differently in each round.
                threading.Event().wait(wait_s)
                started[bench.control.start(plan_id=plan.parameters.plan_id)] = client, x_start_mm

        clients = [
            threading.Thread(target=ask, args=(client, x_mm, drawn.random() * 0.002))
            for client, x_mm in (("/one", 0.1 * number), ("/two", 5.0 + 0.1 * number))
        ]
        for one in clients:
            one.start()
        for one in clients:
            one.join(LIMIT_S)
        bench.wait_until(lambda: not bench.board.status.state.running)
        # Whoever has set a plan last can start it, unless the other one runs.
        assert started
        recorded = {one.survey_id: json.loads(one.metadata_json) for one in bench.storage.records}
        for survey_id, (client, x_start_mm) in started.items():
            assert recorded[survey_id]["plan_set_by"] == client
            assert recorded[survey_id]["parameters"]["x_start_mm"] == x_start_mm
