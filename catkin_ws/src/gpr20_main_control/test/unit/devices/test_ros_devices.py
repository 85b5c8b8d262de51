"""Failures of the devices' services, as the survey receives them."""

import pytest

pytest.importorskip("gpr20_msgs.srv")

from gpr20_common.faults import NODE_SILENT
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Fault, Message, Severity
from gpr20_common.sent_message import message_fields
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.high.ros_devices import RosAnalyzer, RosHeightSensor
from gpr20_main_control.mid.devices.described_robot import TimeLimits
from gpr20_msgs.srv import GetCalibrationStatusResponse, GetHeightResponse
from gpr20_survey.plan.robot_description import HEIGHT_SENSOR, PLAIN_NAMES

REFUSAL = Message("the height sensor reads {height_m:g} m", height_m=1.6, details="ADC 1023")


def answer_with(monkeypatch, response):
    def call(_client, _timeout_s, **_fields):
        if isinstance(response, Exception):
            raise response
        return response

    monkeypatch.setattr(ServiceClient, "call", call)


def test_a_refusal_keeps_template_and_values_and_names_its_service_in_the_details(monkeypatch):
    answer_with(monkeypatch, GetHeightResponse(success=False, **message_fields(REFUSAL)))
    with pytest.raises(DeviceError) as refused:
        RosHeightSensor(1.0).height_m()
    message = refused.value.message
    assert message.sentence() == "the height sensor reads 1.6 m"
    assert message.values["reason"] == REFUSAL
    assert message.all_details == ("get_height", "ADC 1023")


def test_what_the_part_reports_decides_also_if_it_is_a_note(monkeypatch):
    note = Fault("survey.complete", Message("Plan a new survey."), Severity.NOTE)
    fields = message_fields(REFUSAL.with_fault(note))
    answer_with(monkeypatch, GetHeightResponse(success=False, **fields))
    with pytest.raises(DeviceError) as refused:
        RosHeightSensor(1.0).height_m()
    assert refused.value.message.cause == note


def test_a_service_that_does_not_answer_is_reported_as_the_device_that_operators_know(monkeypatch):
    answer_with(monkeypatch, ServiceUnavailableError(Message("service get_height is gone")))
    with pytest.raises(DeviceError) as refused:
        RosHeightSensor(1.0).height_m()
    message = refused.value.message
    assert message.fault_code == NODE_SILENT.code
    assert message.values["device"] == PLAIN_NAMES[HEIGHT_SENSOR]
    assert message.all_details == ("service get_height is gone",)


def test_a_calibration_that_is_not_accepted_is_refused_with_the_drivers_message(monkeypatch):
    refusal = Message("the VNA is not calibrated; calibrate it")
    fields = message_fields(refusal)
    answer_with(monkeypatch, GetCalibrationStatusResponse(success=True, accepted=False, **fields))
    with pytest.raises(DeviceError) as refused:
        RosAnalyzer(TimeLimits(analyzer_limit_s=1.0)).calibration()
    assert refused.value.message == refusal
