"""Notes of exports in the log of a survey, which the storage writes."""

from __future__ import annotations

import json
from typing import Optional, Sequence

from gpr20_common.high.answers import message_from
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_msgs.srv import AddFact
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.trace.utc_time import iso_text

LIMIT_S = 20.0


class ExportNotes:
    """Asks the storage to note exports."""

    def __init__(self) -> None:
        self._facts = ServiceClient("add_fact", AddFact)

    def add(self, survey: str, files: Sequence[str], volume: str) -> Optional[Message]:
        """Note an export; return why that was not possible, None if it is noted.

        Args:
            survey: The survey's id, or the name of its folder.
            files: Names of the files.
            volume: Path of the stick.
        """
        values = {"time": iso_text(time_of_day_us()), "files": list(files), "volume": volume}
        fields = {"survey": survey, "kind": Kind.EXPORT.value, "values_json": json.dumps(values)}
        try:
            response = self._facts.call(LIMIT_S, **fields)
        except ServiceUnavailableError as error:
            return error.message
        return None if response.success else message_from(response)
