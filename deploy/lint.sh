#!/usr/bin/env bash
# Checks that all sources are as clang-format has them, then looks for faults with clang-tidy (.clang-tidy), in
# whole folders at once and in as many as a time allows: those first in which most has changed (changed_files in
# lib.sh), then the others, from another one on with each commit. Fails where something is found, not where time
# runs out: what was left out is named.
#
#   deploy/lint.sh                      form alone: seconds
#   deploy/lint.sh SECONDS              faults as well, for that long
#   deploy/lint.sh --changed SECONDS    the same of folders in which something has changed, without the others
#   deploy/lint.sh FILE...              form and faults of these
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

budget=0 files=() only_changed=
case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
  '') ;;
  --changed)
    only_changed=1
    budget=${2:?--changed needs a time, in seconds}
    ;;
  *[!0-9]*)
    mapfile -t files < <(realpath --relative-to="$top" -- "$@")
    budget=$((24 * 60 * 60))
    ;;
  *) budget=$1 ;;
esac
for tool in clang-format clang-tidy clang++; do
  command -v "$tool" >/dev/null || die "there is no $tool; deploy/setup.sh --ci installs it"
done
cd "$top"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

check_form() {
  local sources=("${files[@]}")
  [ ${#sources[@]} -gt 0 ] ||
    mapfile -t sources < <(git ls-files --cached --others --exclude-standard -- '*.h' '*.cpp' '*.proto')
  begin "form of ${#sources[@]} files"
  clang-format --dry-run --Werror "${sources[@]}" 2>"$work/form.txt" || {
    echo
    cat "$work/form.txt" >&2
    die "not as clang-format has them; clang-format -i FILE mends that"
  }
  end
}

# Sources that `build/lint` compiles as one, and each source in it, one pair a line: whole rooms, or single sources.
units() {
  local unit
  sed -n 's,^ *"file": "\(.*\)".*,\1,p' build/lint/compile_commands.json | awk '!seen[$0]++' |
    while IFS= read -r unit; do
      case $unit in
        */Unity/*) sed -n "s,^#include \"$top/\(.*\)\",$unit \1,p" "$unit" ;;
        *) echo "$unit ${unit#"$top/"}" ;;
      esac
    done | grep -v ' build/'
}

# sources_of FILE...: sources as they are; for a header, the first source that includes it.
sources_of() {
  local file
  for file in "$@"; do
    case $file in
      *.cpp) echo "$file" ;;
      *.h) cut -d ' ' -f 2 "$work/units.txt" | xargs grep -lF "\"${file#*/}\"" | head -n 1 || true ;;
    esac
  done
}

# tidy UNIT: notes the unit, and fails when something is found in it. Does nothing once the time is over.
tidy() {
  local left=$((deadline - $(date +%s))) result=0 said
  [ "$left" -ge 10 ] || return 0
  said=$(timeout "$left" clang-tidy --quiet -p build/lint "$1" 2>&1) || result=$?
  [ $result -ne 124 ] || return 0
  echo "$1" >>"$work/checked.txt"
  [ $result -eq 0 ] || {
    printf '%s\n' "$said"
    return 1
  }
}

check_faults() {
  # Files from which headers of the lint build are generated may have changed, and so may the list of sources.
  build lint tessera_generated
  local all turn first
  units >"$work/units.txt"
  mapfile -t all < <(cut -d ' ' -f 1 "$work/units.txt" | uniq)
  turn=$(($(git rev-list --count HEAD 2>/dev/null || echo 0) * 17 % ${#all[@]}))
  if [ ${#files[@]} -gt 0 ]; then
    first=("${files[@]}") all=()
  else
    mapfile -t first < <(changed_files)
    all=("${all[@]:turn}" "${all[@]:0:turn}")
    [ -z "$only_changed" ] || all=()
  fi
  sources_of "${first[@]}" | sort -u >"$work/first.txt"
  { awk 'NR == FNR {first[$1]; next} $2 in first {n[$1]++} END {for (unit in n) print n[unit], unit}' \
    "$work/first.txt" "$work/units.txt" | sort -k1,1nr -k2 | cut -d ' ' -f 2 &&
    printf '%s\n' "${all[@]}"; } | awk 'NF && !seen[$0]++' >"$work/order.txt"

  begin "faults in $(sources_in "$work/order.txt") sources"
  : >"$work/checked.txt"
  deadline=$(($(date +%s) + budget))
  export -f tidy
  export deadline work
  xargs -P "$(nproc)" -n 1 bash -c 'tidy "$0"' <"$work/order.txt" >"$work/found.txt" || {
    echo
    cat "$work/found.txt" >&2
    die "clang-tidy found faults"
  }
  end
  grep -vxFf "$work/checked.txt" "$work/order.txt" >"$work/unread.txt" || return 0
  say "no time was left for $(sources_in "$work/unread.txt") of them, in"
  awk 'NR == FNR {unit[$1]; next} $1 in unit {sub("/[^/]*$", "", $2); print $2}' "$work/unread.txt" \
    "$work/units.txt" | sort -u | paste -sd ' '
}

# sources_in FILE: how many sources are in the units that the file lists.
sources_in() { awk 'NR == FNR {unit[$1]; next} $1 in unit' "$1" "$work/units.txt" | wc -l; }

check_form
[ "$budget" -eq 0 ] || check_faults
