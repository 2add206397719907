#!/usr/bin/env bash
# Installs what the target `programs` of a build has made, into a prefix and below DESTDIR, and uses it from
# there.
#
#   install_test.sh BUILD
#
# Exit status 77 where the Python package's own needs are missing and nothing else was wrong.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
cd "$work"

die() {
  echo "install_test: $*" >&2
  exit 1
}
has() { grep -qF -- "$2" "$1" || die "$1 lacks: $2"; }

cmake --install "$build" --prefix "$prefix" >install.log ||
  die "cmake --install failed: $(tail -n 5 install.log)"

# Programs and modules: nothing is taken from the build.
PATH=$prefix/bin:/usr/bin:/bin
for program in tessera tessera-server tessera-worker; do
  [ "$("$prefix/bin/$program" --version)" = "$("$build/bin/$program" --version)" ] || die "$program --version"
done
for module in "$build"/lib/libtessera_{images,assimp,kernel_*,spectral_*}.so; do
  case $module in *\**) continue ;; esac  # a build without kernels
  [ -e "$prefix/lib/${module##*/}" ] || die "${module##*/} is not installed"
done
printf '%s\n' solid 'facet normal 0 0 1' 'outer loop' 'vertex 0 0 0' 'vertex 1 0 0' 'vertex 0 1 0' endloop \
  endfacet endsolid >triangle.stl
tessera convert triangle.stl triangle.textproto --quiet || die "STL, by the module for it"
if ls "$build"/lib/libtessera_kernel_*.so >/dev/null 2>&1; then
  # The loader tells which files it opens.
  LD_DEBUG=files LD_DEBUG_OUTPUT=loader tessera render "$top/scenes/cornell-box/scene.pbrt" -o box.png \
    --spp 4 --resolution 32x32 --quiet || die "a picture"
  [ -s box.png ] || die "no picture"
  cat loader.* | grep -F "calling init: $prefix/bin/../lib/libtessera_kernel_" >/dev/null ||
    die "no kernels of the prefix"
  if cat loader.* | grep -F "calling init: $build"; then die "something is taken from the build"; fi
fi

# Completions and manual pages: of all programs, and of all commands.
for program in tessera tessera-server tessera-worker; do
  has "$prefix/share/bash-completion/completions/$program" "complete -o default -F _$program $program"
  has "$prefix/share/zsh/site-functions/_$program" "#compdef $program"
  has "$prefix/share/fish/vendor_completions.d/$program.fish" "complete -c $program"
  has "$prefix/share/man/man1/$program.1" '.SH SYNOPSIS'
done
words=$(bash -c '. "$0"; COMP_WORDS=(tessera ren); COMP_CWORD=1; _tessera; echo "${COMPREPLY[*]}"' \
  "$prefix/share/bash-completion/completions/tessera")
[ "$words" = render ] || die "bash completes 'tessera ren' by '$words'"
for command in $(bash -c '. "$0"; COMP_WORDS=(tessera ""); COMP_CWORD=1; _tessera; echo "${COMPREPLY[*]}"' \
  "$prefix/share/bash-completion/completions/tessera"); do
  has "$prefix/share/man/man1/tessera-$command.1" '.SH SYNOPSIS'
done

for file in LICENSE README.md docs/farm.md; do
  cmp -s "$top/$file" "$prefix/share/doc/tessera/$file" || die "share/doc/tessera/$file"
done
has "$prefix/lib/systemd/system/tessera-server.service" "ExecStart=$prefix/bin/tessera-server "

# A package is made like this: files below DESTDIR know of the prefix alone.
DESTDIR=$work/staged cmake --install "$build" --prefix /usr >>install.log || die "cmake --install, DESTDIR"
[ "$("$work/staged/usr/bin/tessera" --version)" = "$(tessera --version)" ] || die "tessera below DESTDIR"
has "$work/staged/usr/lib/systemd/system/tessera-worker.service" "ExecStart=/usr/bin/tessera-worker "
if grep -rlF -e "$work" staged; then die "files below DESTDIR name it"; fi

# The Python package, its messages included.
package=$(dirname "$(find "$prefix" -path '*/tessera/__init__.py')")
[ -d "$package" ] || die "no Python package"
for module in numpy grpc zstandard google.protobuf; do
  python3 -c "import $module" 2>/dev/null || {
    echo "install_test: needs the module $module of Debian's packages"
    [ -z "${TESSERA_SKIPS:-}" ] || echo "install_test: needs the module $module" >>"$TESSERA_SKIPS"
    exit 77
  }
done
PYTHONPATH=${package%/tessera} python3 -c '
import sys, tessera
from tessera.v1 import job_pb2
assert tessera.__file__.startswith(sys.argv[1]), tessera.__file__
scene = tessera.Scene("ball")
scene.sphere(1.0, (0, 1, 0), scene.diffuse("red", (0.7, 0.1, 0.1)))
scene.environment(1.0)
scene.camera(tessera.look_at((0, 2, 6), (0, 1, 0)), fov=40)
scene.film(16, 16)
scene.save("ball.textproto")' "$prefix" || die "import tessera"
! ls "$build"/lib/libtessera_kernel_*.so >/dev/null 2>&1 ||
  tessera render ball.textproto -o ball.png --spp 4 --quiet || die "the scene that Python has made"
