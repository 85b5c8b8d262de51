"""What an MS2026C can measure, and about how long that takes (Anritsu 10580-00306)."""

from __future__ import annotations

from gpr20_survey.trace.sweep_settings import SweepSettings

# [SENSe]:FREQuency:STARt
MIN_FREQUENCY_HZ = 5.0e3
MAX_FREQUENCY_HZ = 6.0e9
MIN_FREQUENCY_POINTS = 2
MAX_FREQUENCY_POINTS = 4000
# Closer frequencies could be one to the synthesizer.
MIN_FREQUENCY_SPACING_HZ = 1.0
# [SENSe]:SWEep:IFBW
IF_BANDWIDTHS_HZ = (
    *(10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0),
    *(10_000.0, 20_000.0, 50_000.0, 100_000.0),
)
MAX_AVERAGES = 65_535
# :SOURce:POWer
OUTPUT_POWERS = ("LOW", "HIGH")
# What the robot's group states for its unit, at the IF bandwidth that it usually has.
SECONDS_PER_POINT = 350.0e-6
USUAL_IF_BANDWIDTH_HZ = 10_000.0


def sweep_duration_s(
    sweep: SweepSettings,
    seconds_per_point: float = SECONDS_PER_POINT,
    unknown_if_bandwidth_hz: float = USUAL_IF_BANDWIDTH_HZ,
) -> float:
    """Return about how long a trace takes [s], with its averages.

    A narrower IF bandwidth makes each point longer by the time that its filter needs, which is
    about the inverse of the bandwidth.

    Args:
        sweep: What is measured.
        seconds_per_point: Duration of one point at the usual IF bandwidth [s].
        unknown_if_bandwidth_hz: Assumed where `sweep` leaves the bandwidth to the instrument [Hz].
    """
    bandwidth_hz = sweep.analyzer.if_bandwidth_hz or unknown_if_bandwidth_hz
    slower_s = max(0.0, 1.0 / bandwidth_hz - 1.0 / USUAL_IF_BANDWIDTH_HZ)
    return sweep.points * (seconds_per_point + slower_s) * max(1, sweep.analyzer.averages)
