#!/usr/bin/env bash
# Measures and draws what docs/integrators.md shows: for each scene, error over time and bias apart from variance of
# all integrators that can render it, and their pictures at equal time.
#
#   tests/bench/integrators.sh FOLDER [SCENE...]
#
# FOLDER holds the shared scenes (FOLDER/NAME/scene-bench.pbrt, unpacked). SCENE is a name of the list below; without
# one, all are measured. Writes plots and pictures to docs/integrators/, and the tables into docs/integrators.md, between
# the comments "<!-- NAME -->" and "<!-- /NAME -->". Settings, by environment variables:
#
#   SECONDS_A_PICTURE  CPU seconds that a picture at equal time may take (1)
#   SPP, SEEDS         sample counts and seeds of the measurement (1,4,16 and 4)
#   REFERENCE_SPP      samples of the references (2048)
#   REFERENCES         a folder that keeps references; those that are there are not rendered again (a temporary one)
#   TESSERA            the program (build/release/bin/tessera)
#   THREADS            tiles rendered at once (1)
set -euo pipefail
folder=${1:?the folder of the shared scenes is missing}
shift
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tessera=${TESSERA:-$root/build/release/bin/tessera}
page=$root/docs/integrators.md
out=$root/docs/integrators
picture=${SECONDS_A_PICTURE:-1}
measurement=(--spp "${SPP:-1,4,16}" --seeds "${SEEDS:-4}" --threads "${THREADS:-1}")
size=(--resolution 96x72)
occlusion=(--set ao.distance=1)  # of integrator ao
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
references=${REFERENCES:-$scratch}
mkdir -p "$out" "$references"

# Name, file, and the integrator that makes the reference: the first of these that there is.
scenes=(
  "cornell-box scenes/cornell-box/scene.pbrt path"
  "veach-mis $folder/veach-mis/scene-bench.pbrt path"
  "water-caustic $folder/water-caustic/scene-bench.pbrt photon"
  "classroom $folder/classroom/scene-bench.pbrt path"
  "staircase $folder/staircase/scene-bench.pbrt path"
  "glass-of-water scenes/glass-of-water/scene.textproto bdpt|path"
  "ring scenes/ring/scene.textproto bdpt|path"
  "door-ajar scenes/door-ajar/scene.textproto bdpt|path"
  "pool scenes/pool/scene.textproto photon"
  "museum-hall scenes/museum-hall/scene.textproto path"
)

# first_of NAME|NAME...: the first integrator that this build has.
first_of() {
  local name help
  help=$("$tessera" render --help)
  for name in ${1//|/ }; do
    if grep -q "^ \{10\}$name " <<<"$help"; then
      echo "$name"
      return
    fi
  done
}

# make_reference FILE INTEGRATOR REFERENCE: bench renders it, and measures next to nothing.
make_reference() {
  "$tessera" bench "$1" "${size[@]}" --integrator "$2" --spp 1 --seeds 1 --threads "${THREADS:-1}" --quiet \
    --make-reference "${REFERENCE_SPP:-2048}" --reference "$3" >/dev/null
}

# rows: from bench's text, but for volpath where path is there as well:
# "INTEGRATOR KIND SPP SECONDS BIAS2 VARIANCE" of the most samples.
rows() {
  awk '
    function row() {
      if (name != "") print name, kind, spp, cpu, bias2, variance
      name = ""; bias2 = variance = "-"
    }
    /^integrator=/ {row(); split($1, part, /[=,]/); name = part[2]; kind = $2; table = 0}
    /^ +spp +CPU s/ {table = 1}
    /^ +spp +variance/ {table = 2}
    table == 1 && /^ +[0-9]+ / {spp = $1; cpu = $2}
    table == 2 && /^ +[0-9]+ / {variance = $2; bias2 = $5 == "biased" ? $3 : "not seen"}
    /slope of MSE|rays a sample/ {table = 0}
    /^efficiency of/ {row()}
    END {row()}' OFS=';' "$1" | awk -F';' '$1 == "path" {path = 1} !(path && $1 == "volpath")'  # the same picture
}

# shellcheck disable=SC2016  # backquotes are Markdown's
# draw NAME FILE REFERENCE INTEGRATOR: pictures at equal time, and the section of the page as $scratch/NAME.md.
draw() {
  local name=$1 file=$2 reference=$3 best=$4 integrator kind spp cpu bias2 variance count relmse own
  {
    printf '| integrator | kind | samples in %s CPU s | relMSE | bias^2 | variance of one with %s samples | |\n' \
      "$picture" "$(tail -1 "$scratch/$name.rows" | cut -d';' -f3)"
    printf '|---|---|---|---|---|---|---|\n'
    while IFS=';' read -r integrator kind spp cpu bias2 variance; do
      count=$(awk -v t="$picture" -v s="$spp" -v c="$cpu" 'BEGIN {n = int(t * s / c + 0.5); print n < 1 ? 1 : n}')
      own=()
      if [ "$integrator" = ao ]; then own=("${occlusion[@]}"); fi
      "$tessera" render "$file" "${size[@]}" "${own[@]}" --integrator "$integrator" --spp "$count" --quiet \
        --threads "${THREADS:-1}" -o "$scratch/picture.exr" >&2
      "$tessera" convert "$scratch/picture.exr" "$out/$name-$integrator.png" >&2
      relmse=$("$tessera" compare "$reference" "$scratch/picture.exr" --json |
        sed -n 's/.*"relmse": *\([^,]*\),.*/\1/p' | head -1)
      printf '| `%s` | %s | %s | %.3g | %s | %s | ![%s](integrators/%s-%s.png) |\n' "$integrator" "$kind" "$count" \
        "$relmse" "$bias2" "$variance" "$integrator" "$name" "$integrator"
    done <"$scratch/$name.rows"
    printf '\nReference: %s samples of `%s`.\n' "${REFERENCE_SPP:-2048}" "$best"
    sed -n 's/^not measured: integrator=\([^:]*\): \(.*\)/\n`\1` is not there: \2./p' "$scratch/$name.txt"
    printf '\n![Error over time](integrators/%s.svg)\n' "$name"
  } >"$scratch/$name.md"
}

# insert NAME FILE: puts the file between the comments of the page.
insert() {
  awk -v begin="<!-- $1 -->" -v end="<!-- /$1 -->" -v file="$2" '
    $0 == end {skip = 0}
    !skip {print}
    $0 == begin {skip = 1; while ((getline line < file) > 0) print line}' "$page" >"$scratch/page.md"
  cp "$scratch/page.md" "$page"
}

cd "$root"
for entry in "${scenes[@]}"; do
  read -r name file best <<<"$entry"
  if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then continue; fi
  echo "== $name" >&2
  reference=$references/$name.exr
  best=$(first_of "$best")
  [ -e "$reference" ] || make_reference "$file" "$best" "$reference"
  "$tessera" bench "$file" "${size[@]}" "${occlusion[@]}" "${measurement[@]}" --quiet \
    --compare integrator=all \
    --reference "$reference" --plot "$scratch/plot.svg" >"$scratch/$name.txt"
  # Tenths of a point are enough: half of the size.
  sed -E 's/([0-9]\.[0-9])[0-9]+/\1/g' "$scratch/plot.svg" >"$out/$name.svg"
  cp "$scratch/$name.txt" "$references/"
  rows "$scratch/$name.txt" >"$scratch/$name.rows"
  draw "$name" "$file" "$reference" "$best"
  insert "$name" "$scratch/$name.md"
done
