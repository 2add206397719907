#!/usr/bin/env bash
# Installs and builds what is missing, then runs the tests of the gate: those whose verdict depends on the sources
# alone, not on time or chance. What is not an option of this script goes to ctest.
#
#   deploy/test.sh                     all tests but those with the labels `long` and `soak` (deploy/soak.sh)
#   deploy/test.sh --all               those too
#   deploy/test.sh --preset asan       another build: debug, asan, tsan
#   deploy/test.sh -R scheduler        only tests whose name matches
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

preset=release
labels=(-LE '^(long|soak)$')
arguments=()
while [ $# -gt 0 ]; do
  case "$1" in
    --all) labels=() ;;
    --preset)
      preset=${2:?--preset needs a name}
      shift
      ;;
    -h | --help)
      usage
      exit 0
      ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

"$top/deploy/setup.sh"
build "$preset"
say "testing build/$preset"
cd "$top/build/$preset"
# Test programs note there what they skip, and why.
export TESSERA_SKIPS=$top/build/$preset/skipped.txt
: >"$TESSERA_SKIPS"
result=0
# Tests of farms, of which so many run at once, wait more than they work.
farms=$(sed -n 's/.*"slots": \([0-9]*\).*/\1/p' "$top/deploy/resources.json")
ctest --output-on-failure --no-tests=error -j "$(($(nproc) + farms - 1))" \
  --resource-spec-file "$top/deploy/resources.json" "${labels[@]}" "${arguments[@]}" || result=$?
if [ -s "$TESSERA_SKIPS" ]; then
  say "skipped"
  sort -u "$TESSERA_SKIPS"
fi
if [ $result -ne 0 ]; then
  # Again, and last: whoever sees no more than the end of a log sees why.
  say "why it failed (all that was said: build/$preset/Testing/Temporary/LastTest.log)"
  grep -h -A 5 -e ': Failure$' -e ' error: ' -e 'ERROR: .*Sanitizer' Testing/Temporary/LastTest.log |
    grep -v '^--$' | awk '!seen[$0]++' | head -n 40 || true
fi
exit $result
