"""The commands of docs/install.md."""

from __future__ import annotations

import re

from user_shell import ROOT

PAGE = ROOT / "docs/install.md"


def code_blocks(heading):
    """Return the code blocks of the section with a heading, up to the next heading."""
    text = PAGE.read_text(encoding="utf-8")
    section = re.search(rf"^#+ {re.escape(heading)}\n(.*?)(?=^#+ |\Z)", text, re.M | re.S)
    assert section, f"the page has no section {heading}"
    return re.findall(r"^```\w*\n(.*?)^```$", section.group(1), re.M | re.S)


def two_machine_commands():
    """Return the code blocks that set up two machines: both, the server, the robot."""
    both, server, robot = code_blocks("Two machines")
    return both, server.strip(), robot.strip()


def addresses():
    exported = dict(re.findall(r"(GPR20_\w+)=(\S+)", two_machine_commands()[0]))
    return exported["GPR20_ROBOT"], exported["GPR20_SERVER"]


def firewall():
    """Return the commands of the firewall, one a line."""
    (commands,) = code_blocks("Firewall")
    return commands.splitlines()


def remote_shell_rule(address):
    """Return the command that admits a remote shell from an address."""
    (rule,) = re.findall(r"`(nft add rule [^`]*YOUR_ADDRESS[^`]*)`", PAGE.read_text("utf-8"))
    return rule.replace("YOUR_ADDRESS", address)
