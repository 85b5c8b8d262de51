"""Checks of addresses, and of who may reach ROS."""

from __future__ import annotations

import os
from typing import Iterator

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.low.masters import is_here
from gpr20_doctor.low.processes import answer_of
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import ADDRESSES, Machine

AS_SERVICES = Message("Run it as the services do: gpr20-run doctor")
CHECK_LINK = Message(
    "Check the link, and the address of this computer. Then start the robot again."
)
FIREWALL = "/usr/lib/gpr20/firewall"
TABLES = ("nft", "list", "tables")
TABLE = "table inet gpr20"


def check_addresses(machine: Machine) -> Iterator[Finding]:
    """Judge the addresses of the two machines, and where ROS listens."""
    address = machine.environment.get("ROS_HOSTNAME") or machine.environment.get("ROS_IP", "")
    yield _listening(machine, address)
    nodes = machine.processes.nodes_of(machine.master)
    known = {one.variable("ROS_HOSTNAME", "ROS_IP") for one in nodes} - {"", address}
    gone = sorted(one for one in known if not is_here(one))
    if gone:
        text = Message(
            "Parts of the robot on this computer listen on {addresses}, which it does not have: "
            "they cannot be reached.",
            addresses=", ".join(gone),
        )
        yield Finding.of("addresses", text, faults.ADDRESS, advice=machine.restart(CHECK_LINK))


def _listening(machine: Machine, address: str) -> Finding:
    two, own = [machine.environment.get(name, "") for name in ADDRESSES], machine.own_addresses
    fault, advice = faults.ADDRESS, AS_SERVICES if machine.settings else None
    if any(two) and not own:
        text = Message(
            "This computer has none of the addresses {configured}.",
            configured=", ".join(one or "?" for one in two),
        )
        advice = None
    elif any(two) and address not in own:
        text = Message(
            "ROS listens on {address}, but this computer is {own}.",
            address=address or "*",
            own=own[0],
        )
    elif any(two) or address == "localhost" or address.startswith("127."):
        return Finding.of("addresses", Message("ROS listens on {address}.", address=address))
    elif address and not is_here(address):
        text = Message(
            "ROS_IP or ROS_HOSTNAME is {address}, which is no address of this computer: what is "
            "started here cannot be reached.",
            address=address,
        )
    else:
        text = Message(
            "ROS listens on {address}: everybody in the network can move the robot.",
            address=address or "*",
        )
        fault = fault.as_warning()
    return Finding.of("addresses", text, fault, advice=advice)


def check_firewall(machine: Machine) -> Iterator[Finding]:
    """Judge whether the rules are loaded that keep foreign computers out."""
    if not any(machine.environment.get(name) for name in ADDRESSES):
        return  # where ROS listens is a finding of its own
    values = {"where": printable(machine.settings or ""), "program": FIREWALL}
    text = Message("No firewall: everybody in the network can move the robot.")
    if machine.environment.get("GPR20_FIREWALL") == "off":
        advice = Message("Write GPR20_FIREWALL=on into {where}. Run: sudo {program} load", **values)
        yield Finding.of("firewall", text, faults.FIREWALL, advice=advice)
    elif os.geteuid() != 0:
        only = Message("Only root may see whether the firewall is loaded.")
        command = "sudo gpr20-run doctor" if machine.settings else "sudo nft list tables"
        remedy = Message("Run: {command}", command=command)
        yield Finding("firewall", Level.UNKNOWN, only, remedy)
    elif TABLE in answer_of(TABLES):
        yield Finding.of("firewall", Message("The rules of the firewall are loaded."))
    else:
        load = Message("Run: sudo {program} load", **values) if machine.settings else None
        yield Finding.of("firewall", text, faults.FIREWALL, advice=load)
