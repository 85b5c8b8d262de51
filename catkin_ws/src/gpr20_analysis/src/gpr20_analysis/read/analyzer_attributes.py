"""The settings of the analyzer as attributes of a survey's Dataset."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import Any, Dict, Iterable, List

from gpr20_common.message import Message
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

IF_BANDWIDTH, AVERAGES, OUTPUT_POWER = "if_bandwidth_hz", "averages", "output_power"
ATTRIBUTES = (IF_BANDWIDTH, AVERAGES, OUTPUT_POWER)


def analyzer_attributes(
    settings: Iterable[AnalyzerSettings], notes: List[Message]
) -> Dict[str, Any]:
    """Return the attributes; those of what is not known are left out.

    Args:
        settings: Those of each sample; samples of which they are not known do not count.
        notes: A remark on samples that were measured with different ones is added here; what
            differs is no attribute, but a variable of the samples.
    """
    found = Counter(one for one in settings if one.is_known).most_common()
    if not found:
        return {}
    (most, count), *others = found
    if others:
        notes.append(
            Message(
                "the samples were measured with different settings of the VNA: {count} with "
                "{settings}, {other_count} with others, such as {other}",
                count=count,
                settings=most.message,
                other_count=sum(number for _one, number in others),
                other=others[0][0].message,
            )
        )
    return {
        name: value
        for name, value in asdict(most).items()
        if value and all(value == getattr(one, name) for one, _count in others)
    }
