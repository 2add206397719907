#!/usr/bin/env bash
# Runs as many of the soak tests as a time allows, one after the other, on what deploy/test.sh has built: tests with
# random faults, tests that measure time, and long forms, which the gate leaves out. Those of what has changed come
# first, then the others, starting with another one at each commit. What there is no time for is named.
#
# Every run has a new seed, which is printed. A test that fails is run again with the same seed: the run fails where it
# fails twice; where it passes the second time, the failure is shown with the command that replays it.
#
#   deploy/soak.sh SECONDS             new seed
#   TESSERA_SEED=N deploy/soak.sh SECONDS [TEST...]    this seed, and these tests alone
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

budget=${1:?the time is missing, in seconds}
shift
cd "$top/build/release"
# Beside what deploy/test.sh has noted.
export TESSERA_SKIPS=$PWD/skipped.txt
export TESSERA_SEED=${TESSERA_SEED:-$((RANDOM * 32768 + RANDOM))}
say "soak tests with TESSERA_SEED=$TESSERA_SEED"

# tests CTEST-OPTIONS...: names, one a line.
tests() { ctest -N "$@" | sed -n 's/^ *Test *#[0-9]*: *//p'; }

# The labels of tests of what has changed (changed_files in lib.sh).
concerned() {
  local changed
  changed=$(changed_files)
  case "$changed" in *worker/render/*) echo 'statistical|stress' ;; esac
  case "$changed" in *server/* | *worker/agent/* | *proto/* | *lib/net/*) echo 'integration|load|scenario' ;; esac
  case "$changed" in *client/import/* | *proto/wire/* | *lib/images/*) echo 'fuzz' ;; esac
}

if [ $# -gt 0 ]; then
  order=$*
else
  mapfile -t all < <(tests -L '^(long|soak)$')
  [ ${#all[@]} -gt 0 ] || die "there are no soak tests"
  turn=$(($(git -C "$top" rev-list --count HEAD 2>/dev/null || echo 0) * 7 % ${#all[@]}))
  all=("${all[@]:turn}" "${all[@]:0:turn}")
  labels=$(concerned | paste -sd '|')
  first=()
  [ -z "$labels" ] || mapfile -t first < <(tests -L '^(long|soak)$' -L "^($labels)\$")
  order=$(printf '%s\n' "${first[@]}" "${all[@]}" | awk 'NF && !seen[$0]++')
fi

# run TEST: sets `result` to 0 (passed), 124 (no time was left) or another number (failed).
run() {
  result=0
  local left=$((budget - SECONDS))
  [ "$left" -ge 30 ] || {
    result=124
    return
  }
  timeout --kill-after=30 "$left" ctest --output-on-failure --no-tests=error -R "^$1\$" || result=$?
  [ $result -ne 137 ] || result=124
}

failed=() doubtful=() unrun=()
for test in $order; do
  run "$test"
  if [ $result -ne 0 ] && [ $result -ne 124 ]; then
    say "$test failed; once more with the same seed: TESSERA_SEED=$TESSERA_SEED deploy/soak.sh 1800 $test"
    doubtful+=("$test")
    run "$test"
    [ $result -eq 0 ] || [ $result -eq 124 ] || failed+=("$test")
  elif [ $result -eq 124 ]; then
    unrun+=("$test")
  fi
done
[ ${#unrun[@]} -eq 0 ] || say "no time was left for: ${unrun[*]}"
for test in "${doubtful[@]}"; do
  say "FAILED ONCE: TESSERA_SEED=$TESSERA_SEED deploy/soak.sh 1800 $test"
done
[ ${#failed[@]} -eq 0 ] || die "failed twice with TESSERA_SEED=$TESSERA_SEED: ${failed[*]}"
