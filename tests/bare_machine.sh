#!/usr/bin/env bash
# Both commands of the README on a bare Debian 12, by a person who is not root: what they must be told, what it costs.
#
#   tests/bare_machine.sh ROOT [demo|test|both]
#
# Needs root, debootstrap and the network of Debian's packages, crates.io and PyPI. ROOT becomes a minimal Debian and is
# left there. The Rust toolchain is copied from this machine, as rustup's own server need not be within reach; crates are
# fetched anew. Prints minutes and mebibytes of each step.
set -euo pipefail
root=${1:?usage: bare_machine.sh ROOT [demo|test|both]}
what=${2:-both}
repository=$(cd "$(dirname "$0")/.." && pwd)
toolchain=${RUSTUP_HOME:-$HOME/.rustup}
cargo_bin=${CARGO_HOME:-$HOME/.cargo}/bin

say() { printf '\n== %s\n' "$1"; }
mib() { du -sxm --exclude=proc --exclude=sys --exclude=dev "$root" | cut -f1; }
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb "$@"; }
as_maker() { inside HOME=/home/maker FDM_SPEED="${FDM_SPEED:-4}" setpriv --reuid=maker --regid=maker --clear-groups bash -c "cd ~/fdm_loop && $1"; }
timed() { local start=$SECONDS; "$@"; took_s=$((SECONDS - start)); }

unmount() { for place in dev/shm dev/pts dev sys proc; do mountpoint -q "$root/$place" && umount "$root/$place"; done; true; }
trap unmount EXIT

if [ ! -x "$root/usr/bin/apt-get" ]; then
  say "debootstrap --variant=minbase bookworm"
  debootstrap --variant=minbase bookworm "$root" http://deb.debian.org/debian >/dev/null
fi
echo "$(mib) MiB: a minimal Debian 12"
for place in proc sys dev dev/pts dev/shm; do mountpoint -q "$root/$place" || mount --bind "/$place" "$root/$place"; done
cp /etc/resolv.conf "$root/etc/resolv.conf"
# Where the network of this machine has a certificate of its own, it counts inside as well.
mkdir -p "$root/etc/ssl/certs" "$root/usr/local/share/ca-certificates"
cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"

inside id maker >/dev/null 2>&1 || inside useradd -m maker
rm -rf "$root/home/maker/fdm_loop"
git clone -q "$repository" "$root/home/maker/fdm_loop"
if [ ! -d "$root/home/maker/.rustup" ]; then
  mkdir -p "$root/home/maker/.cargo"
  cp -a "$cargo_bin" "$root/home/maker/.cargo/bin"
  # The one that the repository asks for; here it may be a link to another.
  channel=$(sed -n 's/^channel = "\(.*\)"/\1/p' "$repository/rust-toolchain.toml")
  mkdir -p "$root/home/maker/.rustup/toolchains"
  cp -a "$toolchain/settings.toml" "$root/home/maker/.rustup/"
  for from in "$toolchain/toolchains/$channel"-*; do
    cp -aL "$from" "$root/home/maker/.rustup/toolchains/$(basename "$from")"
  done
  rm -rf "$root"/home/maker/.rustup/toolchains/*/share/doc
  echo 'export PATH="$HOME/.cargo/bin:$PATH"' >"$root/home/maker/.cargo/env"
fi
inside chown -R maker:maker /home/maker
base=$(mib)
echo "$base MiB: with the Rust toolchain and the clone"

# What a person without root is told to ask for, then installed by root: nothing else is.
install_asked() {
  local said packages
  while ! said=$(as_maker ". launch_scripts/setup.sh; $1" 2>&1); do
    packages=$(sed -n "s/.*ask an administrator for 'apt-get install \(.*\)'.*/\1/p" <<<"$said")
    [ -n "$packages" ] || { echo "$said"; exit 1; }
    say "root installs what was asked for: $packages"
    inside apt-get update -qq
    # shellcheck disable=SC2086
    inside DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    echo "$(mib) MiB after it"
  done
}

if [ "$what" != test ]; then
  install_asked true
  say "demo.sh as the user maker"
  timed as_maker ./launch_scripts/demo.sh
  echo "demo.sh: $((took_s / 60)) min $((took_s % 60)) s; $(mib) MiB in all, $(($(mib) - base)) MiB more than before"
fi
if [ "$what" != demo ]; then
  install_asked "$(grep -h '^need_packages' "$repository/launch_scripts/test.sh" | paste -sd';')"
  say "test.sh as the user maker"
  timed as_maker ./launch_scripts/test.sh
  echo "test.sh: $((took_s / 60)) min $((took_s % 60)) s; $(mib) MiB in all, $(($(mib) - base)) MiB more than before"
fi
