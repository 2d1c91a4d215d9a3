#!/bin/sh
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
# sh tests/fuzz/run.sh SECONDS [TARGET...]: fuzzes each reader so long, one after the other, from its corpus. New inputs
# that reach new code go to build/fuzz/found/TARGET, crashes to build/fuzz/crashes: a crash is mended, and its input
# joins tests/fuzz/corpus/TARGET, where replay_test.cc takes it for ever.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:?seconds for each reader}
shift
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz
[ $# -gt 0 ] || set -- $(ls tests/fuzz/corpus)
mkdir -p build/fuzz/crashes
failed=0
for target in "$@"; do
  mkdir -p "build/fuzz/found/$target"
  if ! "build/asan/bin/octant_fuzz_$target" -max_total_time="$seconds" -rss_limit_mb=600 -timeout=5 -max_len=20000 \
      -print_final_stats=1 -artifact_prefix="build/fuzz/crashes/$target-" "build/fuzz/found/$target" \
      "tests/fuzz/corpus/$target" >"build/fuzz/$target.log" 2>&1; then
    echo "$target: a finding, see build/fuzz/$target.log"
    failed=1
  else
    echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "build/fuzz/$target.log") inputs"
  fi
done
exit $failed
