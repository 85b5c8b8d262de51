"""Services, and messages in answers and topics: an English text, beside it a gpr20_msgs/Fault."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any, Callable, Dict, Optional, Type, TypeVar

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, received_message
from gpr20_msgs.msg import Fault

Record = TypeVar("Record")


def message_fields(message: Message) -> Dict[str, Any]:
    """Return the fields that hold a sentence in a ROS message, a response or a result."""
    return {"message": str(message), "fault": fault_of(message)}


def message_from(answer: Any) -> Message:
    return received(answer.message, answer.fault)


def fault_of(message: Optional[Message]) -> Fault:
    """Return what stands beside the text of a message; of None it is empty."""
    record = {} if message is None else message.record()
    values = {name: json.dumps(record.get(name, {})) for name in ("values", "remedy_values")}
    return Fault(**{"can_continue": True, **record, **values})


def received(text: str, fault: Fault) -> Message:
    return received_message(text, {name: getattr(fault, name) for name in fault.__slots__})


def fields_of(record: Any, kind: Any) -> Dict[str, Any]:
    """Return those fields of a dataclass that a kind of ROS message has too.

    A sentence, or None, becomes its English text and, in the field NAME_fault, what stands beside.
    """
    found = {}
    for name in (one.name for one in fields(record) if one.name in kind.__slots__):
        value = found[name] = getattr(record, name)
        if f"{name}_fault" in kind.__slots__:
            found[name] = "" if value is None else str(value)
            found[f"{name}_fault"] = fault_of(value)
    return found


def record_of(kind: Type[Record], message: Any, **others: Any) -> Record:
    """Return the dataclass of a message with the fields of `fields_of`, and of other values."""
    found: Dict[str, Any] = {}
    for name in (one.name for one in fields(kind) if hasattr(message, one.name)):  # type: ignore[arg-type]
        value = found[name] = getattr(message, name)
        if hasattr(message, f"{name}_fault"):
            found[name] = received(value, getattr(message, f"{name}_fault")) if value else None
    return kind(**{**found, **others})


def advertise(name: str, service_class: Any, handler: Callable[[Any], Any]) -> rospy.Service:
    """Advertise a service that always answers: failures become `success=False` and a message.

    The response has `success` and what `message_fields` gives; the handler returns that of a
    success, and raises otherwise.
    """
    # Whoever repeats a request is refused again: of equal refusals in a row the first is logged.
    logged: Optional[Message] = None

    def answer(request: Any) -> Any:
        nonlocal logged
        try:
            response = handler(request)
            logged = None
            return response
        except Gpr20Error as error:
            message = error.message
            if message != logged:
                logged = message
                rospy.logwarn("%s refused: %s", name, message)
        except Exception:
            # Who waits for a step of a survey cannot do anything with a dropped call.
            message = log_fault(name)
        return service_class._response_class(success=False, **message_fields(message))

    return rospy.Service(name, service_class, answer)
