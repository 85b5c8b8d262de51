"""The ROS interface of the network analyzer."""

from __future__ import annotations

import json
import math
from typing import Callable, Optional

import rospy

from gpr20_common.high import diagnostics
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import ros_time
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_facts import Hardware
from gpr20_msgs import srv
from gpr20_survey.trace.sweep import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaOldDataError, VnaSettingError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, Vxi11Transport, connect
from gpr20_vna_acquisition.mid.analyzers import make_analyzer
from gpr20_vna_acquisition.mid.exchanges import WATCH_PERIOD_S, RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

NODE = "vna_acquisition"
# Returns the TCP port of the core channel at an address, or None to ask the portmapper there.
PortLookup = Callable[[str], Optional[int]]


class VNANode:
    """The services of the network analyzer."""

    def __init__(self, driver: VNADriver, hardware: Hardware) -> None:
        self._driver = driver
        self._services = [
            advertise("connection", srv.Connection, self._connect),
            advertise("freq_sweep_setup", srv.FreqSweepSetup, self._set_up),
            advertise("get_freq", srv.GetFreq, self._get_freq),
            advertise("get_data", srv.GetData, self._get_data),
            advertise("confirm_data", srv.ConfirmData, self._confirm_data),
            advertise("get_calibration_status", srv.GetCalibrationStatus, self._get_calibration),
        ]
        self._link_check = Periodic(diagnostics.PERIOD_S, driver.check_idle_link)
        self._diagnostics = diagnostics.Diagnostics(hardware.name, self._health)
        self._description = publish_description(NODE, hardware, driver.parameters)
        rospy.on_shutdown(driver.shut_down)

    def _connect(self, request: srv.ConnectionRequest) -> srv.ConnectionResponse:
        if not request.connect:
            self._driver.disconnect_from_vna()
            return srv.ConnectionResponse(success=True, **message_fields(Message("disconnected")))
        identity = self._driver.connect_to_vna(request.address)
        message = Message(
            "connected to {identity} at {address}", identity=identity, address=request.address
        )
        return srv.ConnectionResponse(success=True, identity=identity, **message_fields(message))

    def _set_up(self, request: srv.FreqSweepSetupRequest) -> srv.FreqSweepSetupResponse:
        wanted = AnalyzerSettings(request.if_bandwidth_hz, request.averages, request.output_power)
        accepted = self._driver.set_frequency_sweep(
            SweepSettings(
                request.start_frequency_hz, request.stop_frequency_hz, request.points, wanted
            )
        )
        return srv.FreqSweepSetupResponse(
            success=True,
            start_frequency_hz=accepted.start_frequency_hz,
            stop_frequency_hz=accepted.stop_frequency_hz,
            points=accepted.points,
            sweep_duration_s=self._driver.trace_duration_s,
            request_limit_s=self._driver.answered_within_s,
            **vars(accepted.analyzer),
            **message_fields(Message("the VNA confirmed every setting")),
        )

    def _get_freq(self, _request: srv.GetFreqRequest) -> srv.GetFreqResponse:
        return srv.GetFreqResponse(success=True, frequency_hz=self._driver.get_freq().tolist())

    def _get_data(self, request: srv.GetDataRequest) -> srv.GetDataResponse:
        if request.confirm_later:
            number, sweep = self._driver.take_sweep()
        else:
            number, sweep = 0, self._driver.get_trace()
        return srv.GetDataResponse(
            success=True,
            number=number,
            frequency_hz=sweep.frequency_hz.tolist(),
            s21_real=sweep.s21_real.tolist(),
            s21_imag=sweep.s21_imag.tolist(),
            sweep_started=ros_time(sweep.sweep_started_us),
            sweep_ended=ros_time(sweep.sweep_ended_us),
            quality=list(sweep.quality),
            **vars(sweep.analyzer),
        )

    def _confirm_data(self, request: srv.ConfirmDataRequest) -> srv.ConfirmDataResponse:
        try:
            confirmed = self._driver.confirm(request.number)
        except (VnaSettingError, VnaNotReadyError, VnaOldDataError) as error:
            return srv.ConfirmDataResponse(
                success=False, repeat=True, **message_fields(error.message)
            )
        known = confirmed.temperature_c is not None
        return srv.ConfirmDataResponse(
            success=True,
            quality=list(confirmed.remarks),
            temperature_c=confirmed.temperature_c if known else math.nan,
        )

    def _get_calibration(
        self, _request: srv.GetCalibrationStatusRequest
    ) -> srv.GetCalibrationStatusResponse:
        status = self._driver.check_calibration_status()
        refusal = self._driver.calibration_refusal(status)
        return srv.GetCalibrationStatusResponse(
            success=True,
            status=int(status),
            accepted=not refusal,
            details_json=json.dumps(dict(self._driver.state.calibration_details)),
            **message_fields(refusal or verbatim(status.name)),
        )

    def _health(self) -> diagnostics.Health:
        state, trouble = self._driver.state, self._driver.trouble
        values = {
            "address": state.address,
            "identity": state.identity,
            "linked": state.linked,
            "sweep": state.sweep or "not configured",
            "calibration": "" if state.calibration is None else state.calibration.name,
            "repeated attempts": state.repeats,
            "sweep takes [s]": f"{self._driver.trace_duration_s:.6f}",
            "last remarks": "; ".join(map(str, state.last_quality)),
            "last error": state.last_error or "",
        }
        if trouble:
            return diagnostics.ERROR, trouble, values
        if not state.address:
            return (
                diagnostics.WARN,
                Message("not connected").with_fault(errors.NOT_CONNECTED.as_note()),
                values,
            )
        if state.last_quality:
            return diagnostics.WARN, state.last_quality[0].as_warning(), values
        connected = Message("connected to {identity}", identity=state.identity)
        return diagnostics.OK, connected, values


def build_vna_node(parameters: VnaParameters, port_of: PortLookup, hardware: Hardware) -> VNANode:
    """Build the node and everything below it.

    Args:
        parameters: Parameters of the driver.
        port_of: Returns the port of the VXI-11 core channel at an address.
        hardware: What the hardware is.
    """
    limits = LinkLimits(parameters.connect_timeout_s, parameters.answer_timeout_s)

    def open_link(address: str) -> Vxi11Transport:
        return connect(address, limits, port_of(address))

    deadline = RequestDeadline(Clock())
    # The constructor of a class of others is watched, too.
    Periodic(WATCH_PERIOD_S, lambda: deadline.end_if_overdue(rospy.logfatal))
    analyzer = make_analyzer(parameters, open_link, deadline)
    return VNANode(VNADriver(analyzer, parameters, deadline, rospy.logwarn), hardware)


def main() -> None:
    """Run the driver of the real network analyzer."""

    def build() -> VNANode:
        parameters = read_parameters(VnaParameters, NODE)
        port = parameters.vxi11_port or None
        return build_vna_node(parameters, lambda _address: port, Hardware(parameters.model))

    run_node(NODE, build)
