#!/usr/bin/env bash
# Checks that all sources are as clang-format has them, then looks for faults with clang-tidy (.clang-tidy), in
# whole folders at once: those first in which most has changed (changed_files in lib.sh). Fails where something is
# found; what was left out is named. Without clang-tidy there is nothing to look for faults with, which it says.
#
#   deploy/lint.sh                      form alone: seconds
#   deploy/lint.sh --changed SOURCES    faults as well, in lines that have changed, of folders with so many sources
#                                       together: what the gate asks for, whatever the time
#   deploy/lint.sh SECONDS              faults of all folders, for that long, from another one on with each commit
#   deploy/lint.sh FILE...              form and faults of these
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

seconds= most_sources= files=()
case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
  '') ;;
  --changed)
    most_sources=${2:?--changed needs a number of sources}
    ;;
  *[!0-9]*) mapfile -t files < <(realpath --relative-to="$top" -- "$@") ;;
  *) seconds=$1 ;;
esac
command -v clang-format >/dev/null || die "there is no clang-format; deploy/setup.sh --ci installs it"
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

# changed_lines: clang-tidy's filter, [{"name":"proto/wire/limits.h","lines":[[3,5],[9,9]]},...], of what differs from
# the base (changed_files in lib.sh). Where that is too long for an argument, the files as a whole.
changed_lines() {
  git diff -U0 --diff-filter=d "$(base_commit)" -- '*.h' '*.cpp' | awk '
    /^\+\+\+ / {file = substr($2, 3); next}
    /^@@ / {count = split(substr($3, 2), range, ",") == 1 ? 1 : range[2]
            if (count > 0) lines[file] = lines[file] ",[" range[1] "," range[1] + count - 1 "]"}
    END {for (file in lines) {
           all = all ",{\"name\":\"" file "\",\"lines\":[" substr(lines[file], 2) "]}"
           files = files ",{\"name\":\"" file "\"}"
         }
         print "[" substr(length(all) < 100000 ? all : files, 2) "]"}'
}

# tidy UNIT: notes the unit, and fails when something is found in it. Does nothing once a time is over.
tidy() {
  local left result=0 said
  if [ -n "$deadline" ]; then
    left=$((deadline - $(date +%s)))
    [ "$left" -ge 10 ] || return 0
    said=$(timeout "$left" clang-tidy --quiet -p build/lint "$1" 2>&1) || result=$?
    [ $result -ne 124 ] || return 0
  else
    said=$(clang-tidy --quiet -p build/lint ${lines:+"--line-filter=$lines"} "$1" 2>&1) || result=$?
  fi
  echo "$1" >>"$work/checked.txt"
  [ $result -ne 0 ] || return 0
  # GCC has compiled it; that Clang does not, where it takes whole directories as one, is no fault of a line.
  if [ -n "$lines" ] && ! grep -q 'error: .*\[[bmpr][a-z]*-[a-z-]*\(,.*\)\?\]$' <<<"$said"; then
    echo "$1" >>"$work/uncompiled.txt"
    said=$(grep 'error: ' <<<"$said" | head -n 3)
    result=0
  fi
  printf '%s\n' "$said"
  return $((result != 0))
}

check_faults() {
  # Files from which headers of the lint build are generated may have changed, and so may the list of sources.
  build lint tessera_generated
  local all turn first lines=
  units >"$work/units.txt"
  mapfile -t all < <(cut -d ' ' -f 1 "$work/units.txt" | uniq)
  turn=$(($(git rev-list --count HEAD 2>/dev/null || echo 0) * 17 % ${#all[@]}))
  if [ ${#files[@]} -gt 0 ]; then
    first=("${files[@]}") all=()
  else
    mapfile -t first < <(changed_files)
    all=("${all[@]:turn}" "${all[@]:0:turn}")
    if [ -n "$most_sources" ]; then
      all=() lines=$(changed_lines)
    fi
  fi
  sources_of "${first[@]}" | sort -u >"$work/first.txt"
  { awk 'NR == FNR {first[$1]; next} $2 in first {n[$1]++} END {for (unit in n) print n[unit], unit}' \
    "$work/first.txt" "$work/units.txt" | sort -k1,1nr -k2 | cut -d ' ' -f 2 &&
    printf '%s\n' "${all[@]}"; } | awk 'NF && !seen[$0]++' >"$work/order.txt"
  # Folders that do not fit any more are left out, and smaller ones behind them are not.
  awk -v most="${most_sources:-0}" 'NR == FNR {n[$1]++; next} most == 0 || sum + n[$1] <= most {sum += n[$1]; print}' \
    "$work/units.txt" "$work/order.txt" >"$work/wanted.txt"

  begin "faults in $(sources_in "$work/wanted.txt") sources"
  : >"$work/checked.txt"
  : >"$work/uncompiled.txt"
  deadline=
  [ -z "$seconds" ] || deadline=$(($(date +%s) + seconds))
  export -f tidy
  export deadline work lines
  xargs -r -P "$(nproc)" -n 1 bash -c 'tidy "$0"' <"$work/wanted.txt" >"$work/found.txt" || {
    echo
    cat "$work/found.txt" >&2
    die "clang-tidy found faults"
  }
  end
  [ ! -s "$work/uncompiled.txt" ] || {
    say "NOT read to the end, as Clang does not compile them: $(sources_in "$work/uncompiled.txt") sources"
    cat "$work/found.txt"
  }
  grep -vxFf "$work/checked.txt" "$work/order.txt" >"$work/unread.txt" || return 0
  say "left out: $(sources_in "$work/unread.txt") sources, in"
  awk 'NR == FNR {unit[$1]; next} $1 in unit {sub("/[^/]*$", "", $2); print $2}' "$work/unread.txt" \
    "$work/units.txt" | sort -u | paste -sd ' '
}

# sources_in FILE: how many sources are in the units that the file lists.
sources_in() { awk 'NR == FNR {unit[$1]; next} $1 in unit' "$1" "$work/units.txt" | wc -l; }

check_form
[ -n "$seconds$most_sources${files[*]}" ] || exit 0
for tool in clang-tidy clang++; do
  command -v "$tool" >/dev/null || {
    say "NOT looked for faults: there is no $tool; deploy/setup.sh --ci installs it"
    exit 0
  }
done
check_faults
