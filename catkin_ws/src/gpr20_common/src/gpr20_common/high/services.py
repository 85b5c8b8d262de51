"""Services that always answer: success and message, never an exception."""

from __future__ import annotations

import traceback
from typing import Any, Callable

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.graph_message import message_fields
from gpr20_common.message import Message


def advertise(name: str, service_class: Any, handler: Callable[[Any], Any]) -> rospy.Service:
    """Advertise a service whose failures become `success=False` and a message.

    Args:
        name: Relative name of the service.
        service_class: Generated class; its response has `success`, `message` and `message_json`.
        handler: Takes the request, returns the response of a success, raises otherwise.
    """

    def answer(request: Any) -> Any:
        try:
            return handler(request)
        except Gpr20Error as error:
            rospy.logwarn("%s refused: %s", name, error)
            return service_class._response_class(success=False, **message_fields(error.message))
        except Exception as error:
            # A fault in our own code must reach the operator as an answer too:
            # a caller that waits for a survey step cannot do anything with a dropped call.
            rospy.logerr("%s failed:\n%s", name, traceback.format_exc())
            message = Message(
                "internal error in {service}; see the log",
                service=name,
                details=f"{type(error).__name__}: {error}",
            )
            return service_class._response_class(success=False, **message_fields(message))

    return rospy.Service(name, service_class, answer)
