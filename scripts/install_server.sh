#!/usr/bin/env bash
# Make this computer the PC of the robot: software, user, clock, firewall and the service with the
# ROS master, the VNA, the storage and the survey. Safe to run again; see docs/install.md.
#   sudo scripts/install_server.sh --robot ADDRESS --server ADDRESS --admin ADDRESS
#   sudo scripts/install_server.sh --uninstall      remove what it installed; data stay
# Options:
#   --robot, --server ADDRESS   the robot and this computer, on their own link
#   --admin ADDRESS             address or network allowed to use ssh; may be repeated
#   --no-firewall               no firewall: anyone who reaches this computer can move the robot
#   --user NAME                 run as this existing user instead of a new user gpr20
#   --data FOLDER               where surveys are kept (default /var/lib/gpr20/surveys)
#   --dry-run                   print every change, make none
#   --root FOLDER               write below this folder; run nothing
set -euo pipefail
# shellcheck source=scripts/steps/installation.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/installation.sh"

parse_arguments "" "$@"
check_system
check_role server
if [ "$uninstall" = yes ]; then
    uninstall
    finish
    exit
fi
packages=(chrony logrotate)
[ "$firewall" = no ] || packages+=(nftables)

ensure_packages "${packages[@]}"
ensure_software
begin_records server
ensure_user
ensure_settings
ensure_data
ensure_configuration
ensure_key
ensure_logs
ensure_clock server
ensure_firewall
ensure_unit gpr20-server
activate
finish
diagnose
