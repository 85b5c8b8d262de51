#!/usr/bin/env bash
# Install what is missing, then run a small survey on the simulated robot to its end, and write a
# report with an image of the targets in the simulated ground.
# Options are handed to the terminal client (see: scripts/survey.sh --help).
#   GPR20_DATA         where surveys are kept (default ~/gpr20_data)
#   GPR20_TIME_SCALE   how many times faster than the real robot it runs (default 50)
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
gpr20_use_workspace

case " $* " in
    *" -h "* | *" --help "*) exec rosrun gpr20_user_interface run_survey --help ;;
esac

# Around both targets of the scene, 40 mm from stop to stop.
area=(--x-start-mm 90 --x-stop-mm 330 --x-points 7 --y-start-mm 80 --y-stop-mm 320 --y-points 7)
# A survey that exists has its own.
case " $* " in *" --resume"*) area=() ;; esac
# A mistake is refused before a robot is started for it.
python -c 'import sys
from gpr20_common.catalogue import Catalogue
from gpr20_user_interface.terminal import parse_arguments
parse_arguments(sys.argv[1:], Catalogue())' "${area[@]}" "$@"

data="$(realpath -ms "${GPR20_DATA:-$HOME/gpr20_data}")"
time_scale="${GPR20_TIME_SCALE:-50}"
scene="$GPR20_WORKSPACE/src/gpr20_simulator/scenes/two_targets.yaml"
logs="$(mktemp -d)"
log="$logs/roslaunch.log"
# A master of its own, so that this never meets a robot that is already running here.
port="$(gpr20_free_port)"
export ROS_MASTER_URI="http://127.0.0.1:$port"

echo "starting the simulated robot (about 5 s)"
setsid python "$GPR20_ROOT/deploy/beside_master.py" \
    roslaunch gpr20 survey.launch ui:=false "data:=$data" "scene:=$scene" \
    "time_scale:=$time_scale" >"$log" 2>&1 &
launch=$!
shut_down() {
    trap - EXIT
    kill -INT "$launch" 2>/dev/null || true
    wait "$launch" 2>/dev/null || true
}
trap shut_down EXIT

status=0 survey=
# The first start is slow on a small or busy machine: nothing is compiled yet.
rosrun gpr20_user_interface run_survey --wait 120 "${area[@]}" "$@" || status=$?
if [ "$status" -eq 0 ]; then
    # The status is latched, so it comes at once. The folder's name ends with the id's first part.
    id="$(timeout 20 rostopic echo -n 1 /control_status/survey_id |
        grep -oE -m 1 '[0-9a-f]{8}-[0-9a-f-]{27}')"
    survey="$(find "$data" -maxdepth 1 -type d -name "*_${id%%-*}")"
fi
shut_down
if [ "$status" -ne 0 ]; then
    # A refusal has been printed; the log of the nodes says nothing more.
    [ "$status" -eq 1 ] || tail -n 20 "$log" >&2
    echo "the survey did not finish (status $status); the whole log of the nodes is $log" >&2
    exit "$status"
fi
# The storage has made the bag meanwhile, unless it is large.
[ -f "$survey/survey.bag" ] || gpr20 export --format bag "$survey" >/dev/null || true
traces="$(find "$survey/traces" -name '*.json' | wc -l)"

# Beside the survey: in its folder, the report would be a file that the manifest lacks.
# The simulated soil is known; a real one is measured or estimated.
report="file://$survey.html"
permittivity="$(python "$GPR20_ROOT/tools/scene_targets.py" "$scene" --permittivity)"
echo "writing the report (about 6 s)"
gpr20 report "$survey" --permittivity "$permittivity" --overwrite -o "$survey.html" \
    >"$logs/report.log" 2>&1 || report="none: $(tail -n 3 "$logs/report.log")"

cat <<END

The survey is in $survey
  traces, one JSON file each:  $survey/traces/  ($traces files)
  ROS bag:                     $survey/survey.bag
  MCAP:                        $survey/survey.mcap
Replay it:
  source $GPR20_WORKSPACE/devel/setup.bash
  roslaunch gpr20 replay.launch survey:=$survey
or with ROS's own player, beside a window for it:
  roslaunch gpr20 replay.launch
  rosbag play --prefix=/replay $survey/survey.bag
Check it:
  $GPR20_ROOT/scripts/verify.sh $survey

The report of this SIMULATED survey, with the image of the ground; open it in a browser:
  $report
END
# Without an image, for too few stops, there are no candidates.
if gpr20 candidates "$survey" --permittivity "$permittivity" --json \
    >"$logs/candidates.json" 2>/dev/null; then
    printf '\nTargets of the simulated ground:\n'
    python "$GPR20_ROOT/tools/scene_targets.py" "$scene" <"$logs/candidates.json"
fi
rm -r "$logs"
