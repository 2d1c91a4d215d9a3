#!/bin/sh
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing (apt, as root or through sudo), builds and runs all tests.
#   sh tests/run.sh                  the release build
#   sh tests/run.sh --asan           with the address and undefined-behaviour sanitizers, built by clang
#   sh tests/run.sh --tsan           with the thread sanitizer
#   sh tests/run.sh --valgrind       the readers under valgrind: memory that nobody wrote
#   sh tests/run.sh --slow           the slow set: thirty worlds of each kind (where ../shared/check exists)
#   sh tests/run.sh [--asan] -R io/  further words go to ctest
# The sanitizers and valgrind belong to the slow set.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/apps/install_deps.sh"
preset=release
slow=
runtime=
case ${1:-} in
  --asan) preset=asan && runtime=libclang-rt-dev && shift ;;
  --tsan) preset=tsan && shift ;;
  --valgrind) slow="-C Valgrind -L valgrind" && shift ;;
  --slow) slow="-C Slow -L slow" && shift ;;
esac
# shellcheck disable=SC2086
octant_install $OCTANT_BUILD_PACKAGES $OCTANT_TEST_PACKAGES $runtime
cd "$root"
# Warnings are errors where a machine looks, not where a newer compiler meets a user. Histories on a server are an option: tests have it.
cmake --preset "$preset" -DOCTANT_BUILD_TESTS=ON -DOCTANT_POSTGRESQL=ON ${CI:+-DOCTANT_WERROR=ON}
cmake --build --preset "$preset" -j "$(nproc)"
# shellcheck disable=SC2086
ctest --preset "$preset" -j "$(nproc)" $slow "$@"
