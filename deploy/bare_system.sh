#!/usr/bin/env bash
# Runs the first command of README.md in a Debian that has nothing else: the smallest that debootstrap makes,
# new each time. Then installs into a prefix there what was built, and uses it.
#
#   sudo deploy/bare_system.sh bookworm|trixie [FOLDER]
#
# FOLDER (by default ~/.cache/tessera-bare) keeps the new system as an archive, Debian's packages, the
# compiler's results (ccache), and the system itself for a look at it: 4 GB each. Packages come from the mirror
# that this machine's apt uses. The sources are those of the working tree, without what git ignores. Exit
# status 77: it cannot be run here, and why.
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# Within the system: what README says, as a new user does it, then an installation.
inside() {
  cd /root
  tessera/deploy/demo.sh
  [ -s cornell-box.exr ] && [ -s cornell-box.png ] || die "the demonstration has left no picture"
  begin "installing, and using what is installed"
  local result=0
  tessera/tests/install/install_test.sh tessera/build/release >install.log 2>&1 || result=$?
  # 77: the Python package needs packages that programs do without.
  [ $result -eq 0 ] || [ $result -eq 77 ] || {
    echo
    cat install.log >&2
    die "the installation does not work"
  }
  end
}

cannot() {
  say "deploy/bare_system.sh $suite was NOT run: $*"
  exit 77
}

suite=${1:-}
case "$suite" in
  bookworm | trixie) ;;
  inside)
    inside
    exit 0
    ;;
  *)
    usage
    exit 2
    ;;
esac
[ "$(id -u)" -eq 0 ] || cannot "it needs root, for a system in a folder"
command -v debootstrap >/dev/null || cannot "it needs debootstrap (deploy/setup.sh --ci)"
folder=${2:-$HOME/.cache/tessera-bare}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
root=$folder/$suite archive=$folder/$suite.tar log=$folder/$suite.log

# An Ubuntu's mirror has no Debian; debootstrap has one of its own then.
mirror=$(apt-get indextargets --format '$(REPO_URI) $(ORIGIN) $(LABEL)' 'Created-By: Packages' |
  awk '$2 == "Debian" && $3 == "Debian" && !found {print $1; found = 1}')
if [ -n "$mirror" ]; then
  /usr/lib/apt/apt-helper download-file "${mirror%/}/dists/$suite/Release" "$folder/Release" \
    >/dev/null 2>&1 || cannot "the mirror of Debian does not answer"
fi

rm -rf --one-file-system "$root"
if [ ! -e "$archive" ]; then
  begin "making a $suite"
  debootstrap --variant=minbase "$suite" "$root" ${mirror:+"$mirror"} >"$log" 2>&1 ||
    cannot "debootstrap failed; what it said is in $log"
  tar -C "$root" -cf "$archive.part" . && mv "$archive.part" "$archive"
  end
else
  mkdir -p "$root"
  tar -C "$root" -xf "$archive"
fi

# Names and proxies are this machine's. Nobody needs the system after a power failure.
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
{
  apt-config dump | grep -E '^Acquire::(http|https)::Proxy ' || true
  echo 'Acquire::Retries "3";'
} >"$root/etc/apt/apt.conf.d/99machine"
echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/99machine"
mkdir -p "$folder/$suite-packages/partial" "$folder/$suite-ccache" "$root/root/.cache/ccache" \
  "$root/root/tessera"
git -C "$top" ls-files -z --cached --others --exclude-standard | tar -C "$top" --null -T - -cf - |
  tar -C "$root/root/tessera" -xf -

say "$(sed -n 's/^PRETTY_NAME="\(.*\)"/\1/p' "$root/etc/os-release"), in $root"
# Mounts and processes end with the command.
unshare --mount --pid --kill-child --propagation private bash -euc '
  mount -t proc proc "$0/proc"
  mount --rbind /dev "$0/dev"
  mount --bind "$1-packages" "$0/var/cache/apt/archives"
  mount --bind "$1-ccache" "$0/root/.cache/ccache"
  exec chroot "$0" /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    /root/tessera/deploy/bare_system.sh inside
' "$root" "$folder/$suite" &
trap 'kill -KILL $! 2>/dev/null || true' EXIT
trap 'exit 130' INT TERM
wait $! || die "the first command does not work on a bare $suite"
say "the first command works on a bare $suite"
