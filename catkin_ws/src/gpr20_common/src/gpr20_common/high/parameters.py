"""The parameters of a node: what its robot was launched with.

A launch keeps its whole configuration, as JSON, under a name of its own (package `gpr20_launch`)
and hands that name to each node as the argument `configuration:=NAME`. A node that restarts gets
the same argument and so the same configuration, whatever was launched beside it meanwhile. Without
the argument a node has the defaults.
"""

from __future__ import annotations

import json
import sys
from typing import Mapping, Type, TypeVar

import rosgraph
import rospy

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from

Record = TypeVar("Record")

ARGUMENT = "configuration"


def configuration_name() -> str:
    """Return the name of the parameters with which this node was launched; empty if none."""
    return str(rosgraph.names.load_mappings(sys.argv).get(ARGUMENT, ""))


def read_parameters(record_class: Type[Record], section: str) -> Record:
    """Read every field of a dataclass from a section of the configuration.

    Raises:
        InvalidValueError: A parameter is missing, unknown or of the wrong type, or the dataclass
            refuses it.
    """
    name = configuration_name()
    if not name:
        return record_from(record_class, {}, section)
    text = rospy.get_param(name, "")
    try:
        sections = json.loads(text)
    except (TypeError, ValueError) as error:
        raise InvalidValueError(
            Message(
                "the configuration of this launch is gone, because the ROS master was restarted; "
                "end the launch and start it again",
                details=f"{name}: {text!r}",
            ),
            fault=faults.CONFIGURATION_GONE,
        ) from error
    return record_from(record_class, sections.get(section, {}), section)


def refuse_private_parameters() -> None:
    """Check that nobody gave a node that was started alone a private parameter: it reads none.

    Raises:
        InvalidValueError: There is one; it is named.
    """
    values = rospy.get_param(rospy.get_name(), {})
    names = sorted(values) if isinstance(values, Mapping) else [repr(values)]
    if names:
        raise InvalidValueError(
            Message(
                "the private parameters {names} of {node} are not read; write them into the "
                "robot's configuration, or start the node with configuration:=NAME",
                names=", ".join(names),
                node=rospy.get_name(),
            ),
            fault=faults.PRIVATE_PARAMETERS,
        )
