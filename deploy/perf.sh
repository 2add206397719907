#!/usr/bin/env bash
# Tells what rendering costs, for people: it refuses nothing. First the instructions that some jobs take, which a loaded
# machine does not change, beside the counts on record (docs/bench/instructions.tsv); then run time against error, and
# against the figures of the last release.
#
# `perf` counts instructions where the machine lets it, else valgrind does (AVX2 kernels; 20 to 50 times slower).
#
#   deploy/perf.sh                     on what deploy/test.sh has built
#   deploy/perf.sh --record            adds its counts to those on record, too
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
esac
tessera=$top/build/release/bin/tessera
record=$top/docs/bench/instructions.tsv
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$top"

# One thread, and no choice that goes by measured time: what is counted depends on the program alone.
jobs=(
  "cornell-box/scene.pbrt --spp 16 --path-sharing off"
  "cornell-box/scene.pbrt --spp 16 --path-sharing 16"
  "museum-hall/scene.textproto --spp 16 --path-sharing off"
  "forest/scene.textproto --spp 4 --path-sharing off"
  "machine-part/scene.pbrt --spp 4 --path-sharing off"
  "glass-of-water/scene.textproto --spp 4 --integrator bdpt"
)

# count COMMAND...: millions of instructions in user mode; nothing where they cannot be counted.
if perf stat -x, -e instructions:u -o "$work/perf" true 2>/dev/null && grep -q '^[0-9]' "$work/perf"; then
  counter=perf isa=()
  count() {
    perf stat -x, -e instructions:u -o "$work/perf" "$@" >/dev/null
    awk -F, '/^[0-9]/ {printf "%.1f", $1 / 1e6}' "$work/perf"
  }
elif command -v valgrind >/dev/null; then
  counter=valgrind isa=(--isa avx2)
  count() {
    valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null "$@" 2>&1 >/dev/null |
      awk '/I *refs:/ {gsub(",", ""); printf "%.1f", $NF / 1e6}'
  }
else
  counter=
  say "instructions are not counted: there is neither perf with counters nor valgrind"
fi

if [ -n "$counter" ]; then
  commit=$(git rev-parse --short=12 HEAD 2>/dev/null || echo unknown)
  say "millions of instructions, by $counter; ratio to the last on record, and those before it"
  for job in "${jobs[@]}"; do
    # shellcheck disable=SC2086
    millions=$(count "$tessera" render scenes/$job --resolution 64x64 --threads 1 --quiet "${isa[@]}" -o "$work/out.exr")
    awk -F '\t' -v job="$job" -v counter="$counter" -v now="$millions" '
      $3 == counter && $4 == job {trend = trend " " $5; last = $5}
      END {printf "%10.1f %7s  %-60s%s\n", now, last ? sprintf("%.3f", now / last) : "-", job, trend}' "$record"
    printf '%s\t%s\t%s\t%s\t%s\n' "$(date -u +%F)" "$commit" "$counter" "$job" "$millions" >>"$work/counts"
  done
  [ "${1:-}" != --record ] || cat "$work/counts" >>"$record"
fi

measure() {
  say "run time against error"
  "$tessera" bench --quiet --resolution 160x120 --sampler sobol --spp 4,16 --seeds 3 --make-reference 512 \
    --against "$(printf '%s\n' docs/bench/*.json | sort -V | tail -1)" "$@"
}
scenes=$(realpath -m ../shared/scenes/pbrt)
if [ -f "$scenes/classroom.tar.xz" ]; then
  tar xJf "$scenes/classroom.tar.xz" -C "$work"
  measure "$scenes/cornell-box/scene-bench.pbrt" "$work/classroom/scene-bench.pbrt"
else
  measure scenes/cornell-box/scene.pbrt
fi
