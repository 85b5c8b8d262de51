"""Services that always answer: success and message, never an exception."""

from __future__ import annotations

from typing import Any, Callable

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.high.answers import message_fields
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message


def advertise(name: str, service_class: Any, handler: Callable[[Any], Any]) -> rospy.Service:
    """Advertise a service whose failures become `success=False` and a message.

    Args:
        name: Relative name of the service.
        service_class: Its response has `success` and what `message_fields` gives.
        handler: Takes the request, returns the response of a success, raises otherwise.
    """

    def answer(request: Any) -> Any:
        try:
            return handler(request)
        except Gpr20Error as error:
            rospy.logwarn("%s refused: %s", name, error)
            message = error.message
        except Exception as error:
            # A fault in our own code must reach the operator as an answer too:
            # a caller that waits for a survey step cannot do anything with a dropped call.
            message = internal_error(name, error)
        return service_class._response_class(success=False, **message_fields(message))

    return rospy.Service(name, service_class, answer)


def success(service_class: Any, message: Message, **fields: Any) -> Any:
    """Return the response of a success; the message says what was done."""
    return service_class._response_class(success=True, **message_fields(message), **fields)


def internal_error(name: str, error: Exception) -> Message:
    """Log the exception that is being handled, a fault in our own code; return what to answer."""
    log_fault(name)
    return Message(
        "internal error in {service}; see the log",
        service=name,
        details=f"{type(error).__name__}: {error}",
    ).with_fault(INTERNAL)
