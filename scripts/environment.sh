# Sourced by the other scripts: where things are, and the ROS environment on loopback.
# shellcheck shell=bash

GPR20_ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)"
GPR20_VENV="$GPR20_ROOT/.venv"
GPR20_WORKSPACE="$GPR20_ROOT/catkin_ws"
# Where Python finds what the tests, benchmarks and generators share.
GPR20_TOOLS="$GPR20_ROOT/tools:$GPR20_ROOT/tools/kits"
export GPR20_ROOT GPR20_VENV GPR20_WORKSPACE GPR20_TOOLS

# Make the workspace and its interpreter the ones that ROS finds.
gpr20_use_workspace() {
    # catkin's generated file reads variables that may not be set.
    set +u
    # shellcheck disable=SC1091
    source "$GPR20_WORKSPACE/devel/setup.bash"
    set -u
    export PATH="$GPR20_VENV/bin:$PATH"
}

# A TCP port of loopback that nobody listens on.
gpr20_free_port() {
    /usr/bin/python3 -c 'import socket
with socket.socket() as probe:
    probe.bind(("127.0.0.1", 0))
    print(probe.getsockname()[1])'
}
