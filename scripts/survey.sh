#!/usr/bin/env bash
# Install what is missing, then run a small survey on the simulated robot to its end.
# Options are handed to the terminal client (see: scripts/survey.sh --help).
#   GPR20_DATA         where surveys are kept (default ~/gpr20_data)
#   GPR20_TIME_SCALE   how many times faster than the real robot it runs (default 50)
set -euo pipefail
# shellcheck source=scripts/environment.sh
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
"$GPR20_ROOT/scripts/setup.sh"
gpr20_use_workspace

for option in "$@"; do
    if [ "$option" = -h ] || [ "$option" = --help ]; then
        exec rosrun gpr20_user_interface run_survey --help
    fi
done

data="$(realpath -ms "${GPR20_DATA:-$HOME/gpr20_data}")"
time_scale="${GPR20_TIME_SCALE:-50}"
logs="$(mktemp -d)"
log="$logs/roslaunch.log"
# A master of its own, so that this never meets a robot that is already running here.
port="$(gpr20_free_port)"
export ROS_MASTER_URI="http://127.0.0.1:$port"

setsid roslaunch -p "$port" gpr20 survey.launch ui:=false "data:=$data" \
    "time_scale:=$time_scale" >"$log" 2>&1 &
launch=$!
shut_down() {
    trap - EXIT
    kill -INT "$launch" 2>/dev/null || true
    wait "$launch" 2>/dev/null || true
}
trap shut_down EXIT

area=(--x-start-mm 100 --x-stop-mm 120 --x-points 3 --y-start-mm 100 --y-stop-mm 120 --y-points 3)
# A survey that exists has its own.
case " $* " in *" --resume"*) area=() ;; esac
status=0 survey=
rosrun gpr20_user_interface run_survey "${area[@]}" "$@" || status=$?
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
rm -r "$logs"
traces="$(find "$survey/traces" -name '*.json' | wc -l)"

cat <<END

The survey is in $survey
  traces, one JSON file each:  $survey/traces/  ($traces files)
  ROS bag:                     $survey/survey.bag
  MCAP:                        $survey/survey.mcap
Replay it, on a ROS master of its own, away from any robot:
  source $GPR20_WORKSPACE/devel/setup.bash
  export ROS_MASTER_URI=http://localhost:11411
  roslaunch gpr20 replay.launch survey:=$survey
or there with ROS's own player:
  roscore -p 11411 &
  rosbag play $survey/survey.bag
Check it:
  $GPR20_ROOT/scripts/verify.sh $survey
END
