# Sets up whatever is missing: ROS, a virtual environment, the build. Sourced by demo.sh and test.sh
# with the repository's root in $root; "prepare dev" also sets up what the tests need.
# shellcheck shell=bash

log="${root:?}/build/setup.log"

# ROS 1 as Debian packages it; where a name is a command's, its package is.
debian_packages=(
  python3 python3-venv python3-numpy python3-matplotlib python3-yaml python3-setuptools
  catkin python3-catkin-pkg cmake make g++
  ros-message-generation ros-message-runtime ros-std-msgs ros-geometry-msgs ros-nav-msgs
  python3-rospy python3-roslaunch python3-rosmaster python3-rosbag rosbash rosout
  libstd-msgs-dev libgeometry-msgs-dev
  python3-rosnode python3-rosparam python3-rostopic python3-rosservice python3-rosmsg python3-rospkg
  python3-std-msgs python3-std-srvs python3-geometry-msgs python3-nav-msgs python3-sensor-msgs
  python3-rosgraph-msgs python3-tf2-msgs python3-tf2-ros
  python3-trajectory-msgs python3-visualization-msgs
  python3-dynamic-reconfigure python3-python-qt-binding python3-pyqt5
)
debian_dev_packages=(catkin-lint iproute2 xauth xvfb)
# From Debian 13 on: without python_qt_binding, whose place PyQt5 takes; with what sets ROS_PACKAGE_PATH, and
# the headers to build pybullet with.
trixie_without=python3-python-qt-binding
trixie_packages=(ros-environment python3-dev)

noetic_packages=(
  python3-venv
  ros-noetic-ros-base ros-noetic-dynamic-reconfigure ros-noetic-python-qt-binding
  ros-noetic-trajectory-msgs ros-noetic-visualization-msgs ros-noetic-tf2-msgs ros-noetic-tf2-ros
)
noetic_dev_packages=(python3-catkin-lint iproute2 xauth xvfb)

room=650 dev_room=900 # [MB] that .venv and build take, with some to spare

fail() { # what failed, what to do
  printf '\n%s\n%s\n' "Failed: $1" "$2" >&2
  exit 2
}

# Runs a command with its output in the log; on failure shows the end of it.
logged() { # step, advice, command...
  local step=$1 advice=$2
  shift 2
  printf -- '== %s\n' "$step"
  {
    printf '\n== %s: %s\n' "$step" "$*"
    "$@"
  } >>"$log" 2>&1 || {
    tail -n 25 "$log" >&2
    fail "$step" "$advice (all of the output: $log)"
  }
}

# Prints why a launch failed: what its nodes say of bad input and errors, each once, else the end.
reasons() { # log of roslaunch
  awk '
    { last[NR % 25] = $0 }
    /^(stage|pioneer_control|record|markers|mrs_gui): |\[(ERROR|FATAL)\]|^[A-Za-z_.]*(Error|Exception):/ {
      what = $0
      sub(/^[a-z_]+: /, "", what)
      if (!told[what]++) { print; found = 1 }
    }
    END { for (i = NR - 24; !found && i <= NR; i++) if (i > 0) print last[i % 25] }' "$1"
}

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

missing_packages() {
  local package
  for package in "$@"; do
    # A query prints nothing for a package that dpkg has never heard of.
    case "$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null)" in
      ii*) ;;
      *) echo "$package" ;;
    esac
  done
}

apt_progress() { # turns apt's status lines into a few lines of progress, as they come: Debian's awk waits for more
  local status percent doing
  local -A shown=()
  while IFS=: read -r status _ percent _; do
    case "$status" in dlstatus) doing="downloading" ;; pmstatus) doing="installing " ;; *) continue ;; esac
    percent=${percent%%.*}
    [[ $percent =~ ^[0-9]+$ ]] && [ "$((percent / 10))" != "${shown[$status]:-0}" ] || continue
    shown[$status]=$((percent / 10))
    printf '   %s %d %%\n' "$doing" "$percent"
  done
}

install_packages() {
  local missing
  # Names of packages hold no blanks.
  # shellcheck disable=SC2207
  missing=($(missing_packages "$@"))
  [ ${#missing[@]} = 0 ] && return
  printf -- '== %d system packages are missing: %s\n' ${#missing[@]} "${missing[*]}"
  as_root true || fail "installing system packages" "run this as root once, or as a user whom sudo lets"
  local advice="see $log; check the network and the package sources, then run this again"
  as_root apt-get update >>"$log" 2>&1 || {
    grep '^E:' "$log" | tail -n 1 >&2
    fail "apt-get update" "$advice"
  }
  # Refused to whoever is not root, even for the sizes.
  as_root env LC_ALL=C apt-get install --assume-no --no-install-recommends "${missing[@]}" 2>>"$log" |
    sed -n 's/^Need to get \(.*\) of archives.*/   \1 to download/p; s/^After this operation, \(.* will be used\)\.*/   \1/p'
  # The status has a channel of its own and goes to the terminal as a few lines, the rest to the log.
  # The channel is opened behind sudo, which passes none on.
  as_root sh -c 'log=$1; shift; exec 3>&1 >>"$log" 2>&1
    DEBIAN_FRONTEND=noninteractive exec apt-get install -y --no-install-recommends \
      -o APT::Status-Fd=3 -o Dpkg::Use-Pty=0 "$@"' sh "$log" "${missing[@]}" </dev/null | apt_progress
  [ "${PIPESTATUS[0]}" = 0 ] || {
    tail -n 25 "$log" >&2
    fail "installing system packages" "$advice"
  }
}

# Refuses a checkout in which nothing can be built, before anything is installed.
check_place() { # MB
  local place free owner remedy
  case "$root" in *[[:space:]]*) fail "setting up $root" \
    "catkin builds nothing below a path with blanks: move the checkout, for instance to ~/mrs_simulator" ;; esac
  mkdir -p "$root/build" 2>/dev/null
  for place in "$root" "$root/build" "$root/build/prepared" "$log" "$root/.venv" "$root/.venv/prepared"; do
    [ ! -e "$place" ] && [ "$place" != "$root/build" ] && continue
    [ -w "$place" ] && continue
    owner=$(stat -c %U "$place" 2>/dev/null)
    if [ "$owner" = "$(id -un)" ]; then
      remedy="it is read-only: copy the checkout to another place, or: chmod -R u+w $root"
    else
      remedy="it is ${owner:-somebody}'s: copy the checkout to a place of your own, or: sudo chown -R $(id -un) $root"
    fi
    fail "writing to $place" "$remedy"
  done
  free=$(df -Pm "$root" | awk 'NR == 2 { print $4 }')
  [ -x "$root/.venv/bin/python" ] || [ "${free:-$1}" -ge "$1" ] ||
    fail "setting up $root" "$free MB are free there, wanted at least $1 MB: make room, or move the checkout"
}

# Makes what was built elsewhere, before the checkout was moved or copied, belong to this place.
settle() {
  local old
  if [ -f "$root/build/CMakeCache.txt" ] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$root/build/CMakeCache.txt"; then
    echo "== the checkout was moved or copied: building anew"
    find "$root/build" -mindepth 1 -maxdepth 1 ! -name setup.log -exec rm -rf {} +
  fi
  [ -f "$root/.venv/bin/activate" ] || return 0
  old=$(sed -n "s/^ *VIRTUAL_ENV=[\"']*\([^\"']*\)[\"']*$/\1/p" "$root/.venv/bin/activate" | head -n 1)
  [ -n "$old" ] && [ "$old" != "$root/.venv" ] || return 0
  # Its programs name their interpreter by its path.
  grep -rlIF --exclude-dir=__pycache__ "$old/" "$root/.venv/bin" |
    xargs -r -d '\n' sed -i "s|$old/|$root/.venv/|g"
  sed -i "s|$old|$root/.venv|g" "$root"/.venv/bin/activate*
}

# Whether a window can be opened: a DISPLAY may be set to which no server answers.
display_answers() {
  # Qt aborts without a display, of which a shell tells: that of a subshell is silenced.
  (
    timeout 20 "$root/.venv/bin/python" -c '
from PyQt5.QtWidgets import QApplication
QApplication([])'
    exit $?
  ) >/dev/null 2>&1
}

os_release=/etc/os-release
of_system() { # a key of it, such as ID; empty where there is none
  (. "$os_release" 2>/dev/null && eval "printf %s \"\${$1:-}\"")
}

# What works without ROS, in one line.
without_ros='without it: python3 -m venv venv && . venv/bin/activate && pip install . && mrs-simulator experiment paper.yaml --out first'

find_ros() { # the system's packages, and the interpreter that sees them
  python=/usr/bin/python3
  if [ -f /opt/ros/noetic/setup.bash ]; then
    install_packages "${noetic_packages[@]}" ${1:+"${noetic_dev_packages[@]}"}
    # ROS's own set-up reads variables that may be unset.
    set +u
    . /opt/ros/noetic/setup.bash
    set -u
  elif [ "$(of_system VERSION_CODENAME)" = focal ]; then
    fail "looking for ROS Noetic in /opt/ros/noetic" \
      "on Ubuntu 20.04 install it first, as the ROS wiki's page noetic/Installation/Ubuntu says; $without_ros"
  elif archive_has_ros; then
    if [ "$(of_system ID)" = debian ] && [ "$(of_system VERSION_ID)" != 11 ] && [ "$(of_system VERSION_ID)" != 12 ]; then
      debian_packages=("${debian_packages[@]/#$trixie_without/}" "${trixie_packages[@]}")
    fi
    # An entry that was taken away is empty.
    # shellcheck disable=SC2068
    install_packages ${debian_packages[@]} ${1:+"${debian_dev_packages[@]}"}
  else
    fail "looking for ROS 1: $(of_system PRETTY_NAME) has no packages of it" \
      "$without_ros"
  fi
}

# Whether apt knows ROS 1: of Debian always, of others by their archives.
archive_has_ros() {
  command -v apt-get >/dev/null || return 1
  [ "$(of_system ID)" = debian ] || apt-cache show python3-rospy >/dev/null 2>&1 || {
    { [ "$(id -u)" = 0 ] || sudo -n true; } && as_root apt-get update
    apt-cache show python3-rospy
  } >>"$log" 2>&1
}

# A stamp holds what a step was done with; the step is done again when that changes.
done_with() { [ -f "$1" ] && [ "$(cat "$1")" = "$2" ]; }

# Whether pybullet comes as a wheel for this Python; else it is built from source.
has_wheel() { $python -c 'import sys; sys.exit(sys.version_info >= (3, 12))'; }

has_pybullet() { "$root/.venv/bin/python" -c 'import pybullet' >/dev/null 2>&1; }

# Builds pybullet: the tests wait for it, a demo goes on beside it. pip keeps the wheel for the next time.
build_pybullet() {
  local seconds=0 include building="$root/build/pybullet.log"
  has_pybullet && return
  include=$($python -c 'import sysconfig; print(sysconfig.get_path("include"))')
  [ -f "$include/Python.h" ] ||
    fail "building pybullet" "it wants Python's headers, $include/Python.h: sudo apt-get install python3-dev"
  printf -- '== building pybullet from source, 6 to 11 minutes: there is no wheel for %s\n' "$($python -V)"
  setsid flock -w 1800 "$root/build/.pybullet" "$root/.venv/bin/python" -m pip install --no-input \
    --disable-pip-version-check "$(grep '^pybullet' "$root/requirements.txt")" >"$building" 2>&1 </dev/null &
  if [ -z "${1:-}" ]; then
    echo "   in the background, see $building; until it is here robots move without forces"
    return
  fi
  while sleep 5 && kill -0 $! 2>/dev/null; do
    seconds=$((seconds + 5))
    [ $((seconds % 60)) = 0 ] && printf '   %d min\n' $((seconds / 60))
  done
  has_pybullet || {
    tail -n 25 "$building" >&2
    fail "building pybullet" "see $building; without it robots move by kinematics, not by forces"
  }
}

make_environment() {
  local wanted=("$root/requirements.txt" ${1:+"$root/requirements-dev.txt"}) key options=()
  key="$root $($python -V) $(cat "${wanted[@]}" | cksum)"
  done_with "$root/.venv/prepared${1:+-$1}" "$key" && return
  [ -x "$root/.venv/bin/python" ] && "$root/.venv/bin/python" -c '' 2>/dev/null ||
    logged "making the virtual environment .venv" "remove .venv and run this again" \
      "$python" -m venv --clear --system-site-packages "$root/.venv"
  rm -f "$root/.venv/lib64" # a link to lib: rosrun would look through all of it once more, for each program
  has_wheel || {
    grep -v '^pybullet' "$root/requirements.txt" >"$root/build/requirements.txt"
    wanted[0]=$root/build/requirements.txt
  }
  for file in "${wanted[@]}"; do options+=(-r "$file"); done
  echo "== installing Python packages into .venv, at most $(($2 / 100))00 MB"
  # Without a word of what is there already; pip shows its own progress.
  "$root/.venv/bin/python" -m pip install --disable-pip-version-check --no-input "${options[@]}" \
    2>&1 | tee -a "$log" | grep -vE --line-buffered '^(Requirement already|Ignoring |  Using cached)'
  [ "${PIPESTATUS[0]}" = 0 ] || {
    ! tail -n 2000 "$log" | grep -q 'Python\.h: No such file' ||
      fail "installing Python packages" "one is built from source and wants Python's headers: sudo apt-get install python3-dev"
    fail "installing Python packages" "see $log; check the network, then run this again"
  }
  echo "$key" >"$root/.venv/prepared${1:+-$1}"
}

build_package() {
  local key
  key="$root $(cd "$root" && cat CMakeLists.txt package.xml setup.py msg/* srv/* env-hooks/* | cksum)"
  done_with "$root/build/prepared" "$key" && return
  logged "configuring the catkin package" "see the error above" \
    cmake -S "$root" -B "$root/build" -DPYTHON_EXECUTABLE="$root/.venv/bin/python" \
    -DPython_EXECUTABLE="$root/.venv/bin/python" \
    -DCATKIN_ENABLE_TESTING=OFF
  logged "building messages and services" "see the error above" make -C "$root/build"
  echo "$key" >"$root/build/prepared"
}

# Compiles what moves robots in long runs, beside the demo; else the first such run does.
compile_ahead() {
  local key
  key="$root $({
    cat "$root/requirements.txt" "$root"/src/mrs_simulator/world/motion/{stretches,fused_stepping}.py
    find "$root/src" -name 'compiled*.py' -print0 | sort -z | xargs -0 -r cat
  } | cksum)"
  done_with "$root/build/compiled" "$key" && return
  echo "$key" >"$root/build/compiled"
  setsid nice -n 19 "$root/.venv/bin/python" -m mrs_simulator.study.run.compile_ahead \
    >"$root/build/compiled.log" 2>&1 </dev/null &
}

prepare() { # [dev]
  local need=$room
  [ -z "${1:-}" ] || need=$dev_room
  check_place "$need"
  settle
  find_ros "${1:-}"
  make_environment "${1:-}" "$need"
  has_wheel || build_pybullet "${1:-}"
  build_package
  set +u
  . "$root/build/devel/setup.bash"
  set -u
  [ -n "${1:-}" ] || compile_ahead
}

# A master and nodes of one's own, on this host alone: ROS 1 has no authentication.
private_ros() {
  unset ROS_IP ROS_NAMESPACE
  export ROS_HOSTNAME=localhost
  port=$("$root/.venv/bin/python" -c '
import socket
with socket.socket() as probe:
    probe.bind(("127.0.0.1", 0))
    print(probe.getsockname()[1])')
  export ROS_MASTER_URI="http://localhost:$port"
}
