# Sourced by install_robot.sh and install_server.sh: what both do, and the steps they are made of.
# Every step prints one line: "done", "already there", "already gone", "would do" (--dry-run),
# "left", "not here" or "not with --root". What is installed is recorded in /etc/gpr20/installed,
# by which --uninstall removes it.
# shellcheck shell=bash
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/../environment.sh"
# shellcheck source=scripts/steps/installation_steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/installation_steps.sh"
# shellcheck source=scripts/steps/installation_services.sh
source "$(dirname "${BASH_SOURCE[0]}")/installation_services.sh"

SCRIPT="$(basename "$0")"
DEPLOY="$GPR20_ROOT/deploy"
MANIFEST=/etc/gpr20/installed
SETTINGS=/etc/gpr20/environment
DEFAULT_USER=gpr20
DEFAULT_HOME=/var/lib/gpr20
BLOCK_BEGIN="# gpr20 begin: written by scripts/$SCRIPT, which removes it with --uninstall"
BLOCK_END="# gpr20 end"
# Before the block, if the file did not end with a line break.
BLOCK_JOINED="$BLOCK_BEGIN (joined)"

robot='' server='' admins=() firewall=yes user="$DEFAULT_USER" data='' root='' dry=no uninstall=no
one_machine=no window=yes

fail() {
    echo "$SCRIPT: $*" >&2
    exit 1
}

# --- arguments ---

usage() {
    sed -n '2,/^set -/{/^# \{0,1\}/!d;s/^# \{0,1\}//;p}' "$0"
}

# parse_arguments ALLOWED ARGUMENT...: ALLOWED lists further options of the script.
parse_arguments() {
    local allowed=" $1 " option
    shift
    while [ $# -gt 0 ]; do
        option="$1"
        shift
        case "$option" in
            --robot | --server | --admin | --user | --data | --root)
                [ $# -gt 0 ] || fail "$option needs a value"
                case "$option" in
                    --robot) robot="$1" ;;
                    --server) server="$1" ;;
                    --admin) admins+=("$1") ;;
                    --user) user="$1" ;;
                    --data) data="$1" ;;
                    --root) root="$(realpath -m "$1")" ;;
                esac
                shift
                ;;
            --no-firewall) firewall=no ;;
            --dry-run) dry=yes ;;
            --uninstall) uninstall=yes ;;
            -h | --help) usage; exit 0 ;;
            *)
                case "$allowed" in *" $option "*) ;; *)
                    fail "unknown argument '$option'; see $SCRIPT --help" ;;
                esac
                [ "$option" != --one-machine ] || one_machine=yes
                [ "$option" != --no-window ] || window=no
                ;;
        esac
    done
    if [ "$root" = / ]; then root=''; fi
    if [ "$uninstall" = yes ]; then return; fi
    [ "$one_machine" = no ] || firewall=no
    check_addresses
    if ! [[ "$user" =~ ^[a-z_][a-z0-9_-]*$ ]]; then fail "'$user' is not the name of a user"; fi
    # systemd and the shell read it without quotes.
    case "$data" in *[[:space:]\"\'\\\$\`\&\;\|\<\>\(\)\#%]* | [!/]*)
        fail "--data '$data' is not an absolute path without spaces, quotes or one of" \
            "\\ \$ & ; # %" ;;
    esac
}

is_address() {
    local octet='(25[0-5]|2[0-4][0-9]|1[0-9][0-9]|[1-9]?[0-9])'
    [[ "$1" =~ ^($octet\.){3}$octet$ ]]
}

check_addresses() {
    local admin
    if [ "$one_machine" = yes ]; then
        [ -z "$robot$server" ] || fail "--one-machine needs no --robot and no --server"
        return
    fi
    is_address "$robot" || fail "--robot '$robot' is not an IPv4 address such as 10.20.0.1"
    is_address "$server" || fail "--server '$server' is not an IPv4 address such as 10.20.0.2"
    [ "$robot" != "$server" ] || fail "--robot and --server are both $robot; they must differ"
    for admin in ${admins[@]+"${admins[@]}"}; do
        is_address "${admin%%/*}" && [[ "$admin" =~ ^[^/]*(/([89]|[12][0-9]|3[0-2]))?$ ]] ||
            fail "--admin '$admin' is not an IPv4 address or network such as 192.168.1.0/24"
    done
    if [ "$firewall" = yes ] && [ ${#admins[@]} -eq 0 ]; then
        fail "the firewall would admit a remote shell only from the other machine. Name the" \
            "address you administer this machine from (--admin ADDRESS), or install without" \
            "the firewall (--no-firewall)"
    fi
}

# --- checks ---

check_system() {
    local id version
    if is_real && [ "$dry" = no ] && [ "$(id -u)" -ne 0 ]; then
        fail "run it as root: sudo scripts/$SCRIPT ..."
    fi
    [ -r "$root/etc/os-release" ] || fail "$root/etc/os-release is missing; is this a system?"
    id="$(sed -n 's/^ID="\{0,1\}\([^"]*\)"\{0,1\}$/\1/p' "$root/etc/os-release")"
    version="$(sed -n 's/^VERSION_ID="\{0,1\}\([^"]*\)"\{0,1\}$/\1/p' "$root/etc/os-release")"
    case "$id $version" in
        'debian 12' | 'ubuntu 20.04') ;;
        *) fail "this is '$id $version'; supported are Debian 12 and Ubuntu 20.04, 64-bit" ;;
    esac
    [ -x "$root/lib/systemd/systemd" ] || fail "systemd is missing; it starts the services"
    if [ "$uninstall" = yes ]; then return; fi
    check_checkout
    # Now, not after minutes of installing.
    if [ "$firewall" = yes ] && [ -x /usr/bin/python3 ]; then check_remote_shell; fi
}

# The services run as another user, from this checkout.
check_checkout() {
    local folder="$GPR20_ROOT"
    case "$folder" in *[[:space:]%\$\\]*) fail "the path '$folder' has a space or one of % \$ \\" ;;
    esac
    is_real && [ "$user" = "$DEFAULT_USER" ] || return 0
    while [ "$folder" != / ]; do
        case "$(stat -c %A "$folder")" in
            *x | *t) ;;
            *) fail "user $user cannot enter $folder; put the checkout in /opt/gpr20" ;;
        esac
        folder="$(dirname "$folder")"
    done
}

# One machine has one role; other arguments of the same role change it.
check_role() {
    local found
    found="$(recorded role)"
    [ -z "$found" ] || [ "$found" = "$1" ] ||
        fail "this machine is installed as '$found', not as '$1'; uninstall that first"
}

# --- packages, users, settings ---

# ensure_packages PACKAGE...
ensure_packages() {
    local missing=() package
    if ! is_real; then echo "not with --root: install the packages $*"; return; fi
    for package in "$@"; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            missing+=("$package")
    done
    if [ ${#missing[@]} -eq 0 ]; then there "the packages $*"; return; fi
    step "install the packages ${missing[*]}" install_packages "${missing[@]}"
}

install_packages() {
    local printed
    printed="$(mktemp)"
    if ! { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 \
        install -y --no-install-recommends "$@"; } >"$printed" 2>&1; then
        tail -n 15 "$printed" >&2
        rm "$printed"
        fail "apt-get did not install $*; the lines above say why"
    fi
    rm "$printed"
}

# ensure_software ARGUMENT...: what scripts/setup.sh installs with these arguments.
ensure_software() {
    local words="the software: scripts/setup.sh${*:+ $*}"
    if ! is_real; then echo "not with --root: $words"; return; fi
    if "$GPR20_ROOT/scripts/setup.sh" "$@" --check >/dev/null 2>&1; then there "$words"; return; fi
    step "$words" set_up "$@"
}

set_up() {
    "$GPR20_ROOT/scripts/setup.sh" "$@"
    # The owner of the checkout can run setup.sh again without root.
    chown -R --reference "$GPR20_ROOT" "$GPR20_VENV" "$GPR20_WORKSPACE"
}

# ensure_user GROUP...: the user of the services, and the groups it is in.
ensure_user() {
    local group
    for group in gpr20 "$@"; do ensure_group "$group"; done
    if [ "$user" != "$DEFAULT_USER" ]; then
        ! is_real || getent passwd "$user" >/dev/null || fail "there is no user $user (--user)"
    elif grep -q "^$user:" "$root/etc/passwd" 2>/dev/null; then
        there "user $user"
    else
        system_step "make the user $user, who cannot log in" make_user
    fi
    # Its home, for the counted steps of the antennas, the settings of the window and the surveys.
    if [ "$user" = "$DEFAULT_USER" ]; then
        ensure_folder "$DEFAULT_HOME" "$user"
        # git describes the checkout of another owner only if it is listed as safe.
        ensure_file "$DEFAULT_HOME/.gitconfig" "[safe]
	directory = $GPR20_ROOT"
    fi
    for group in gpr20 "$@"; do ensure_member "$group"; done
}

make_user() {
    useradd --system --gid gpr20 --home-dir "$DEFAULT_HOME" --no-create-home \
        --shell /usr/sbin/nologin "$user"
    record user "$user"
}

ensure_group() {
    if grep -q "^$1:" "$root/etc/group" 2>/dev/null; then there "group $1"; return; fi
    system_step "make the group $1" make_group "$1"
}

make_group() {
    groupadd --system "$1"
    record group "$1"
}

ensure_member() {
    if is_real && id -nG "$user" 2>/dev/null | tr ' ' '\n' | grep -qxF "$1"; then
        there "user $user in group $1"
        return
    fi
    system_step "add user $user to group $1" make_member "$1"
}

make_member() {
    usermod -a -G "$1" "$user"
    record member "$1" "$user"
}

# ensure_settings: /etc/gpr20/environment; of one that exists, only these values are changed.
ensure_settings() {
    local file="$root$SETTINGS" text key
    declare -A values=([GPR20_ROBOT]="$robot" [GPR20_SERVER]="$server")
    [ -z "$data" ] || values[GPR20_DATA]="$data"
    if [ ! -e "$file" ]; then
        data="${data:-$DEFAULT_HOME/surveys}"
        ensure_file "$SETTINGS" "$(template etc/environment)"
        return
    fi
    text="$(cat "$file")"
    for key in "${!values[@]}"; do
        text="$(awk -v key="$key" -v value="${values[$key]}" '
            index($0, key "=") == 1 { if (!found) print key "=" value; found = 1; next }
            { print }
            END { if (!found) print key "=" value }' <<<"$text")"
    done
    data="$(sed -n 's/^GPR20_DATA=//p' <<<"$text" | tail -n 1)"
    if [ "$text" = "$(cat "$file")" ]; then there "$SETTINGS"; return; fi
    step "set ${!values[*]} in $SETTINGS" change_settings "$text"
    written+=("$SETTINGS")
}

# One that was changed by hand before stays one, which --uninstall leaves.
change_settings() {
    local own=no
    [ "$(sum_of "$root$SETTINGS")" != "$(recorded file "$SETTINGS")" ] || own=yes
    printf '%s\n' "$1" | write_file "$root$SETTINGS" 644
    [ "$own" = no ] || record file "$SETTINGS" "$(sum_of "$root$SETTINGS")"
}

configuration_folder() {
    local folder
    folder="$(sed -n 's/^GPR20_CONFIG=//p' "$root$SETTINGS" 2>/dev/null | tail -n 1 || true)"
    echo "${folder:-/etc/gpr20/robot}"
}

# ensure_data: the folder of the surveys. One that was made before and is gone is on a disk that is
# not mounted.
ensure_data() {
    if [ ! -d "$root$data" ] && grep -qsxF $'folder\t'"$data"$'\t' "$root$MANIFEST"; then
        echo "left: the folder $data is gone; mount its disk"
        return
    fi
    ensure_folder "$data" "$user"
}

ensure_configuration() {
    local folder
    folder="$(configuration_folder)"
    if [ -d "$root$folder" ]; then there "the robot's configuration $folder"; return; fi
    system_step "write the robot's configuration $folder" make_configuration "$folder"
}

make_configuration() {
    robot_config create "$1" >/dev/null ||
        fail "the robot's configuration $1 was not written; the lines above say why"
}

robot_config() {
    local scratch status=0
    # ROS would leave a cache in the home of root.
    scratch="$(mktemp -d)"
    (
        export ROS_HOME="$scratch"
        gpr20_use_workspace
        rosrun gpr20_launch robot_config "$@"
    ) || status=$?
    rm -r "$scratch"
    return "$status"
}

# ensure_key: the key that signs surveys, where they are stored. One that the configuration names,
# or an empty name there, which means that surveys are not signed, stays.
ensure_key() {
    local folder
    folder="$(configuration_folder)"
    if grep -qs '^signing_key:' "$root$folder/storage.yaml"; then
        there "the key that signs surveys, or that there is none"
        return
    fi
    system_step "make the key that signs surveys, $folder/signing_key" make_key "$folder"
}

make_key() {
    robot_config key "$1" || fail "the key $1/signing_key was not made; the lines above say why"
    # Only the storage reads it.
    chown "$user:" "$1/signing_key" "$1/signing_key.pub"
}
