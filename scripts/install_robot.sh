#!/usr/bin/env bash
# Make this computer, a Raspberry Pi, the robot's: software, user, pins, SPI, real-time limits,
# clock, firewall and services that start at boot. Safe to run again; see docs/install.md.
#   sudo scripts/install_robot.sh --robot ADDRESS --server ADDRESS --admin ADDRESS
#   sudo scripts/install_robot.sh --one-machine     this computer does the PC's part as well
#   sudo scripts/install_robot.sh --uninstall       remove what it installed; data stay
# Options:
#   --robot, --server ADDRESS   this computer and the PC, on their own link
#   --admin ADDRESS             address or network allowed to use ssh; may be repeated
#   --no-firewall               no firewall: anyone who reaches this computer can move the robot
#   --no-window                 no window on this computer's screen
#   --user NAME                 run as this existing user instead of a new user gpr20
#   --data FOLDER               where surveys are kept (default /var/lib/gpr20/surveys)
#   --dry-run                   print every change, make none
#   --root FOLDER               write below this folder; run nothing
set -euo pipefail
# shellcheck source=scripts/steps/installation.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps/installation.sh"

parse_arguments "--one-machine --no-window" "$@"
check_system
check_role robot
if [ "$uninstall" = yes ]; then
    uninstall
    finish
    exit
fi
packages=(logrotate) setup=(--robot)
# For the template of gpr20-robot.service.
part=robot parts="axes and height sensor"
if [ "$one_machine" = yes ]; then
    part=survey parts="the whole system on one machine" setup=(--robot --analysis)
else
    packages+=(chrony)
fi
[ "$firewall" = no ] || packages+=(nftables)
if [ "$window" = yes ]; then
    if [ -L "$root/etc/systemd/system/display-manager.service" ]; then
        fail "a desktop has this computer's screen. Let it boot to the console (sudo systemctl" \
            "disable display-manager, then reboot), or install with --no-window"
    fi
    packages+=(dbus libpam-systemd openbox xinit xserver-xorg-core xserver-xorg-input-libinput)
fi

ensure_packages "${packages[@]}"
ensure_software "${setup[@]}"
begin_records robot
ensure_user gpio spi video
ensure_file /etc/udev/rules.d/60-gpr20.rules "$(template etc/udev.rules)"
ensure_spi
ensure_file /etc/security/limits.d/gpr20.conf "$(template etc/limits.conf)"
ensure_settings
ensure_data
ensure_configuration
[ "$one_machine" = no ] || ensure_key
ensure_logs
[ "$one_machine" = yes ] || ensure_clock robot
ensure_firewall
ensure_unit gpr20-robot
[ "$window" = no ] || ensure_unit gpr20-window
activate
finish
diagnose
