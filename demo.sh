#!/usr/bin/env bash
# Sets up what is missing, runs the paper's experiment over ROS and says how it went.
[ -n "${BASH_VERSION:-}" ] || exec bash "$0" "$@" # sh demo.sh
set -u

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'TEXT'
Usage: ./demo.sh [--headless] [--scenario FILE] [--out DIR] [--speed S] [--require-verdict]

Runs the stage, the control node and the recorder under a ROS master of their own, on this host only:
seven Pioneers form the paper's straight line. Ends with a verdict against theory, figures and data.

  --headless       open no window, even if there is a display
  --scenario FILE  the experiment (default: scenarios/paper_dynamic.yaml)
  --out DIR        where figures, run.csv and verdict.json go (default: runs/<scenario>)
  --speed S        simulated over wall time, 0: as fast as possible (default: 5)
  --require-verdict  exit with 3 where theory says nothing of the run
  --help           this text

With a display the GUI opens, attached to the run; the demo ends when its window is closed.
Exits with 0 if the run agrees with theory or could not be judged, 1 if not, 2 if the run could not be made.
TEXT
}

wrong() {
  printf 'demo.sh: %s\n\n' "$1" >&2
  usage >&2
  exit 2
}

headless=false scenario="$root/scenarios/paper_dynamic.yaml" out="" speed=5 require=()
while [ $# -gt 0 ]; do
  case "$1" in
    --headless) headless=true ;;
    --require-verdict) require=(--require-verdict) ;;
    --help | -h) usage; exit 0 ;;
    --scenario | --out | --speed)
      [ $# -ge 2 ] && [ -n "$2" ] || wrong "$1: nothing given"
      printf -v "${1#--}" '%s' "$2"
      shift
      ;;
    *) wrong "unknown option $1" ;;
  esac
  shift
done
[ -f "$scenario" ] || wrong "--scenario $scenario: no such file"
[[ $speed =~ ^([0-9]+\.?[0-9]*|\.[0-9]+)$ ]] || wrong "--speed $speed: wanted 0 or a positive number"
scenario=$(realpath "$scenario")
out=$(realpath -m "${out:-$root/runs/$(basename "${scenario%.*}")}")

set -u
. "$root/tools/prepare.sh"
prepare
private_ros

fidelity=()
if ! has_pybullet && grep -q '^fidelity: *dynamic' "$scenario"; then
  fidelity=(fidelity:=kinematic)
  echo "   without pybullet yet: this run is kinematic; run this again later for masses, wheels and friction"
fi

mkdir -p "$out" || fail "making $out" "choose another directory with --out"
# Two demos at once would write over each other.
exec 8>"$out/.demo"
if ! flock -n 8; then
  out=$(mktemp -d "$out.XXXX")
  printf -- '== another demo writes to that directory, this one to %s\n' "$out"
  exec 8>"$out/.demo"
  flock -n 8
fi
rm -f "$out/run.csv" "$out/verdict.json"
export ROS_LOG_DIR="$out/log"

# roslaunch ends every node that it started; this ends roslaunch, and waits until it is gone.
launch=""
end() {
  [ -n "$launch" ] || return
  kill -INT "$launch" 2>/dev/null
  for tenths in $(seq 300); do
    kill -0 "$launch" 2>/dev/null || break
    [ "$tenths" = 100 ] && kill -TERM "$launch" 2>/dev/null
    sleep 0.1
  done
  kill -KILL -- "-$launch" 2>/dev/null
  wait "$launch" 2>/dev/null
  launch=""
}
trap end EXIT
trap 'echo; echo "stopped; what was recorded is in $out"; exit 130' INT TERM HUP

printf -- '== running %s at %s x real time\n' "$(basename "$scenario")" "$speed"
gui=false
if ! $headless && [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  if display_answers; then gui=true; else echo "   display ${DISPLAY:-$WAYLAND_DISPLAY} does not answer: no window is opened"; fi
fi
# In lockstep, so that the run is the same whatever else the machine is doing.
# A process group of its own: Ctrl-C comes here, and from here to roslaunch.
set -m
roslaunch -p "$port" mrs_simulator simulation.launch scenario:="$scenario" out:="$out" speed:="$speed" lockstep:=true gui:=$gui \
  "${fidelity[@]+"${fidelity[@]}"}" \
  >"$out/launch.log" 2>&1 </dev/null &
launch=$!
set +m

duration=$(sed -n 's/^duration: *\([0-9.]*\).*/\1/p' "$scenario")
shown=-1
while kill -0 "$launch" 2>/dev/null && [ ! -f "$out/verdict.json" ]; do
  sleep 0.5
  now=$(tail -n 1 "$out/run.csv" 2>/dev/null | cut -d, -f1)
  now=${now%%.*}
  # A line each ten simulated seconds.
  if [[ $now =~ ^[0-9]+$ ]] && [ $((now / 10)) != "$shown" ]; then
    shown=$((now / 10))
    printf '   simulated %s of %s s\n' "$now" "${duration:-?}"
  fi
done
# Everything ends by itself; with a GUI, once its window is closed.
$gui || { wait "$launch"; launch=""; }

if [ ! -f "$out/verdict.json" ]; then
  reasons "$out/launch.log" >&2
  printf '\nFailed: the run ended without a verdict; all of the output: %s\n' "$out/launch.log" >&2
  exit 2
fi
echo
python3 -m mrs_simulator.verdict.verdict "$out/verdict.json" "${require[@]+"${require[@]}"}"
code=$?
echo "  figures and data: $out"
if [ -n "$launch" ]; then
  echo "  the GUI is open; the demo ends with its window"
  while kill -0 "$launch" 2>/dev/null; do sleep 0.5; done
fi
exit $code
