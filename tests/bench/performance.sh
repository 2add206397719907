#!/usr/bin/env bash
# Measures the table and the plot of docs/performance.md and prints the table.
#
#   tests/bench/performance.sh FOLDER [options of tessera bench]
#
# FOLDER holds the shared scenes (FOLDER/NAME/scene-bench.pbrt). Leaves performance.txt, performance.json and performance.svg in the
# current directory. Options given come after those here and add to them, e.g. --resolution 320x180.
set -euo pipefail
folder=${1:?the folder of the scenes is missing}
shift
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
"$root/build/release/bin/tessera" bench "$folder"/*/scene-bench.pbrt --sampler sobol --quiet \
  --json performance.json --plot performance.svg "$@" | tee performance.txt >&2

awk '
  function row() {
    if (name != "") printf "| %s | %s | %s | %s | %s | %s | %s | %s |\n", name, cpu, relmse, flip, efficient, slope, speed, share
    name = ""; slope = share = "-"
  }
  BEGIN {
    print "| scene | CPU s | relMSE | FLIP | efficiency | slope | Mray/s | of the rays alone |"
    print "|---|---|---|---|---|---|---|---|"
  }
  / pixels, / {row(); name = $1 " (" $2 ")"}
  /^ +[0-9]+ / {cpu = $2; relmse = $4; flip = $6; efficient = $10; speed = $NF}  # the last: the most samples
  /slope of MSE/ {slope = $6}
  /of the rays alone/ {share = $5 " %"}
  END {row()}' performance.txt
