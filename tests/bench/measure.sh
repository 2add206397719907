#!/usr/bin/env bash
# Measures what measuring costs, for people: it refuses nothing. First, `tessera measure` against a picture of the same
# plane whose pixels are averaged, at equal error, in three daylit rooms; then a grid on two workers of one thread over one;
# then the fixed price of a measurement and of its rounds.
#
#   tests/bench/measure.sh             the tables, in Markdown
#
# The picture is the cheapest that one would take: the floor, which is diffuse, seen from a centimetre above by a parallel
# camera; pi times its radiance over its reflectance is the illuminance. A cell of the meter is 8 x 8 of its pixels, and
# takes as many samples as these. Errors are those of cells against a run of 16 times the samples. Settings, by environment
# variables:
#
#   TESSERA    the program (build/release/bin/tessera); the coordinator and the worker lie beside it
#   SAMPLES    of each cell, a multiple of 64 (1024)
#   RUNS       of other seeds (3)
#   PATIENCE   seconds that one worker has for its grid, about (20)
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tessera=${TESSERA:-$root/build/release/bin/tessera}
samples=${SAMPLES:-1024}
runs=${RUNS:-3}
patience=${PATIENCE:-20}
columns=16 rows=28 block=8

scratch=$(mktemp -d)
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$scratch"
}
trap cleanup EXIT
trap 'exit 130' INT TERM
cd "$scratch"
mkdir rooms
ln -s "$root/scenes/shapes" shapes
calculate() { awk "BEGIN {printf \"%.6g\", $1}"; }

# cpu_seconds COMMAND...: its CPU time, and that of what it started.
cpu_seconds() {
  local TIMEFORMAT='%U %S'
  { time "$@" >log 2>&1; } 2>spent.txt || {
    cat log >&2
    exit 1
  }
  awk '{print $1 + $2}' spent.txt
}
# seconds COMMAND...: its run time.
seconds() {
  local begin=$EPOCHREALTIME
  "$@" >log 2>&1 || {
    cat log >&2
    exit 1
  }
  calculate "$EPOCHREALTIME - $begin"
}

# --- the rooms: NAME.textproto without a camera, and the plane of its floor as $corner, $edge_u, $edge_v

hall=$root/scenes/museum-hall/daylight.textproto
without_camera() { sed '/^camera {/,/^}/d; /^film/d; /^settings/d' "$hall"; }
without_camera >rooms/hall-clear.textproto
without_camera | sed 's/cie_type: 12/cie_type: 1/' >rooms/hall-overcast.textproto

# An office, 4 m x 7 m, whose window of 3 m x 1.5 m looks south; y is up.
wall() { # MATERIAL X0,Y0,Z0 X1,Y1,Z1: a box between two corners
  awk -v material="$1" -v low="$2" -v high="$3" 'BEGIN {
    split(low, a, ","); split(high, b, ",")
    printf "shapes { box { low: [%s] high: [%s] } material: \"%s\" }\n", low, high, material}'
}
{
  sed -n '1,2p' "$hall"
  echo 'units { metres: 1 }'
  sed -n '/^lights {/,/^}/p' "$hall" | sed 's/cie_type: 12/cie_type: 16/'
  for paint in floor:0.3 wall:0.6 ceiling:0.8; do
    value=${paint#*:}
    echo "materials { name: '${paint%:*}' diffuse { reflectance { constant { rgb { r: $value g: $value b: $value } } } } }"
  done
  wall floor -2.1,-0.1,-0.1 2.1,0,7.1
  wall ceiling -2.1,3,-0.1 2.1,3.1,7.1
  wall wall -2.1,0,-0.1 -2,3,7.1
  wall wall 2,0,-0.1 2.1,3,7.1
  wall wall -2,0,7 2,3,7.1
  wall wall -2,0,-0.1 2,1,0
  wall wall -2,2.5,-0.1 2,3,0
  wall wall -2,1,-0.1 -1.5,2.5,0
  wall wall 1.5,1,-0.1 2,2.5,0
} >rooms/office.textproto

# plane ROOM: half the width along x, half the depth along z, the middle's z.
plane() { if [ "$1" = office ]; then echo 1.9 3.4 3.5; else echo 3.8 6.8 7; fi; }

# write_meter ROOM FILE: the floor's illuminance in cells. Meters see no picture, but scenes have one.
write_meter() {
  local half_x half_z middle
  cp "rooms/$1.textproto" "rooms/$1-meter.textproto"
  echo 'camera { orthographic {} } film { width: 1 height: 1 }' >>"rooms/$1-meter.textproto"
  read -r half_x half_z middle <<<"$(plane "$1")"
  cat >"$2" <<END
# proto-file: proto/tessera/v1/meter.proto
# proto-message: tessera.v1.MeterList
up: Y
meters { name: "floor" irradiance { receivers { plane { columns: $columns rows: $rows flip: true
  corner { x: -$half_x y: 0.01 z: $(calculate "$middle - $half_z") }
  edge_u { x: $(calculate "2 * $half_x") } edge_v { z: $(calculate "2 * $half_z") } } } } }
END
}
# write_picture ROOM FILE: the scene with a camera that sees the same.
write_picture() {
  local half_x half_z middle
  read -r half_x half_z middle <<<"$(plane "$1")"
  cp "rooms/$1.textproto" "$2"
  cat >>"$2" <<END
camera { orthographic {} screen_window: [-$half_x, $half_x, -$half_z, $half_z]
  world_from_camera { elements: [1, 0, 0, 0,  0, 0, -1, 0.01,  0, 1, 0, $middle,  0, 0, 0, 1] } }
film { width: $((columns * block)) height: $((rows * block)) filter { kind: BOX radius_x: 0.5 radius_y: 0.5 } }
END
}

# measure ROOM SEED SAMPLES OUT, picture ROOM SEED SAMPLES OUT: with OUT as an EXR.
measure() {
  "$tessera" measure "rooms/$1-meter.textproto" "$1.meters" --samples "$3" --seed "$2" --threads 1 --quiet --integrator path \
    --maps "$4.maps"
  mv "$4.maps/1-1.exr" "$4"
}
picture() {
  "$tessera" render "rooms/$1-picture.textproto" --spp $(($3 / block / block)) --seed "$2" --threads 1 --quiet \
    --integrator path --max-depth 4096 -o "$4"
}
# relative_mse REFERENCE TEST BLOCK: mean square of the relative errors of blocks.
relative_mse() {
  "$tessera" compare "$1" "$2" --json --block "$3" | awk -v block="$3" -F'[:,]' '/"relmse_block"/ {print $2 / block / block}'
}

echo "| room | by | CPU s | of them fixed | relative error of cells | CPU s at 1 % | over the meter's |"
echo "|---|---|---|---|---|---|---|"
for room in hall-clear hall-overcast office; do
  write_meter "$room" "$room.meters"
  write_picture "$room" "rooms/$room-picture.textproto"
  meters_cost=
  for way in measure picture; do
    cells=$([ "$way" = measure ] && echo 1 || echo "$block")
    fixed=$(cpu_seconds "$way" "$room" 1 64 small.exr)
    "$way" "$room" 99 $((16 * samples)) reference.exr >log 2>&1
    cpu=0 mse=0
    for run in $(seq "$runs"); do
      cpu=$(calculate "$cpu + $(cpu_seconds "$way" "$room" $((1000 * run)) "$samples" test.exr) / $runs")
      mse=$(calculate "$mse + $(relative_mse reference.exr test.exr "$cells") / $runs")
    done
    # Time beyond the fixed price is one over the square of the error.
    cost=$(calculate "$fixed + ($cpu - $fixed) * $mse / 0.01 ^ 2")
    meters_cost=${meters_cost:-$cost}
    printf '| %s | %s | %.2f | %.2f | %.2f %% | %.2f | %.2f |\n' "$room" "$way" "$cpu" "$fixed" \
      "$(calculate "100 * sqrt($mse)")" "$cost" "$(calculate "$cost / $meters_cost")"
  done
done

# --- workers

# start_farm WORKERS: sets $server.
start_farm() {
  local bin data
  bin=$(dirname "$tessera") data=$(mktemp -d -p "$scratch")
  "$bin/tessera-server" --listen 127.0.0.1:0 --data "$data/server" >"$data/server.log" 2>&1 &
  pids+=($!)
  server=
  for _ in $(seq 100); do
    server=$(sed -n 's/.*listening on \(127\.0\.0\.1:[0-9]*\).*/\1/p' "$data/server.log" | head -n 1)
    if [ -n "$server" ]; then break; fi
    sleep 0.1
  done
  if [ -z "$server" ]; then
    cat "$data/server.log" >&2
    exit 1
  fi
  for worker in $(seq "$1"); do
    "$bin/tessera-worker" --server "$server" --threads 1 --cache "$data/cache$worker" >"$data/worker$worker.log" 2>&1 &
    pids+=($!)
  done
}
# on_farm SERVER SEED SAMPLES: the grid of the overcast hall.
on_farm() {
  "$tessera" measure rooms/hall-overcast-meter.textproto hall-overcast.meters --samples "$3" --seed "$2" --quiet \
    --integrator path --farm --server "$1" -o grid.csv
}

start_farm 1
one=$server
start_farm 2
two=$server
# The first jobs bring the scene to the workers.
on_farm "$one" 1 64 >log 2>&1
on_farm "$two" 1 64 >log 2>&1
# Samples for about the time that one worker may take.
trial=$(seconds on_farm "$one" 2 1024)
many=$(awk -v t="$trial" -v p="$patience" 'BEGIN {n = int(1024 * p / t / 64) * 64; print n < 1024 ? 1024 : n}')
echo
echo "| run | samples of a cell | one worker, s | two workers, s | gain |"
echo "|---|---|---|---|---|"
for run in $(seq "$runs"); do
  alone=$(seconds on_farm "$one" $((1000 * run)) "$many")
  together=$(seconds on_farm "$two" $((1000 * run)) "$many")
  printf '| %d | %d | %.2f | %.2f | %.3f |\n' "$run" "$many" "$alone" "$together" "$(calculate "$alone / $together")"
done

# --- fixed prices

cat >point.meters <<'END'
up: Y
meters { name: "point" irradiance { receivers { point { position { y: 1 z: 5 } } } } }
END
local_point() {
  "$tessera" measure rooms/hall-overcast-meter.textproto point.meters --seed "$1" --threads 1 --integrator path -o point.csv "${@:2}"
}
farm_point() { local_point "$1" --farm --server "$one" --samples 1024; }
echo
echo "| a point of the hall | s |"
echo "|---|---|"
printf '| in this process, 1024 samples, one job | %.3f |\n' "$(seconds local_point 1 --samples 1024)"
printf '| on a farm, one job | %.3f |\n' "$(seconds farm_point 5)"
several=$(seconds local_point 1 --error 0.003)
# A line of progress a round, and the samples that they took.
rounds=$(grep -c 'samples: the worst figure' log || true)
taken=$(sed -n 's/^\([0-9]*\) samples: .*/\1/p' log | tail -n 1)
printf '| to .3 %%, by %d rounds, %s samples | %.3f |\n' "$rounds" "$taken" "$several"
printf '| as many samples by one round | %.3f |\n' "$(seconds local_point 1 --samples "$taken")"
