# The virtual environment of an install space, folder venv in it (scripts/install_space.sh): its
# python3 comes first in PATH, so that the nodes (`/usr/bin/env python3`) run in it. A built
# workspace has none.
if [ -x "$CATKIN_ENV_HOOK_WORKSPACE/venv/bin/python3" ]; then
    export PATH="$CATKIN_ENV_HOOK_WORKSPACE/venv/bin:$PATH"
fi
