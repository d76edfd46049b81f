#!/usr/bin/env bash
# Sourced by demo.sh and test.sh: finds or installs what a build needs, and says so before it asks for root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

need_packages() {
  local missing=()
  for package in "$@"; do
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  local root=()
  [ "$(id -u)" -eq 0 ] || root=(sudo)
  echo "Installing Debian packages (needs root): ${missing[*]}"
  if [ ${#root[@]} -gt 0 ] && ! command -v sudo >/dev/null; then
    echo "setup: no root and no sudo: ask an administrator for 'apt-get install ${missing[*]}'" >&2
    exit 1
  fi
  "${root[@]}" apt-get update -qq
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

need_rust() {
  [ -f "$HOME/.cargo/env" ] && . "$HOME/.cargo/env"
  command -v cargo >/dev/null && return 0
  need_packages ca-certificates curl
  echo "Installing Rust into $HOME/.cargo with rustup (no root needed)"
  curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y -q --profile minimal --default-toolchain none || {
    echo "setup: rustup could not be fetched; install Rust 1.95 as https://rustup.rs says and start again" >&2
    exit 1
  }
  . "$HOME/.cargo/env"
}

# clang (as `cc` and `c++`, where there is no other) links the Rust binaries and builds zstd for the bags and the bindings
# of OpenCV; its library makes those from OpenCV's headers. videoio brings core, imgproc and imgcodecs with it.
need_packages clang libopencv-videoio-dev
need_rust
