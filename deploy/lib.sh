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

# minutes SECONDS: "2:05".
minutes() { printf '%d:%02d' $(($1 / 60)) $(($1 % 60)); }

# begin TEXT ... end: one line a phase, with the time that it took. In between nothing else should be printed but bars.
begin() {
  phase=$1
  phase_began=$SECONDS
  printf '== %s ...' "$phase"
}
end() {
  if [ -t 1 ]; then printf '\r\033[K== %s ...' "$phase"; fi
  printf ' %s\n' "$(minutes $((SECONDS - phase_began)))"
}

# show_bar: on a terminal, a bar behind the line of the phase, from ninja's lines "[12/345] ...".
show_bar() {
  local line done=0 total=0 filled blank='                    ' bar='===================='
  while IFS= read -r line; do
    [[ -t 1 && $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    done=${BASH_REMATCH[1]} total=${BASH_REMATCH[2]}
    filled=$((total > 0 ? 20 * done / total : 0))
    printf '\r\033[K== %s ... [%s%s] %d of %d' "$phase" "${bar:0:filled}" "${blank:filled}" "$done" "$total"
  done
}

# build PRESET [TARGET...]: configures once, then builds the targets, or everything. What cmake and ninja say goes into files beside
# the build, and is shown when they fail.
build() {
  local preset=$1 log=$top/build/configure-$1.log
  shift
  if [ ! -f "$top/build/$preset/build.ninja" ]; then
    begin "configuring build/$preset"
    mkdir -p "$top/build"
    (cd "$top" && cmake --preset "$preset") >"$log" 2>&1 || {
      echo
      cat "$log" >&2
      die "cmake failed"
    }
    end
  fi
  log=$top/build/build-$preset.log
  begin "building build/$preset${*:+: $*}"
  ninja -C "$top/build/$preset" "$@" 2>&1 | tee "$log" | show_bar || {
    echo
    # The step that failed, without those around it; or ninja's own words.
    if grep -q '^FAILED: ' "$log"; then
      sed -n -e '/^\[/d' -e '/^FAILED: /,$p' "$log" | head -n 100 >&2
    else
      tail -n 20 "$log" >&2
    fi
    die "the build failed; all that was said is in $log"
  }
  end
}

# base_commit: the commit from which changes count: TESSERA_BASE; else the latest that CI has passed on this machine
# (note_passed); else the fortieth before this one, more than is usually submitted at a time; else the first one.
# CI's own note needs nobody to keep it, and a submission that was refused does not move it.
passed_commits=${XDG_CACHE_HOME:-$HOME/.cache}/tessera-passed
base_commit() {
  local commit
  for commit in ${TESSERA_BASE:-$(tac "$passed_commits" 2>/dev/null | head -n 20)} HEAD~40; do
    git -C "$top" merge-base --is-ancestor "$commit" HEAD 2>/dev/null || continue
    git -C "$top" rev-parse "$commit"
    return
  done
  git -C "$top" rev-list --max-parents=0 HEAD 2>/dev/null | tail -n 1
}
note_passed() {
  mkdir -p "$(dirname "$passed_commits")"
  git -C "$top" rev-parse HEAD >>"$passed_commits"
}
# changed_files: those that differ from that commit, and are there; nothing, where there is no history.
changed_files() {
  local base
  base=$(base_commit)
  [ -z "$base" ] || git -C "$top" diff --name-only --diff-filter=d "$base"
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
