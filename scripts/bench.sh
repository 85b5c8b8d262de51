#!/usr/bin/env bash
# Run a benchmark in the project's environment: scripts/bench.sh NAME [OPTIONS OF THE BENCHMARK]
# Without a name: list them. Results and their commands are in docs/. Nothing is installed: a
# benchmark measures what scripts/setup.sh has built.
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
if [ $# -eq 0 ] || [ ! -f "$GPR20_ROOT/benchmarks/$1.py" ] || [[ "$1" == *_kit ]]; then
    echo "usage: scripts/bench.sh NAME; benchmarks are:" >&2
    find "$GPR20_ROOT/benchmarks" -maxdepth 1 -name '*.py' ! -name '*_kit.py' -printf '  %f\n' |
        sed 's/\.py$//' | sort >&2
    exit 2
fi
"$GPR20_ROOT/scripts/setup.sh" --check
gpr20_use_workspace
name="$1"
shift
cd "$GPR20_ROOT"
PYTHONPATH="$GPR20_TOOLS:$PYTHONPATH" exec python "benchmarks/$name.py" "$@"
