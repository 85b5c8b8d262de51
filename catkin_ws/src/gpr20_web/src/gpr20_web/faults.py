"""What can go wrong on the page at a distance, for programs."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

NOT_LOGGED_IN = Fault("web.not_logged_in", Message("Log in."))
WRONG_LOGIN = Fault("web.wrong_login", Message("Check name and password, then log in again."))
TOO_MANY_LOGINS = Fault(
    "web.too_many_logins",
    Message("Wait as long as it says, then log in with the right password."),
)
NOT_ALLOWED = Fault(
    "web.not_allowed", Message("Ask a person whose account may do it, or the administrator.")
)
NOT_ARMED = Fault(
    "web.not_armed",
    Message("Ask the person at the robot to allow remote control on the touchscreen."),
)
NOT_IN_CONTROL = Fault("web.not_in_control", Message("Take control first."))
NOT_NOW = Fault("web.not_now", Message("Look at the state of the robot, then decide."))
BAD_REQUEST = Fault("web.bad_request", Message("Load the page again."))
NOT_FOUND = Fault("web.not_found", Message("Load the page again."))
ACCOUNT = Fault("web.account", remedies.CORRECT_VALUE)
ACCOUNTS_FILE = Fault(
    "web.accounts_file",
    Message("Check the disk, then the file; restore it from a backup or make the accounts again."),
)
FOLDER = Fault(
    "web.folder",
    Message("Check who may write the folder of the page, or set another folder in web.yaml."),
)
CERTIFICATE = Fault(
    "web.certificate",
    Message("Check that openssl is installed and that the folder of the page can be written."),
)
PORT_TAKEN = Fault(
    "web.port_taken",
    Message("Correct address or port in web.yaml, or end the program that uses the port."),
)
BUSY = Fault("web.busy", remedies.TRY_LATER)
TOO_MANY_PAGES = Fault("web.too_many_pages", Message("Close a page, then load this one again."))
NOT_SENT = Fault(
    "web.not_sent",
    Message("Check disk and network of the computer with the page, then its log."),
    Severity.WARNING,
)
AUDIT_FILE = Fault("web.audit_file", Message("Check the disk, then the file."))
NOTIFY = Fault(
    "web.notify",
    Message("Correct notify.txt in the folder of the page, then start the page again."),
    Severity.WARNING,
)
BUNDLE = Fault("web.bundle", Message("Make it on the robot: rosrun gpr20_doctor doctor --bundle."))
