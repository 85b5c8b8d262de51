import json

import pytest
from case_kit import each_case

from gpr20_survey.folder.log_content import view_of
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.soil_note import (
    ENTERED,
    KIND,
    OF_PLAN,
    PLANNED,
    soil_of_survey,
    soil_values,
)
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY, Soils, soil_of

# Davis and Annan (1989), table 1; moist sand lies between its two neighbours.
RANGES = {
    Soils.DRY_SAND: (3.0, 5.0),
    Soils.MOIST_SAND: (5.0, 20.0),
    Soils.WET_SAND: (20.0, 30.0),
    Soils.CLAY: (5.0, 40.0),
}


@each_case("soil", Soils)
def test_the_permittivity_of_a_soil_lies_within_the_published_range(soil):
    low, high = RANGES[soil]
    assert MIN_PERMITTIVITY < low <= soil.value.permittivity <= high < MAX_PERMITTIVITY
    assert soil_of(soil.value.permittivity) is soil


def test_moist_sand_agrees_with_the_equation_of_topp():
    water = 0.16
    topp = 3.03 + 9.3 * water + 146.0 * water**2 - 76.7 * water**3
    assert Soils.MOIST_SAND.value.permittivity == pytest.approx(topp, rel=0.05)


def test_another_permittivity_is_the_operators_own():
    assert soil_of(9.5) is None


def test_a_survey_that_is_resumed_keeps_its_soil_until_somebody_decides_again():
    records, said = [], []
    for kind, values in (
        (Kind.PLAN, {PLANNED: 4.0, "started": "2026"}),
        (Kind.RESUME, {}),
        (Kind.DECISION, {"accepted": "other zeros"}),
        (KIND, soil_values(9.5, 0)),
        (Kind.RESUME, {}),
        (KIND, soil_values(7.0, 0)),
        (Kind.END, {"outcome": "finished"}),
        (KIND, soil_values(None, 0)),
    ):
        records.append(LogRecord.after(records[-1] if records else None, kind, values, "2026"))
        said.append(soil_of_survey(json.loads(view_of(records))))
    plan, last = (4.0, OF_PLAN), (7.0, ENTERED)
    assert said == [plan, plan, plan, *[(9.5, ENTERED)] * 2, last, last, None]
