# Sourced by installation.sh: logs, clock, firewall and services, and their removal.
# shellcheck shell=bash
# shellcheck disable=SC2154  # the variables of installation.sh

UNITS=/etc/systemd/system

ensure_logs() {
    ensure_folder /var/log/gpr20 "$user"
    ensure_file /etc/tmpfiles.d/gpr20.conf "$(template etc/tmpfiles.conf)"
    ensure_file /etc/logrotate.d/gpr20 "$(template etc/logrotate.conf)"
    ensure_file /etc/systemd/journald.conf.d/gpr20.conf "$(template etc/journald.conf)"
}

# ensure_clock server|robot
ensure_clock() {
    local file=/etc/chrony/conf.d/gpr20.conf main=/etc/chrony/chrony.conf
    ensure_file "$file" "$(template "etc/chrony_$1.conf")"
    # The chrony of Ubuntu 20.04 does not read this folder by itself.
    if [ -f "$root$main" ] && ! grep -q '^confdir /etc/chrony/conf.d' "$root$main"; then
        ensure_block "$main" "include $file"
    fi
}

ensure_firewall() {
    local admin text
    if [ "$firewall" = no ]; then
        if [ -e "$root/etc/gpr20/firewall.nft" ]; then
            echo "left: the firewall of an earlier run; without it: systemctl disable --now" \
                "gpr20-firewall"
        elif [ "$one_machine" = no ]; then
            echo "left: no firewall (--no-firewall)"
        fi
        return
    fi
    check_remote_shell
    text="$(template etc/firewall.nft)"
    for admin in "${admins[@]}"; do
        text+=$'\n'"add rule inet gpr20 input ip saddr $admin tcp dport 22 accept"
    done
    ensure_file /etc/gpr20/firewall.nft "$text"
    ensure_unit gpr20-firewall
}

# A remote shell that installs the firewall must be able to come back.
check_remote_shell() {
    local client
    client="$(remote_shell_client $$)"
    [ -n "$client" ] || return 0
    case "$client" in *:*)
        fail "this shell comes from $client, and the firewall closes IPv6; connect to an IPv4" \
            "address of this machine, or install without the firewall (--no-firewall)" ;;
    esac
    /usr/bin/python3 - "$client" "$robot" "$server" "${admins[@]}" <<'END' ||
import ipaddress, sys
client = ipaddress.ip_address(sys.argv[1])
sys.exit(not any(client in ipaddress.ip_network(one, strict=False) for one in sys.argv[2:]))
END
        fail "this shell comes from $client, which the firewall would lock out;" \
            "add --admin $client, or install without the firewall (--no-firewall)"
}

# remote_shell_client PID: where the ssh session of a process or of its parents comes from.
remote_shell_client() {
    local pid="$1" client
    if ! is_real; then return; fi
    while [ "${pid:-0}" -gt 1 ]; do
        client="$(tr '\0' '\n' 2>/dev/null <"/proc/$pid/environ" |
            sed -n 's/^SSH_CONNECTION=\([^ ]*\) .*/\1/p')"
        if [ -n "$client" ]; then echo "$client"; return; fi
        pid="$(awk '$1 == "PPid:" { print $2 }' "/proc/$pid/status" 2>/dev/null)"
    done
}

# ensure_unit NAME: write it and let it start at boot.
ensure_unit() {
    ensure_file "$UNITS/$1.service" "$(template "systemd/$1.service")"
    ensure_link "$UNITS/multi-user.target.wants/$1.service" "../$1.service"
    units+=("$1")
}
units=()

# ensure_spi: the SPI bus in the Raspberry Pi's config.txt.
ensure_spi() {
    local path
    for path in /boot/firmware/config.txt /boot/config.txt; do
        [ -f "$root$path" ] || continue
        if spi_is_on "$root$path"; then there "SPI in $path"; return; fi
        ensure_block "$path" $'[all]\ndtparam=spi=on'
        reboot=yes
        return
    done
    echo "left: no /boot/firmware/config.txt and no /boot/config.txt; switch SPI on as this" \
        "computer needs it"
}
reboot=no

# The last setting counts, of the sections that are for every Raspberry Pi or for the Pi 4.
spi_is_on() {
    awk '{ sub(/#.*/, ""); gsub(/[ \t\r]/, "") }
        /^\[/ { other = $0 != "[all]" && $0 != "[pi4]"; next }
        !other && /^(dtparam|device_tree_param)=/ {
            sub(/^[^=]*=/, "")
            count = split($0, parts, ",")
            for (i = 1; i <= count; i++) {
                if (parts[i] ~ /^spi(=(on|true|1|yes))?$/) on = 1
                else if (parts[i] ~ /^spi=/) on = 0
            }
        }
        END { exit !on }' "$1"
}

systemd_runs() { is_real && [ -d /run/systemd/system ]; }

was_written() {
    local path
    for path in ${written[@]+"${written[@]}"}; do case "$path" in $1) return 0 ;; esac; done
    return 1
}

# Let what runs already use what was written, and start what does not run.
activate() {
    local unit
    if ! systemd_runs; then
        echo "not here: systemd does not run; the services start at the next boot"
        return
    fi
    if was_written '/etc/udev/*'; then step "read the udev rules" read_udev_rules; fi
    if was_written "$UNITS/*"; then step "read the units" systemctl daemon-reload; fi
    if was_written '/etc/systemd/journald*'; then
        step "restart the journal" systemctl restart systemd-journald
    fi
    if was_written '/etc/chrony/*'; then step "restart chrony" systemctl restart chrony; fi
    if was_written /etc/gpr20/firewall.nft && systemctl is-active -q gpr20-firewall; then
        step "load the firewall" systemctl reload gpr20-firewall
    fi
    if [ "$reboot" = yes ]; then
        echo "reboot now: SPI is switched on at the next boot, and the services start then"
        return
    fi
    for unit in "${units[@]}"; do activate_unit "$unit"; done
}

read_udev_rules() { udevadm control --reload && udevadm trigger; }

activate_unit() {
    if ! systemctl is-active -q "$1"; then
        step "start $1" systemctl start --no-block "$1"
    elif [ "$1" != gpr20-firewall ] &&
        { was_written "$UNITS/$1.service" || was_written "$SETTINGS"; }; then
        echo "left: $1 runs with its former settings; when no survey runs: systemctl restart $1"
    else
        there "$1 runs"
    fi
}

finish() {
    if [ "$dry" = yes ]; then
        echo "$changes changes would be made; nothing was changed"
    else
        echo "$changes changes made"
    fi
}

# diagnose: what the doctor finds while the services start, with their user and limits.
diagnose() {
    if [ "$dry" = yes ]; then return; fi
    if ! systemd_runs || [ "$reboot" = yes ]; then
        echo "when the services run: rosrun gpr20_doctor doctor (docs/install.md) says what is" \
            "wrong"
        return
    fi
    echo "rosrun gpr20_doctor doctor:"
    systemd-run --quiet --wait --pipe --collect --uid="$user" \
        --setenv=ROS_LOG_DIR=/var/log/gpr20 -p EnvironmentFile="$SETTINGS" \
        -p LimitRTPRIO=45 -p LimitMEMLOCK=infinity "$DEPLOY/run.sh" doctor ||
        echo "left: what the doctor names above; the installation itself is complete"
}

# --- uninstall ---

uninstall() {
    local records line kind path value unit
    if [ ! -f "$root$MANIFEST" ]; then echo "already gone: nothing is installed"; return; fi
    mapfile -t records < <(tac "$root$MANIFEST" | awk -F '\t' '!seen[$1, $2]++')
    if systemd_runs; then
        for unit in gpr20-window gpr20-robot gpr20-server gpr20-firewall; do
            if systemctl is-active -q "$unit"; then step "stop $unit" systemctl stop "$unit"; fi
        done
    fi
    for line in "${records[@]}"; do
        IFS=$'\t' read -r kind path value <<<"$line"
        case "$kind" in
            file) remove_file "$path" "$value" ;;
            link) remove_link "$path" "$value" ;;
            block) remove_block "$path" ;;
            member) remove_member "$path" "$value" ;;
        esac
    done
    step "delete $MANIFEST" rm "$root$MANIFEST"
    for line in "${records[@]}"; do
        IFS=$'\t' read -r kind path value <<<"$line"
        if [ "$kind" = folder ]; then remove_folder "$path"; fi
    done
    for line in "${records[@]}"; do
        IFS=$'\t' read -r kind path value <<<"$line"
        case "$kind" in
            user) remove_user "$path" ;;
            group) remove_group "$path" ;;
        esac
    done
    echo "left: Debian packages, $GPR20_VENV and the build, which belong to the checkout"
    if systemd_runs; then
        step "read what is left" systemctl daemon-reload
        step "restart the journal and chrony" systemctl try-restart systemd-journald chrony
    fi
}

remove_file() {
    if [ ! -e "$root$1" ]; then gone "$1"; return; fi
    if [ "$(sum_of "$root$1")" != "$2" ]; then echo "left: $1, changed by hand"; return; fi
    step "delete $1" rm "$root$1"
}

remove_link() {
    if [ "$(readlink "$root$1" || true)" != "$2" ]; then gone "$1"; return; fi
    step "delete $1" rm "$root$1"
}

remove_block() {
    if ! grep -qsxF -e "$BLOCK_BEGIN" -e "$BLOCK_JOINED" "$root$1"; then
        gone "the lines in $1"
        return
    fi
    step "remove the lines from $1" cut_block "$1"
}

# Byte for byte what was there before, and what was added since.
cut_block() {
    /usr/bin/python3 - "$root$1" "$BLOCK_BEGIN" "$BLOCK_JOINED" "$BLOCK_END" <<'END' |
import pathlib, sys
text = pathlib.Path(sys.argv[1]).read_bytes()
begin, joined, end = (one.encode() + b"\n" for one in sys.argv[2:])
line = joined if joined in text else begin
before, _, rest = text.partition(line)
_, _, after = rest.partition(end)
if line == joined and not after:
    before = before[:-1]
sys.stdout.buffer.write(before + after)
END
        write_file "$root$1" "$(stat -c %a "$root$1")"
}

remove_member() {
    if ! is_real; then return; fi
    if ! id -nG "$2" 2>/dev/null | tr ' ' '\n' | grep -qxF "$1"; then
        gone "user $2 in group $1"
        return
    fi
    step "take user $2 out of group $1" take_out "$1" "$2"
}

take_out() { gpasswd -d "$2" "$1" >/dev/null; }

remove_folder() {
    if [ "$dry" = yes ]; then
        echo "would do: delete $1, if nothing is left in it"
    elif rmdir "$root$1" 2>/dev/null; then
        echo "done: delete $1"
    elif [ -d "$root$1" ]; then
        echo "left: $1, which is not empty: $(ls -A "$root$1" | head -n 5 | tr '\n' ' ')"
    fi
}

# What is left belongs to somebody.
remove_user() {
    if [ "$dry" = no ] && is_real && { [ -e "$DEFAULT_HOME" ] || [ -e /var/log/gpr20 ]; }; then
        echo "left: user $1, the owner of what is left"
        return
    fi
    system_step "delete the user $1" userdel "$1"
}

remove_group() {
    if ! getent group "$1" >/dev/null; then gone "group $1"; return; fi
    if [ -n "$(getent group "$1" | cut -d : -f 4)" ] ||
        getent passwd | cut -d : -f 4 | grep -qx "$(getent group "$1" | cut -d : -f 3)"; then
        echo "left: group $1, which has members"
        return
    fi
    system_step "delete the group $1" groupdel "$1"
}
