#!/usr/bin/env bash
# Builds the programs for 64-bit ARM on an x86-64 machine, into build/arm64, and tries them with qemu: a picture
# of cornell-box must be that of the programs in build/release, which must be there.
#
#   sudo deploy/arm64.sh FOLDER
#
# FOLDER becomes a Debian 12 with the compiler and the libraries (2.3 GB; 5 minutes, and 10 for building):
# Debian's packages for developers do not fit beside those of another architecture. A second run only does what
# is left to do.
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# Within the folder: installs, builds, tries.
inside() {
  "$top/deploy/setup.sh" --arm64
  build arm64 tessera tessera-server tessera-worker
  begin "trying build/arm64"
  cd "$top"
  # The module is compiled for processors with cryptography (deploy/cmake/TesseraTargets.cmake), and must do
  # without.
  local listing=build/arm64/kernel.s
  aarch64-linux-gnu-objdump -d build/arm64/lib/libtessera_kernel_neon.so >$listing
  if grep -qE '\s(aes|sha|pmull)[0-9a-z]*\s' $listing; then
    die "the kernels have instructions that not every processor has"
  fi
  qemu-aarch64-static -cpu cortex-a53 build/arm64/bin/tessera render "${view[@]}" -o build/arm64/neon.exr
  end
}

view=(scenes/cornell-box/scene.pbrt --resolution 32x32 --spp 64 --quiet)
case "${1:-}" in
  '' | -*)
    usage
    exit 2
    ;;
  inside)
    inside
    exit 0
    ;;
esac

[ "$(uname -m)" = x86_64 ] || die "this is for x86-64 machines; on ARM, deploy/test.sh builds as anywhere"
tessera=$top/build/release/bin/tessera
[ -x "$tessera" ] || die "there is no $tessera to compare with; build it first (deploy/demo.sh)"
[ "$(id -u)" -eq 0 ] || die "needs root, for a system in a folder"
mkdir -p "$1"
root=$(cd "$1" && pwd)
if [ ! -e "$root/etc/debian_version" ]; then
  command -v debootstrap >/dev/null || die "needs debootstrap: apt-get install debootstrap"
  begin "making a Debian 12 in $root"
  debootstrap --variant=minbase bookworm "$root" >"$root.log" ||
    die "debootstrap failed; what it said is in $root.log"
  end
fi

# The source tree lies within the folder where it lies without, as build files hold its path. The mounts end with
# the command.
mkdir -p "$root$top"
unshare --mount --propagation private bash -euc '
  mount --bind "$1" "$0$1"
  mount -t proc proc "$0/proc"
  mount --rbind /dev "$0/dev"
  exec chroot "$0" /usr/bin/env HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin "$1/deploy/arm64.sh" inside
' "$root" "$top"

# Both render the same samples: what is left is rounding (relMSE 1e-14), and perhaps a path that goes another way
# for it: one sample of 64, ten times as bright as its pixel, in one pixel of 1024, is (10 / 64)^2 / 1024 = 2e-5.
# Other samples give 3e-3 or more.
cd "$top"
"$tessera" render "${view[@]}" -o build/arm64/reference.exr
"$tessera" compare build/arm64/reference.exr build/arm64/neon.exr
"$tessera" compare --json build/arm64/reference.exr build/arm64/neon.exr |
  awk -F '[:,]' '/"relmse"/ {found = 1; same = $2 < 1e-4} END {exit !(found && same)}' ||
  die "the picture of build/arm64 is another than that of build/release"
say "the picture is the same; build/arm64/bin and lib are for ARM machines with the libraries of Debian 12"
