#!/usr/bin/env bash
# Measures what docs/performance.md shows, in one command: its table, its plots, and docs/bench/VERSION.json, with which
# `tessera bench --against` compares later versions.
#
#   tests/bench/performance.sh FOLDER [options of tessera bench]
#
# FOLDER holds the shared scenes (FOLDER/NAME/scene-bench.pbrt). Leaves performance.md, .txt, .json and .svg in the
# current directory. Options given come after those here and add to them; with any, nothing under docs/ is written.
# Settings, by environment variables:
#
#   TESSERA     the program (build/release/bin/tessera)
#   REFERENCES  a folder that keeps references; those that are there are not rendered again (a temporary one)
set -euo pipefail
folder=${1:?the folder of the scenes is missing}
shift
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tessera=${TESSERA:-$root/build/release/bin/tessera}
own=(forest glass-of-water machine-part museum-hall) # of scenes/: instances, glass, solids, a room of many lamps
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
references=${REFERENCES:-$scratch}
here=$PWD
mkdir -p "$references"

# The scenes, each called by its folder.
files=()
for file in "$folder"/*/scene-bench.pbrt; do files+=("$(realpath "$file")"); done
for name in "${own[@]}"; do files+=("$root/scenes/$name"/scene.*); done

# Every reference is made once, with twice the samples that bench asks for.
list=""
for file in "${files[@]}"; do
  name=$(basename "$(dirname "$file")")
  reference=$references/$name.exr
  if [ ! -e "$reference" ]; then
    echo "== reference of $name" >&2
    "$tessera" bench "$file" --resolution 160x120 --sampler sobol --quiet --spp 1 --seeds 1 --threads 2 \
      --make-reference 512 --reference "$reference" >/dev/null
  fi
  list+=${list:+,}$reference
done
"$tessera" bench "${files[@]}" --resolution 160x120 --sampler sobol --spp 4,16 --seeds 3 --whole --quiet \
  --reference "$list" --json performance.json --plot performance.svg "$@" | tee performance.txt >&2

awk '
  function row() {
    if (name != "") printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name, cpu, whole,
      relmse, trimmed, means, flip, efficient, of_means, slope, speed, share
    name = ""; slope = share = "-"; processes = 0
  }
  BEGIN {
    print "| scene | CPU s | whole process | relMSE | less 0.1 % | of 8x8 | FLIP | efficiency | of 8x8 | slope | " \
      "Mray/s | of the rays alone |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|"
  }
  / pixels, / {row(); name = $1 " (" $2 ")"}
  /^whole processes/ {processes = 1}
  # The last row of a table: the most samples.
  !processes && /^ +[0-9]+ / && NF > 9 {
    cpu = $2; relmse = $4; trimmed = $5; means = $6; flip = $7; efficient = $11; of_means = $(NF - 1)
    speed = $NF
  }
  processes && /^ +[0-9]+ / && NF > 5 {whole = $2}
  /slope of MSE/ {slope = $6}
  /of the rays alone/ {share = $5 " %"}
  /^machine: / {row(); sub(/^machine: /, ""); printf "\n%s.\n", $0}
  /^LOADED/ {print; print ""}
  END {row()}' performance.txt >performance.md
cat performance.md

if [ $# -gt 0 ]; then exit; fi
# Tenths of a point are enough: half of the size.
sed -E 's/([0-9]\.[0-9])[0-9]+/\1/g' performance.svg >"$root/docs/performance.svg"
mkdir -p "$root/docs/bench"
sed "s#$references/##g" performance.json >"$root/docs/bench/$("$tessera" --version | awk '{print $NF}').json"
awk -v file="$here/performance.md" '
  $0 == "<!-- /table -->" {skip = 0}
  !skip {print}
  $0 == "<!-- table -->" {skip = 1; while ((getline line < file) > 0) print line}' "$root/docs/performance.md" \
  >"$scratch/page.md"
cp "$scratch/page.md" "$root/docs/performance.md"
