#!/bin/sh
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# From a bare Debian 12 to a calibrated hall: installs what is missing (apt, as root or through sudo), builds, runs
# `octant demo`. Words are passed on: sh apps/demo.sh -o /tmp/hall
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/apps/install_deps.sh"
# shellcheck disable=SC2086
octant_install $OCTANT_BUILD_PACKAGES
(
  cd "$root"
  cmake --preset release -DOCTANT_BUILD_TESTS=OFF
  cmake --build --preset release --target octant -j "$(nproc)"
) >&2
exec "$root/build/release/bin/octant" demo "$@"
