"""The functions of the steps: those of this package and of installed packages.

An installed package offers steps as entry points of the group `gpr20_analysis.steps`. Only these
and the steps of this package can be named: a name never makes anything be imported that was not
installed.
"""

from __future__ import annotations

import enum
import inspect
from dataclasses import dataclass
from typing import Any, Callable, Dict, Tuple, Union, get_type_hints

import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import PROCESSING, QUALITY, SAMPLE_DIMS
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import AnalysisError, StepError
from gpr20_analysis.processing.antenna_step import without_antenna
from gpr20_analysis.processing.background import remove_background, subtract_coupling
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.samples import (
    select_polarization,
)
from gpr20_analysis.processing.sweep import select_band
from gpr20_common.message import Message

SIMULATED = "simulated"
PARAMETER_TYPES = "int, float, str, an Enum or xarray.Dataset"

FUNCTIONS: Dict[str, Callable[..., xr.Dataset]] = {
    "antenna": without_antenna,
    "coupling": subtract_coupling,
    "background": remove_background,
    "band": select_band,
    "time_zero": set_time_zero,
    "polarization": select_polarization,
    "time": to_time,
}
"""The steps by name; the arguments after the survey are the parameters of a step."""


@dataclass(frozen=True)
class StepFunction:
    """The function of a step.

    Attributes:
        name: How the command line names it.
        call: The function: Dataset and parameters to Dataset.
        origin: Package, version and object; empty for a step of this package.
    """

    name: str
    call: Callable[..., xr.Dataset]
    origin: str = ""

    @property
    def parameters(self) -> Dict[str, Tuple[Any, Any]]:
        """(Type, default) of each parameter."""
        hints = get_type_hints(self.call)
        parameters = list(inspect.signature(self.call).parameters.values())[1:]
        return {one.name: (hints.get(one.name), one.default) for one in parameters}

    def apply(self, survey: xr.Dataset, **arguments: Any) -> xr.Dataset:
        """Return the Dataset after the step; attributes that a foreign step drops are kept.

        Raises:
            AnalysisError: The step cannot be applied, failed, or made no Dataset of this survey.
        """
        if not self.origin:
            return self.call(survey, **arguments)
        try:
            result = self.call(survey, **arguments)
        except AnalysisError:
            raise
        except Exception as error:  # the function is not ours: it may raise anything
            raise self.unusable(f"{type(error).__name__}: {error}") from error
        if not isinstance(result, xr.Dataset):
            raise self.unusable(
                Message("it returned {type}, no xarray.Dataset", type=type(result).__name__)
            )
        lost = [
            name
            for name in (*SAMPLE_DIMS, QUALITY)
            if name in survey and not (name in result and result[name].equals(survey[name]))
        ]
        lost += [
            str(name)
            for name, data in survey.data_vars.items()
            if name in result and set(result[name].dims) != set(data.dims)
        ]
        if lost:
            names = ", ".join(lost)
            raise self.unusable(
                Message("it changed {names}; positions, flags and dimensions stay", names=names)
            )
        # Whatever a step does: data stay simulated, and recorded as made by the steps before it.
        kept = {key: survey.attrs[key] for key in (SIMULATED, PROCESSING) if key in survey.attrs}
        return result.assign_attrs({**survey.attrs, **result.attrs, **kept})

    def unusable(self, reason: Union[str, Message]) -> StepError:
        """Return the error of a step that is not of this package."""
        return StepError(
            Message(
                "step '{step}' ({origin}) cannot be used: {reason}",
                step=self.name,
                origin=self.origin,
                reason=reason,
            ),
            fault=faults.STEPS,
        )


STEPS = ExtensionPoint(
    "gpr20_analysis.steps",
    Message("the step"),
    own={name: StepFunction(name, call) for name, call in FUNCTIONS.items()},
    error=StepError,
    fault=faults.STEPS,
)
"""By this, other packages add steps."""


def find_step(name: str) -> StepFunction:
    """Return the function of a step.

    Raises:
        StepError: There is none, or its package cannot be used.
    """
    if name in STEPS.own:
        own: StepFunction = STEPS.own[name]
        return own
    added = STEPS.addition(name)
    found = StepFunction(name, STEPS.load(added), added.origin)
    if not callable(found.call):
        raise found.unusable(Message("it is not a function"))
    for key, (kind, _default) in found.parameters.items():
        is_enum = inspect.isclass(kind) and issubclass(kind, enum.Enum)
        if kind not in (int, float, str, xr.Dataset) and not is_enum:
            raise found.unusable(
                Message(
                    "parameter '{parameter}' must be annotated with one of: {allowed}",
                    parameter=key,
                    allowed=PARAMETER_TYPES,
                )
            )
    return found
