"""Who sent a message or a request, and of which type it is."""

from __future__ import annotations

from typing import Any, Dict


def connection_header(received: Any) -> Dict[str, str]:
    """Return the header of the connection that brought a message or a service request.

    rospy adds the attribute to each object that it hands to a callback; no message class
    declares it.

    Args:
        received: The argument of the callback.
    """
    header: Dict[str, str] = received._connection_header
    return header
