# shellcheck shell=bash
# Functions that the scripts of this folder share; to be sourced by bash. Sets `top` to the root of the source tree.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '== %s\n' "$*"; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# The comment at the head of the script that runs.
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }

# as_root COMMAND...: with sudo where that is needed.
as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    die "needs root for: $*   (there is no sudo; run deploy/setup.sh as root, then this again)"
  fi
}

# build PRESET [TARGET...]: configures once, then builds the targets, or everything.
build() {
  local preset=$1 log=$top/build/configure-$1.log
  shift
  if [ ! -f "$top/build/$preset/build.ninja" ]; then
    say "configuring build/$preset"
    mkdir -p "$top/build"
    (cd "$top" && cmake --preset "$preset") >"$log" 2>&1 || {
      cat "$log" >&2
      die "cmake failed"
    }
  fi
  say "building build/$preset${*:+: $*}"
  ninja -C "$top/build/$preset" "$@"
}

# stop_all PID...: asks them to end, waits, and kills what is left after ten seconds.
stop_all() {
  [ $# -gt 0 ] || return 0
  kill "$@" 2>/dev/null || true
  local pid deadline=$((SECONDS + 10))
  for pid in "$@"; do
    while kill -0 "$pid" 2>/dev/null && [ $SECONDS -lt $deadline ]; do sleep 0.1; done
    kill -KILL "$pid" 2>/dev/null || true
    wait "$pid" 2>/dev/null || true
  done
}
