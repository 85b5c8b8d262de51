"""Storage and imaging node, for pages that wait for the answers."""

from __future__ import annotations

from typing import Any

from gpr20_operator.high.ros_events import RequestError
from gpr20_operator.high.storage_client import StorageClient
from gpr20_operator.jobs.job import Service
from gpr20_web.errors import NotNowError


class RosSurveyServices:
    """See `SurveyServices`."""

    def __init__(self, requests: StorageClient) -> None:
        self._requests = requests

    def ask(self, service: Service, **fields: Any) -> Any:
        """Return what a service answers."""
        try:
            return self._requests.wait_for(service, **fields)
        except RequestError as error:
            raise NotNowError(error.message) from error

    def cancel(self, request_id: str) -> None:
        """Ask to end a request, without waiting."""
        self._requests.cancel(request_id)
