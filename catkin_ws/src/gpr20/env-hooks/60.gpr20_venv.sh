# The virtual environment of an install space, folder venv in it (scripts/install_space.sh): its
# python3 comes first in PATH, so that the nodes (`/usr/bin/env python3`) run in it. A built
# workspace has none.
#   GPR20_SET_VENV   what this file added to PATH when it was sourced before

# Of another install space that was sourced in this shell before.
if [ -n "${GPR20_SET_VENV:-}" ]; then
    PATH="$(printf '%s' "$PATH" | tr ':' '\n' | grep -Fxv "$GPR20_SET_VENV" | paste -s -d ':')"
    unset GPR20_SET_VENV
fi
if [ -x "$CATKIN_ENV_HOOK_WORKSPACE/venv/bin/python3" ]; then
    export GPR20_SET_VENV="$CATKIN_ENV_HOOK_WORKSPACE/venv/bin"
    export PATH="$GPR20_SET_VENV:$PATH"
fi
