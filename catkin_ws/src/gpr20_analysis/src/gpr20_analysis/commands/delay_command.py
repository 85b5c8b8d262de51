"""gpr20 delay: fit the delay of cables and antennas to the surface echo of a survey."""

from __future__ import annotations

import argparse

from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image_options import check_range
from gpr20_analysis.processing.chain import recorded_steps
from gpr20_analysis.processing.delay import recorded_delay_s
from gpr20_analysis.processing.surface_echo import SurfaceFit, fit_delay
from gpr20_analysis.read.survey_attributes import DELAY_KEY
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.radar.depth import one_way_path_m

NS_PER_S = 1e9
FILE = "analyzer.yaml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    add = parser.add_argument
    add("--separation", type=float, default=0.0, metavar="M", help="distance between the antennas")
    add(
        "--height",
        type=float,
        metavar="M",
        help="one antenna height for all samples instead of the recorded ones, such as that above "
        "a metal plate",
    )
    add("--plate", action="store_true", help="the survey was measured over a metal plate")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Fit the delay, print it and return the exit status."""
    check_range("--separation", chosen.separation, 0.0, 2.0, "m")
    if chosen.height is not None:
        check_range("--height", chosen.height, 0.001, 10.0, "m")
    survey = inputs.load(chosen, catalogue)
    steps = [one["step"] for one in recorded_steps(survey)]
    if steps:
        raise WrongDatasetError(
            Message(
                "the data were changed by the steps {steps}; fit the delay to the survey as "
                "measured",
                steps=", ".join(steps),
            )
        )
    fit = fit_delay(survey, chosen.separation, chosen.height, chosen.plate)
    recorded_ns = recorded_delay_s(survey) * NS_PER_S
    say(catalogue.tr("delay of cables and antennas: {delay_ns:.3f} ns, within "
                       "{uncertainty_ns:.3f} ns (95 %), from {count} traces",
                       delay_ns=fit.delay_s * NS_PER_S,
                       uncertainty_ns=fit.uncertainty_s * NS_PER_S,
                       count=fit.traces))  # fmt: skip
    say(catalogue.tr("spread of single traces: {spread_ns:.3f} ns, {spread_mm:.1f} mm of height",
                       spread_ns=fit.residual_s * NS_PER_S,
                       spread_mm=one_way_path_m(fit.residual_s) * MM_PER_M))  # fmt: skip
    say(catalogue.text(_separated(fit)))
    say(catalogue.tr("recorded in the survey: {delay_ns:.3f} ns", delay_ns=recorded_ns))
    say(catalogue.tr("in {file} of the robot's configuration:", file=FILE))
    say(f"{DELAY_KEY}: {fit.delay_s * NS_PER_S:.3f}")
    return inputs.status_of(survey)


def _separated(fit: SurfaceFit) -> Message:
    if fit.by_movement:
        return Message("surface and coupling are separated by the differing heights")
    return Message(
        "the heights do not separate surface and coupling; the last strong echo of all traces is "
        "taken for the surface"
    )


COMMAND = Command(
    "Fit the delay of cables and antennas to the echo of the surface, or of a metal plate, and the "
    "recorded heights. Use a survey as measured, before any step.",
    add_arguments,
    run,
)
