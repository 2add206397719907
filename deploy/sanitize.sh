#!/usr/bin/env bash
# Runs the unit tests of what has changed (changed_files in lib.sh) with AddressSanitizer and
# UndefinedBehaviorSanitizer: those whose sources have changed, or include a header that has, or that of a source that
# has. They are built, program by program, for as long as a time allows; programs come first of which most has
# changed. Fails where a test fails, not where time runs out: what was left out is named. What was compiled is in
# ccache, so the next run gets further.
#
# It is compiled without optimisation, which takes a fifth of the time (0025), and without kernels: tests that render
# use those of the release build, which are not checked; tests of kernels themselves are named, too, and not run.
#
#   deploy/sanitize.sh SECONDS
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
esac
deadline=$((SECONDS + ${1:?the time is missing, in seconds}))
cd "$top"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build=build/asan-quick
[ -f "$build/build.ninja" ] || {
  begin "configuring $build"
  mkdir -p build
  cmake --preset asan -B "$build" -DTESSERA_ISAS= -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O0 -g1" >build/configure-asan-quick.log 2>&1 || {
    cat build/configure-asan-quick.log >&2
    die "cmake failed"
  }
  end
}

mkdir -p "$build/lib"
for kernel in build/release/lib/libtessera_{kernel,spectral}_*.so; do
  [ ! -f "$kernel" ] || ln -sf "$top/$kernel" "$build/lib/"
done

# Test sources of what has changed, one a line.
changed_tests() {
  changed_files | while IFS= read -r file; do
    case $file in
      tests/unit/*_test.cpp | tests/scenario/*_test.cpp) echo "$file" ;;
      tests/*.h | tests/*.cpp) echo "\"${file#tests/}" ;;
      proto/*.h | proto/*.cpp | lib/*.h | lib/*.cpp | server/*.h | server/*.cpp | worker/*.h | worker/*.cpp | client/*.h | client/*.cpp)
        echo "\"${file#*/}"
        ;;
    esac
  done | sed '/^"/s/\.[a-z]*$/.h"/' | sort -u >"$work/changed.txt"
  grep -v '^"' "$work/changed.txt" || true
  grep '^"' "$work/changed.txt" >"$work/headers.txt" || return 0
  grep -rlFf "$work/headers.txt" --include='*_test.cpp' tests/unit tests/scenario || true
}

# Entries of CTest that run them, one a line: how many of them, program, entry. A source that no program of this
# build has goes to left.txt.
entries() {
  grep -r '^#include "' --include='*.cxx' "$build/tests/unit" "$build/tests/scenario" |
    sed -n "s,^.*CMakeFiles/\([^/]*\)\.dir/Unity/[^:]*:#include \"$top/\(.*\)\".*,\1 \2,p" >"$work/sources.txt"
  grep -rh '^add_test(' --include=CTestTestfile.cmake "$build/tests/unit" "$build/tests/scenario" |
    sed -n 's,^add_test(\[*=*\[*\([^] ]*\)[^ ]* "[^"]*/\([^"/]*\)"[^"]*\("--sources=\([^"]*\)"\)\{0\,1\}.*,\1 \2 \4,p' |
    grep -v '^[^ ]*_long ' >"$work/entries.txt"
  awk -v left="$work/left.txt" '
    FILENAME ~ /tests.txt$/ {changed[$1]; next}
    FILENAME ~ /sources.txt$/ {if ($2 in changed) {delete changed[$2]; name = $2; sub(".*/", "", name)
                               of[$1] = of[$1] " " name}; next}
    {n = split(of[$2], names, " "); hits = 0
     for (i = 1; i <= n; ++i) hits += $3 == "" || index("," $3 ",", "," names[i] ",") > 0
     if (hits) print hits, $2, $1}
    END {for (source in changed) print source > left}' \
    "$work/tests.txt" "$work/sources.txt" "$work/entries.txt" | sort -k1,1nr -k2
}

changed_tests | sort -u >"$work/tests.txt"
: >"$work/left.txt"
entries >"$work/order.txt"
mapfile -t programs < <(cut -d ' ' -f 2 "$work/order.txt" | awk '!seen[$0]++')
say "unit tests of what has changed since $(base_commit | cut -c 1-12), with sanitizers: $(wc -l <"$work/tests.txt")" \
  "sources, ${#programs[@]} programs"

unbuilt=() unrun=() failed=()
for program in "${programs[@]}"; do
  entries=$(awk -v program="$program" '$2 == program {print $3}' "$work/order.txt" | paste -sd '|')
  result=124 left=$((deadline - SECONDS))
  if [ "$left" -ge 10 ]; then
    begin "$program"
    result=0
    timeout "$left" ninja -C "$build" "tests/$program" >"build/build-asan-quick.log" 2>&1 || result=$?
    end
  fi
  case $result in
    0) ;;
    124)
      unbuilt+=("$program")
      continue
      ;;
    *)
      grep -A 60 '^FAILED: ' build/build-asan-quick.log >&2 || tail -n 20 build/build-asan-quick.log >&2
      die "$program does not build with sanitizers"
      ;;
  esac
  left=$((deadline - SECONDS)) result=124
  [ "$left" -lt 10 ] || {
    result=0
    (cd "$build" && timeout --kill-after=10 "$left" ctest -j "$(nproc)" --output-on-failure --no-tests=error \
      -LE '^(long|soak)$' -R "^($entries)\$" >"$work/said.txt" 2>&1) || result=$?
  }
  case $result in
    0) ;;
    124 | 137) unrun+=("$entries") ;;
    *)
      cat "$work/said.txt"
      failed+=("$entries")
      ;;
  esac
done
[ ! -s "$work/left.txt" ] || say "not in this build: $(sort "$work/left.txt" | paste -sd ' ')"
[ ${#unbuilt[@]} -eq 0 ] || say "no time was left to build: ${unbuilt[*]}"
[ ${#unrun[@]} -eq 0 ] || say "no time was left to run: ${unrun[*]}"
[ ${#failed[@]} -eq 0 ] || die "failed with sanitizers: ${failed[*]}"
