# Sourced by installation.sh: the steps of an installation and the record of them.
# A record is one line "KIND, PATH, VALUE" of /etc/gpr20/installed, separated by tabs.
# shellcheck shell=bash
# shellcheck disable=SC2154  # the variables of installation.sh

changes=0
# Files that were written or changed, for what must read them again.
written=()
# Folders that were made, or would be.
declare -A planned=()

# step WORDS COMMAND...: run a command that changes something, or say that it would be run.
step() {
    changes=$((changes + 1))
    if [ "$dry" = yes ]; then echo "would do: $1"; return; fi
    "${@:2}"
    echo "done: $1"
}

there() { echo "already there: $1"; }

gone() { echo "already gone: $1"; }

# is_real: whether this changes the running system, not a folder below --root.
is_real() { [ -z "$root" ]; }

# system_step WORDS COMMAND...: the same for what acts on the running system only.
system_step() {
    if is_real; then step "$@"; else echo "not with --root: $1"; fi
}

# recorded KIND [PATH]: the value of the last such record (without PATH: its path).
recorded() {
    [ -f "$root$MANIFEST" ] || return 0
    awk -F '\t' -v kind="$1" -v path="${2-}" \
        '$1 == kind && (path == "" || $2 == path) { found = path == "" ? $2 : $3 }
        END { print found }' "$root$MANIFEST"
}

# record KIND PATH [VALUE]: the last of a KIND and PATH counts.
record() { printf '%s\t%s\t%s\n' "$1" "$2" "${3-}" >>"$root$MANIFEST"; }

# begin_records ROLE: what this machine is; everything that follows is recorded.
begin_records() {
    ensure_folder "$(dirname "$MANIFEST")"
    [ "$dry" = yes ] || [ -n "$(recorded role)" ] || record role "$1"
}

# write_file FILE MODE: whole or not at all, also after a power cut.
write_file() {
    cat >"$1.gpr20-new"
    chmod "$2" "$1.gpr20-new"
    if is_real; then sync "$1.gpr20-new"; fi
    mv -f "$1.gpr20-new" "$1"
}

sum_of() { sha256sum <"$1" | cut -d ' ' -f 1; }

# ensure_folder PATH [USER]: the folder and those above it, of root or of a user.
ensure_folder() {
    if [ -d "$root$1" ] || [ -n "${planned[$1]-}" ]; then return; fi
    [ "$(dirname "$1")" = / ] || ensure_folder "$(dirname "$1")"
    planned[$1]=yes
    step "make the folder $1" make_folder "$@"
}

make_folder() {
    mkdir -m 755 "$root$1"
    if is_real && [ -n "${2-}" ]; then chown "$2:" "$1"; fi
    # The first of all is the folder of the records.
    record folder "$1"
}

# ensure_file PATH TEXT: a file of this installation. One that was changed by hand stays.
ensure_file() {
    local path="$1" file="$root$1"
    ensure_folder "$(dirname "$path")"
    if [ -f "$file" ] && [ "$2" = "$(<"$file")" ]; then
        there "$path"
        # A run that was interrupted may have written it without a record.
        [ "$dry" = yes ] || [ -n "$(recorded file "$path")" ] ||
            record file "$path" "$(sum_of "$file")"
        return
    fi
    if [ -e "$file" ] && [ "$(sum_of "$file")" != "$(recorded file "$path")" ]; then
        echo "left: $path was written or changed by hand; remove it to get the new one"
        return
    fi
    step "write $path" put_file "$path" "$2"
    written+=("$path")
}

put_file() {
    printf '%s\n' "$2" | write_file "$root$1" 644
    record file "$1" "$(sum_of "$root$1")"
}

# ensure_link PATH TARGET
ensure_link() {
    ensure_folder "$(dirname "$1")"
    if [ "$(readlink "$root$1" || true)" = "$2" ]; then there "$1"; return; fi
    [ ! -e "$root$1" ] || fail "$1 exists and is not a link to $2"
    step "link $1" put_link "$@"
}

put_link() {
    ln -sfn "$2" "$root$1"
    record link "$1" "$2"
}

# ensure_block PATH TEXT: marked lines at the end of a file that others own.
ensure_block() {
    if grep -qsxF -e "$BLOCK_BEGIN" -e "$BLOCK_JOINED" "$root$1"; then
        there "lines in $1"
        return
    fi
    step "add to $1: ${2//$'\n'/; }" put_block "$@"
    written+=("$1")
}

put_block() {
    local begin="$BLOCK_BEGIN" join=''
    if [ -s "$root$1" ] && [ -n "$(tail -c 1 "$root$1")" ]; then
        begin="$BLOCK_JOINED" join=$'\n'
    fi
    record block "$1"
    { cat "$root$1"; printf '%s%s\n%s\n%s\n' "$join" "$begin" "$2" "$BLOCK_END"; } |
        write_file "$root$1" "$(stat -c %a "$root$1")"
}

configuration_folder() {
    local folder
    folder="$(sed -n 's/^GPR20_CONFIG=//p' "$root$SETTINGS" 2>/dev/null | tail -n 1 || true)"
    echo "${folder:-/etc/gpr20/robot}"
}

# used_data: the folder of the surveys; that of storage.yaml counts before GPR20_DATA.
used_data() {
    local file configured
    file="$root$(configuration_folder)/storage.yaml"
    configured="$(sed -n "s/^data:[[:space:]]*[\"']\{0,1\}\(\/[^\"'#[:space:]]*\).*/\1/p" "$file" \
        2>/dev/null | tail -n 1 || true)"
    echo "${configured:-"${data-}"}"
}

# template NAME: a file of deploy/ with the values of this installation.
template() {
    local text
    text="$(<"$DEPLOY/$1")"
    text="${text//@HARDENING@/"$(<"$DEPLOY/systemd/hardening.conf")"}"
    text="${text//@CHECKOUT@/"$GPR20_ROOT"}"
    text="${text//@USER@/"$user"}"
    text="${text//@ROBOT@/"$robot"}"
    text="${text//@SERVER@/"$server"}"
    text="${text//@PART@/"${part-}"}"
    text="${text//@DATA@/"$(used_data)"}"
    printf '%s\n' "${text//@PARTS@/"${parts-}"}"
}
