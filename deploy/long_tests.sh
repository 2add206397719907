#!/usr/bin/env bash
# Runs as many of the long tests as a time allows, one after the other, on what deploy/test.sh has built: those first that
# the latest commits concern, then the others, another one first with each commit. What there is no time for is named.
# Fails where a test fails, not where time runs out.
#
#   deploy/long_tests.sh SECONDS
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

budget=${1:?the time is missing, in seconds}
cd "$top/build/release"
# Beside what deploy/test.sh has noted.
export TESSERA_SKIPS=$PWD/skipped.txt

# tests CTEST-OPTIONS...: names, one a line.
tests() { ctest -N "$@" | sed -n 's/^ *Test *#[0-9]*: *//p'; }

# The labels of tests of what the latest commits changed; everything, where the history is not there.
concerned() {
  local changed
  changed=$(git -C "$top" diff --name-only HEAD~10 2>/dev/null || true)
  case "$changed" in *worker/render/*) echo 'statistical|stress' ;; esac
  case "$changed" in *server/* | *worker/agent/* | *proto/*) echo 'integration|load|scenario' ;; esac
  case "$changed" in *client/import/* | *proto/wire/* | *proto/images/*) echo 'fuzz' ;; esac
}

mapfile -t all < <(tests -L '^long$')
[ ${#all[@]} -gt 0 ] || die "there are no long tests"
turn=$(($(git -C "$top" rev-list --count HEAD 2>/dev/null || echo 0) % ${#all[@]}))
all=("${all[@]:turn}" "${all[@]:0:turn}")
labels=$(concerned | paste -sd '|')
first=()
[ -z "$labels" ] || mapfile -t first < <(tests -L '^long$' -L "^($labels)\$")
order=$(printf '%s\n' "${first[@]}" "${all[@]}" | awk 'NF && !seen[$0]++')

failed=() unrun=()
for test in $order; do
  left=$((budget - SECONDS))
  if [ "$left" -lt 30 ]; then
    unrun+=("$test")
    continue
  fi
  result=0
  timeout --kill-after=30 "$left" ctest --output-on-failure -R "^$test\$" || result=$?
  case $result in
    0) ;;
    124 | 137) unrun+=("$test") ;;
    *) failed+=("$test") ;;
  esac
done
[ ${#unrun[@]} -eq 0 ] || say "no time was left for: ${unrun[*]}"
[ ${#failed[@]} -eq 0 ] || die "failed: ${failed[*]}"
