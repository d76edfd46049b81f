#!/usr/bin/env bash
# Builds the Debian package of what was built: launch_scripts/debian/build.sh [FOLDER OF THE PROGRAMS [FOLDER OF THE PACKAGE]]
#
# No debhelper: `fdm install` lays the files out, the dependencies are the packages of the libraries that the programs
# are linked with on this machine, so build it on the oldest Debian that it is for.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)
programs=${1:-$repository/target/release}
out=${2:-$repository/target}
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$repository/Cargo.toml")
architecture=$(dpkg --print-architecture)
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
chmod 755 "$stage"
umask 022

# Without symbols a tenth of the size.
mkdir "$stage/programs"
for program in "$programs"/*; do
  [ -f "$program" ] && [ -x "$program" ] || continue
  strip -o "$stage/programs/$(basename "$program")" "$program" 2>/dev/null || cp "$program" "$stage/programs/"
done
root=$stage/root
"$programs/fdm" install --prefix /usr --root "$root" --source "$repository" --programs "$stage/programs"

install -d "$root/usr/lib/systemd/system" "$root/etc/fdm_loop" "$root/DEBIAN"
cp -r "$repository"/launch_scripts/systemd/fdm_loop* "$root/usr/lib/systemd/system/"
install -m 644 "$repository/LICENSE" "$root/usr/share/doc/fdm-loop/copyright"
for unit in $(grep -o 'fdm_loop@[a-z_]*' "$repository/launch_scripts/systemd/fdm_loop.target"); do
  printf '# What differs on this machine from /usr/share/fdm_loop/config/%s.param.yaml.\n/**:\n  ros__parameters: {}\n' \
    "${unit#*@}" >"$root/etc/fdm_loop/${unit#*@}.param.yaml"
done
printf '# Of all nodes.\nROS_DOMAIN_ID=0\nNAMESPACE=/printer\n' >"$root/etc/fdm_loop/environment"
(cd "$root" && find etc -type f | sort | sed 's|^|/|') >"$root/DEBIAN/conffiles"

# The package of each library; of the C library the newest symbol that is asked for.
depends() {
  local library path
  for library in $(objdump -p "$root"/usr/lib/fdm_loop/* 2>/dev/null | awk '$1 == "NEEDED" { print $2 }' | sort -u); do
    case $library in libc.so.* | libm.so.* | ld-linux*) continue ;; esac
    path=$(ldconfig -p | awk -v library="$library" '$1 == library { print $NF; exit }')
    dpkg-query -S "$(readlink -f "$path")" "$path" 2>/dev/null | head -n 1 | cut -d: -f1
  done | sort -u
  objdump -T "$root"/usr/lib/fdm_loop/* 2>/dev/null | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -n 1 |
    sed 's/GLIBC_\(.*\)/libc6 (>= \1)/'
}
cat >"$root/DEBIAN/control" <<CONTROL
Package: fdm-loop
Version: $version
Architecture: $architecture
Maintainer: fdm_loop maintainers <maintainers@fdm-loop.invalid>
Installed-Size: $(du -sk --apparent-size --exclude=DEBIAN "$root" | cut -f1)
Depends: $(depends | paste -sd, | sed 's/,/, /g')
Recommends: iproute2
Section: science
Priority: optional
Description: watches, corrects and supervises a 3D print
 A graph of ROS 2 nodes that runs next to a printer: sensor nodes, state estimator,
 defect classifier, model-predictive controller, safety supervisor, recorder and a
 simulated printer, with the command fdm. No ROS installation is needed.
CONTROL
install -m 755 "$here"/postinst "$here"/prerm "$here"/postrm "$root/DEBIAN/"
(cd "$root" && find usr etc -type f -print0 | sort -z | xargs -0 md5sum) >"$root/DEBIAN/md5sums"
mkdir -p "$out"
dpkg-deb --root-owner-group --build "$root" "$out/fdm-loop_${version}_$architecture.deb"
