"""The checks of a survey's parameters."""

import math
from dataclasses import asdict, replace

from case_kit import each_case
from fault_kit import raises_fault
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


@each_case(
    "field, value, shown",
    [
        ("vna_address", "192.168.1", ("VNA address", "192.168.1")),
        ("vna_address", "GPIB0::16::INSTR\n", ("GPIB0::16::INSTR",)),
        ("start_frequency_hz", 0.0, ("start frequency", 0, 5000)),
        ("start_frequency_hz", math.nan, ("start frequency", "nan")),
        ("start_frequency_hz", 6.0e9, (6000000000,)),
        ("stop_frequency_hz", 6.1e9, ("stop frequency", 6100000000)),
        ("stop_frequency_hz", math.inf, ("stop frequency", "inf")),
        ("stop_frequency_hz", 500.0e6, (500000000,)),
        ("frequency_points", 1, ("frequency points", 1, 2, 4000)),
        ("frequency_points", 4001, ("frequency points", 4001)),
        ("stop_frequency_hz", 600.0e6 + 0.5, (1,)),
        ("stop_frequency_hz", 600.0e6, ()),
        ("stop_frequency_hz", 600.0e6 + 2.0, (0.5,)),
        ("if_bandwidth_hz", 0.5, ("IF bandwidth", 0.5, 1, 10000000)),
        ("if_bandwidth_hz", 2.0e7, ("IF bandwidth", 20000000)),
        ("if_bandwidth_hz", math.nan, ("IF bandwidth", "nan")),
        ("averages", -1, ("averages", -1, 0, 65535)),
        ("averages", 65536, ("averages", 65536)),
        ("output_power", "LOW POWER", ("LOW POWER", 16)),
        ("output_power", "A" * 17, ()),
        ("output_power", "LOW\n", ()),
        ("output_power", "HÖCH", ()),
        ("x_start_mm", -0.01, ("x start", -0.01, 0, 650)),
        ("x_start_mm", math.nan, ("x start", "nan")),
        ("x_stop_mm", 650.01, ("x stop", 650.01, 0, 650)),
        ("x_stop_mm", math.inf, ("x stop", "inf")),
        ("x_points", 2, ("x", 2, 3)),
        ("x_stop_mm", 10.0, (0.01,)),
        ("x_points", 2002, (2002, 0.009995)),
        ("y_start_mm", 800.01, ("y start", 800.01, 0, 800)),
        ("y_stop_mm", math.nan, ("y stop", "nan")),
        ("y_points", 0, ("y", 0)),
        ("polarizations_deg", (), ("number of polarizations", 0, 1, 36)),
        ("polarizations_deg", (0.0,) * 37, ("number of polarizations", 37)),
        ("polarizations_deg", (0.0, 91.0), ("polarization", 91)),
        ("polarizations_deg", (math.nan,), ("polarization", "nan")),
        ("polarizations_deg", (0.0, 0.0), ()),
        ("polarizations_deg", (0.0, 1.0), (1,)),
    ],
)
def test_a_wrong_parameter_is_refused_with_its_value_and_its_limits(field, value, shown):
    with raises_fault("plan.not_allowed", *shown, error=SurveyParametersError):
        check(replace(PARAMETERS, **{field: value}), TRAVEL)


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
    assert any("2004002" in str(one) for one in problems(huge, TRAVEL))


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


def test_the_address_may_be_of_another_form_that_only_its_driver_knows():
    check(replace(PARAMETERS, vna_address="TCPIP0::192.168.1.5::inst0::INSTR"), TRAVEL)
