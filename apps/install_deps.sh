# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=sh disable=SC2034
# Sourced by apps/demo.sh and tests/run.sh: the one list of the Debian packages that Octant needs, and how they get here.

OCTANT_BUILD_PACKAGES="g++ cmake ninja-build pkg-config ca-certificates esbuild libboost-dev libceres-dev libcli11-dev libeigen3-dev
  libexpected-dev libfast-float-dev libfmt-dev libhwy-dev liblz4-dev libnlopt-cxx-dev libnlopt-dev libpng-dev libpugixml-dev libqrencode-dev libsqlite3-dev libssl-dev
  libsuitesparse-dev libyaml-dev libzstd-dev nlohmann-json3-dev python3-plotly zlib1g-dev"
OCTANT_TEST_PACKAGES="chromium chromium-driver clang clang-format clang-tidy dpkg-dev libbenchmark-dev libgmock-dev libgtest-dev libopenmpi-dev libpq-dev librapidcheck-dev
  openmpi-bin poppler-utils postgresql pybind11-dev python3 python3-dev python3-matplotlib python3-numpy python3-pytest python3-selenium python3-yaml valgrind
  zbar-tools"

# octant_install PACKAGE...: installs what is missing, says what, and does nothing where nothing is.
octant_install() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "octant: this script installs with apt; elsewhere install the like of: $*" >&2
    return 1
  fi
  octant_missing=
  for octant_package in "$@"; do
    case $(dpkg-query -W -f='${db:Status-Abbrev}' "$octant_package" 2>/dev/null) in
      ?i*) ;;
      *) octant_missing="$octant_missing $octant_package" ;;
    esac
  done
  [ -n "$octant_missing" ] || return 0
  octant_sudo=
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "octant: run as root, or install these first:$octant_missing" >&2
      return 1
    }
    octant_sudo=sudo
  fi
  echo "octant: installing with apt-get:$octant_missing" >&2
  $octant_sudo apt-get update -q >&2 || return 1
  # Unquoted on purpose: a list of words.
  # shellcheck disable=SC2086
  $octant_sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $octant_missing >&2
}
