# Sourced by gpr20-run and by the firewall, in any shell: the one reading of /etc/gpr20/robot.conf.
# A line that cannot be understood is refused: a setting that is left out silently could move the
# real robot instead of the simulated one, or leave the firewall away.
# shellcheck shell=sh

GPR20_SETTINGS="ROLE ROBOT SERVER ADMIN FIREWALL WEB DATA CONFIG LAUNCH_ARGUMENTS WINDOW_ARGUMENTS"

# gpr20_read_settings FILE: check the file and export what it sets. What the caller has set already
# stays. On a mistake: a sentence, and status 1.
gpr20_read_settings() {
    if [ ! -f "$1" ] || [ ! -r "$1" ]; then
        echo "$1 cannot be read by $(id -un); it must be a file, readable for all: chmod 644 $1" >&2
        return 1
    fi
    gpr20_checked="$(_gpr20_check_lines "$1" <"$1")" || return 1
    for gpr20_name in $GPR20_SETTINGS; do
        eval "gpr20_given=\${GPR20_$gpr20_name+given}"
        [ -z "$gpr20_given" ] || continue
        gpr20_value="$(printf '%s\n' "$gpr20_checked" | sed -n "s/^GPR20_$gpr20_name=//p")"
        export "GPR20_$gpr20_name=$gpr20_value"
    done
    # A role with the addresses of another one would listen, or be reached, as nobody meant.
    case "$GPR20_ROLE:${GPR20_ROBOT:+given}:${GPR20_SERVER:+given}" in
        robot:given:given | server:given:given | both:: | analysis:* | :*) ;;
        *)
            echo "GPR20_ROLE is '$GPR20_ROLE' in $1, with the addresses '$GPR20_ROBOT' and" \
                "'$GPR20_SERVER'; allowed are robot and server with both addresses," \
                "both and analysis" >&2
            return 1 ;;
    esac
}

# Print NAME=value of each setting, without quotes.
_gpr20_check_lines() {
    awk -v file="$1" -v names="$GPR20_SETTINGS" '
        function refuse(reason) {
            gsub(/[^ -~]/, "?", reason)
            printf "%s line %d: %s\n", file, NR, reason >"/dev/stderr"
            failed = 1
            exit 1
        }
        BEGIN {
            count = split(names, list, " ")
            for (i = 1; i <= count; i++) known["GPR20_" list[i]] = 1
            allowed = "GPR20_" names
            gsub(/ /, ", GPR20_", allowed)
        }
        /^[ \t]*(#|$)/ { next }
        /\r$/ { refuse("it ends with a carriage return; save the file with line ends of Linux") }
        !/^[A-Za-z0-9_]+=/ { refuse("\"" $0 "\" is not NAME=value without further spaces") }
        {
            name = value = $0
            sub(/=.*/, "", name)
            sub(/^[^=]*=/, "", value)
            if (!(name in known)) refuse(name " is unknown; allowed: " allowed)
            if (name in line) refuse(name " is set in line " line[name] " already; keep one")
            line[name] = NR
            if (value ~ /^".*"$/) value = substr(value, 2, length(value) - 2)
            if (value ~ /^[ \t]|[ \t]$/) refuse(name " begins or ends with a space")
            if (value ~ /["\047\\$`]/) refuse(name " has a quote, \\, $ or `: leave it out")
            if (value ~ /(^|[ \t])#/) refuse(name " has a comment behind it: use another line")
            print name "=" value
        }
        END { exit failed }'
}
