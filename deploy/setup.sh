#!/usr/bin/env bash
# Installs what Tessera is built from, on Debian 12 or 13 and Ubuntu 24.04 or later. Does nothing, and asks for no rights,
# when everything is there already.
#
#   deploy/setup.sh           install what is missing
#   deploy/setup.sh --check   only print what is missing; exit status 1 when something is
#   deploy/setup.sh --ci      install also what single tests start and skip without (a Slurm cluster), and what
#                             deploy/lint.sh uses
#   deploy/setup.sh --arm64   install instead what the programs are built from for 64-bit ARM on another machine,
#                             and qemu to try them; in a system of their own (deploy/arm64.sh)
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# THE list of packages; deploy/cmake/TesseraDependencies.cmake finds them. The names are the same on all three systems;
# libembree-dev is Embree 3.13 on Debian 12 and Embree 4 on the others.
# Tools and headers for every architecture, then libraries of one.
tools=(g++ cmake ninja-build ccache pkg-config protobuf-compiler protobuf-compiler-grpc nlohmann-json3-dev libcli11-dev)
libraries=(
  # RPC, errors, metrics, logs
  libprotobuf-dev libgrpc++-dev libabsl-dev prometheus-cpp-dev libmicrohttpd-dev libgnutls28-dev libspdlog-dev
  libcurl4-openssl-dev
  # journal, digests, compression
  libsqlitecpp-dev libsqlite3-dev libssl-dev libzstd-dev zlib1g-dev libdeflate-dev
  # renderer and images
  libembree-dev libtbb-dev libhwy-dev libopenexr-dev libimath-dev libopenimageio-dev libopencolorio-dev libpng-dev libjpeg-dev libcairo2-dev
  # scene files
  libpugixml-dev libdraco-dev libmeshoptimizer-dev libassimp-dev
  # configuration
  libtomlplusplus-dev
)
# faketime and iproute2 for clocks that jump and networks that lose packets
test_packages=(libgtest-dev libgmock-dev libbenchmark-dev libyaml-cpp-dev libgmp-dev libfaketime iproute2)
# the Python package's own, then what its tests and examples use
python_packages=(python3-protobuf python3-grpcio python3-numpy python3-zstandard)
# a browser, and what drives it, for the web page
# debootstrap for deploy/bare_system.sh, valgrind for deploy/perf.sh
ci_packages=(slurm-wlm munge debootstrap valgrind clang clang-format clang-tidy chromium python3-websockets
  "${python_packages[@]}" mypy python3-matplotlib blender)
cross_tools=(g++-aarch64-linux-gnu qemu-user-static)
packages=("${tools[@]}" "${libraries[@]}" "${test_packages[@]}")

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
  done
}

check_only="" foreign=""
case "${1:-}" in
  '') ;;
  --ci) packages+=("${ci_packages[@]}") ;;
  --arm64)
    packages=("${tools[@]}" "${cross_tools[@]}" "${libraries[@]/%/:arm64}")
    foreign=arm64
    ;;
  --check) check_only=1 ;;
  -h | --help)
    usage
    exit 0
    ;;
  *)
    usage >&2
    exit 2
    ;;
esac

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  cat >&2 <<EOF
setup.sh: this system has no apt-get. Tessera is built on Debian 12 or 13 and Ubuntu 24.04 or later. Elsewhere, install what
these Debian packages hold (CMake 3.22, a C++20 compiler, Embree 3.13 or 4, OpenEXR 3, ...), then run
"cmake --preset release && cmake --build --preset release":
  ${packages[*]}
EOF
  exit 1
fi

mapfile -t missing < <(missing_packages)
[ ${#missing[@]} -gt 0 ] || exit 0
if [ -n "$check_only" ]; then
  printf '%s\n' "${missing[@]}"
  exit 1
fi

begin "installing ${#missing[@]} packages"
[ -z "$foreign" ] || as_root dpkg --add-architecture "$foreign"
as_root apt-get update -qq
for package in "${missing[@]}"; do
  name=${package%:*}
  [ -n "$(apt-cache search --names-only "^${name//+/\\+}\$")" ] ||
    die "there is no package $package here; Debian 12 or 13, or Ubuntu 24.04 or later (with universe) is needed"
done
as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends --no-remove \
  -o DPkg::Lock::Timeout=120 "${missing[@]}" >/dev/null
end
