#!/usr/bin/env bash
# Sets up what is missing, then checks the style and runs all tests; arguments go to pytest.
# "./test.sh all" adds what is run before a release: installs, the site, the wheel, the campaign of mistakes.
# "./test.sh fast" leaves out what starts ROS, the GUI's process or a long run; "--room world" keeps one room's tests.
[ -n "${BASH_VERSION:-}" ] || exec bash "$0" "$@" # sh test.sh
set -u

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$root/tools/prepare.sh"
prepare dev
cd "$root" || exit 1
case "${1:-}" in fast | all)
  option=--$1
  shift
  set -- "$option" "$@"
  ;;
esac

failed=()
check() { # name, command...
  local name=$1
  shift
  printf -- '== %s\n' "$name"
  "$@" || failed+=("$name")
}

check "ruff lint" ruff check --no-cache .
check "ruff format" ruff format --no-cache --check .
# The checkout may have any name; demo.sh and test.sh belong to it, not to an installed package.
check "catkin_lint" catkin_lint --quiet --strict -W2 --ignore package_path_name \
  --ignore uninstalled_script .
# Ten seconds, in which the tests are collected.
vermin -p=1 --no-parse-comments --no-tips --violations -t=3.8- src test benchmarks examples setup.py \
  >build/vermin.log 2>&1 &
vermin=$!
python_38() {
  wait "$vermin" || { cat build/vermin.log && return 1; }
}
private_ros
# Where all is new, once: else each worker compiles all tests, and what they import, at the same time.
python3 -m pytest --collect-only -qq "$@" >build/collected.log 2>&1
# Tests with processes of ROS wait most of their time, and come late where others keep the cores: these give way.
tests() {
  local others only=0 without=0
  (
    trap - INT # in the background the shell has it ignored
    exec nice python3 -m pytest -n "$(nproc)" --dist worksteal --processes without "$@"
  ) >build/tests.log 2>&1 &
  others=$!
  python3 -m pytest -n "$(($(nproc) + 1))" --dist worksteal --processes only "$@" || only=$?
  wait "$others" || without=$?
  cat build/tests.log
  case $only-$without in 0-0 | 0-5 | 5-0) ;; *) return 1 ;; esac # 5: none of these was asked for
}
check "tests" tests "$@"
check "Python 3.8" python_38

[ ${#failed[@]} = 0 ] && echo "all passed" && exit 0
printf 'failed: %s\n' "${failed[@]}" >&2
exit 1
