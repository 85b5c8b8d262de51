"""The checks of a survey's parameters."""

import math
from dataclasses import asdict, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import PARAMETERS, TRAVEL

from gpr20_common.message import Message
from gpr20_common.mid.records import record_from
from gpr20_survey.plan.survey_parameters import (
    SurveyParameters,
    SurveyParametersError,
    check,
    problems,
)
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

SETTINGS = ("if_bandwidth_hz", "averages", "output_power")


def test_the_parameters_of_a_usual_survey_are_allowed():
    assert problems(PARAMETERS, TRAVEL) == []


def test_start_and_stop_may_be_in_either_order():
    turned = replace(PARAMETERS, x_start_mm=30.0, x_stop_mm=10.0, y_start_mm=35.0, y_stop_mm=5.0)
    assert problems(turned, TRAVEL) == []


@pytest.mark.parametrize(
    "field, value, message",
    [
        ("vna_address", "192.168.1", "VNA address is '192.168.1'; it must be four numbers"),
        ("vna_address", "192.168.1.256", "four numbers"),
        ("vna_address", "192.168.1.1.1", "four numbers"),
        ("vna_address", "vna.local", "four numbers"),
        ("vna_address", "1.2.3.٤", "four numbers"),
        ("vna_address", "GPIB0::16::INSTR\n", "the name of a VISA resource"),
        ("start_frequency_hz", 0.0, "start frequency is 0 Hz; it must lie between 5000 and"),
        ("start_frequency_hz", math.nan, "start frequency is nan"),
        ("start_frequency_hz", -1.0, "start frequency is -1"),
        ("start_frequency_hz", 6.0e9, "must be below the stop frequency, 6000000000 Hz"),
        ("stop_frequency_hz", 6.1e9, "stop frequency is 6100000000 Hz"),
        ("stop_frequency_hz", math.inf, "stop frequency is inf"),
        ("stop_frequency_hz", 500.0e6, "must be below the stop frequency, 500000000 Hz"),
        ("frequency_points", 0, "frequency points is 0; it must lie between 2 and 4000"),
        ("frequency_points", 1, "frequency points is 1"),
        ("frequency_points", 4001, "frequency points is 4001"),
        ("stop_frequency_hz", 600.0e6 + 0.5, "must be at least 1 Hz apart"),
        ("stop_frequency_hz", 600.0e6, "must be below the stop frequency"),
        ("stop_frequency_hz", 600.0e6 + 2.0, "give frequencies 0.5 Hz apart"),
        ("if_bandwidth_hz", 0.5, "IF bandwidth is 0.5 Hz; it must lie between 1 and 10000000 Hz"),
        ("if_bandwidth_hz", -10.0, "IF bandwidth is -10 Hz"),
        ("if_bandwidth_hz", 2.0e7, "IF bandwidth is 20000000 Hz"),
        ("if_bandwidth_hz", math.nan, "IF bandwidth is nan"),
        ("averages", -1, "averages is -1; it must lie between 0 and 65535"),
        ("averages", 65536, "averages is 65536"),
        ("output_power", "LOW POWER", "output power is 'LOW POWER'; use up to 16 letters"),
        ("output_power", "A" * 17, "output power is"),
        ("output_power", "LOW\n", "output power is"),
        ("output_power", "HÖCH", "output power is"),
        ("x_start_mm", -0.01, "x start is -0.01 mm; it must lie between 0 and 650 mm"),
        ("x_start_mm", math.nan, "x start is nan"),
        ("x_stop_mm", 650.01, "x stop is 650.01 mm; it must lie between 0 and 650 mm"),
        ("x_stop_mm", math.inf, "x stop is inf"),
        ("x_points", 2, "x points is 2; it must be at least 3"),
        ("x_points", -5, "x points is -5"),
        ("x_stop_mm", 10.0, "must be at least one motor step, 0.01 mm, apart"),
        ("x_points", 2002, "2002 stops 0.009995 mm apart"),
        ("y_start_mm", 800.01, "y start is 800.01 mm; it must lie between 0 and 800 mm"),
        ("y_stop_mm", math.nan, "y stop is nan"),
        ("y_points", 0, "y points is 0"),
        ("polarizations_deg", (), "number of polarizations is 0; it must lie between 1 and 36"),
        ("polarizations_deg", (0.0,) * 37, "number of polarizations is 37"),
        ("polarizations_deg", (0.0, 91.0), "polarization is 91 deg"),
        ("polarizations_deg", (math.nan,), "polarization is nan"),
        ("polarizations_deg", (0.0, 0.0), "they must differ by at least"),
        ("polarizations_deg", (0.0, 1.0), "polarization is 1 deg; it must be a multiple of"),
    ],
)
def test_a_wrong_parameter_is_refused_with_its_value_and_its_limits(field, value, message):
    with pytest.raises(SurveyParametersError) as refusal:
        check(replace(PARAMETERS, **{field: value}), TRAVEL)
    assert message in str(refusal.value)


@given(
    st.just(0.0) | st.floats(1.0, 1.0e7),
    st.integers(0, 65535),
    st.text("ABCxyz0123456789+-.", max_size=16),
)
def test_settings_of_any_analyzer_are_allowed_and_reach_its_sweep(bandwidth_hz, averages, power):
    parameters = replace(
        PARAMETERS, if_bandwidth_hz=bandwidth_hz, averages=averages, output_power=power
    )
    assert problems(parameters, TRAVEL) == []
    expected = AnalyzerSettings(bandwidth_hz, averages, power)
    assert parameters.sweep_settings.analyzer == expected


def test_parameters_of_early_surveys_leave_the_settings_to_the_instrument():
    early = {name: value for name, value in asdict(PARAMETERS).items() if name not in SETTINGS}
    assert record_from(SurveyParameters, early, "parameters") == PARAMETERS
    assert not PARAMETERS.sweep_settings.analyzer.is_known


def test_every_wrong_parameter_is_named():
    wrong = replace(PARAMETERS, vna_address="1.2.3", x_points=2, frequency_points=0)
    assert len(problems(wrong, TRAVEL)) == 3


def test_a_survey_of_more_traces_than_can_be_counted_is_refused():
    huge = replace(PARAMETERS, x_stop_mm=650.0, x_points=1001, y_stop_mm=800.0, y_points=1001)
    assert any("number of traces is 2004002" in str(one) for one in problems(huge, TRAVEL))


@given(
    st.floats(),
    st.floats(),
    st.integers(-(2**31), 2**31 - 1),
    st.lists(st.floats(), max_size=3),
)
def test_any_numbers_give_sentences_and_never_an_exception(start, stop, points, rotations):
    wild = replace(
        PARAMETERS,
        x_start_mm=start,
        x_stop_mm=stop,
        x_points=points,
        start_frequency_hz=start,
        stop_frequency_hz=stop,
        polarizations_deg=tuple(rotations),
    )
    assert all(isinstance(one, Message) for one in problems(wild, TRAVEL))


def test_the_address_may_be_the_name_of_a_visa_resource():
    check(replace(PARAMETERS, vna_address="TCPIP0::192.168.1.5::inst0::INSTR"), TRAVEL)
