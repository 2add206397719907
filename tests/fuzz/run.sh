#!/usr/bin/env bash
# Fuzzes targets with libFuzzer, one after the other; needs Clang with its runtime libraries (Debian: clang libclang-rt-dev).
#
#   tests/fuzz/run.sh                      every target, a minute each
#   tests/fuzz/run.sh --seconds 3600 ply   one, for an hour
#
# Inputs that are new are kept in build/fuzz/corpus/TARGET; an input that breaks something in build/fuzz/found, and the exit status is 1. A repair
# comes with that input, renamed, in tests/fuzz/corpus/TARGET. Kernels are not compiled for fuzzing: where build/release has some, scene_build
# renders with those.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$top"

seconds=60
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds)
      seconds=${2:?--seconds needs a number}
      shift
      ;;
    -h | --help)
      sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
      exit 0
      ;;
    *) targets+=("$1") ;;
  esac
  shift
done
if [ ${#targets[@]} -eq 0 ]; then
  for file in tests/fuzz/corpus/*/; do targets+=("$(basename "$file")"); done
fi

[ -f build/fuzz/build.ninja ] || cmake --preset fuzz
ninja -C build/fuzz "${targets[@]/#/fuzz_}"
mkdir -p build/fuzz/found build/fuzz/lib
for kernel in build/release/lib/libtessera_*.so; do
  [ ! -f "$kernel" ] || ln -sf "$top/$kernel" build/fuzz/lib/
done

# Scratch files in memory, where the system has a place for them.
scratch=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/tessera-fuzz.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
status=0
for target in "${targets[@]}"; do
  corpus=build/fuzz/corpus/$target
  mkdir -p "$corpus"
  printf '== %s, %s s\n' "$target" "$seconds"
  # Leaks of what the system's libraries hold for good are not ours; a gigabyte is more than any input may ask for.
  # The time is the clock's: a process that is stopped, or kept waiting by others, is no finding.
  TMPDIR=$scratch ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=0 "build/fuzz/tests/fuzz_$target" \
    -max_total_time="$seconds" -timeout=120 -rss_limit_mb=3072 -malloc_limit_mb=1024 -max_len=16384 \
    -artifact_prefix="build/fuzz/found/$target-" -print_final_stats=1 "$corpus" "tests/fuzz/corpus/$target" \
    2>build/fuzz/"$target".log || status=1
  grep -aE 'SUMMARY|^stat::(number|average|peak)|DONE' build/fuzz/"$target".log || tail -n 5 build/fuzz/"$target".log
done
exit $status
