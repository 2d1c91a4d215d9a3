#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Speed of reading a long tof.csv, Octant and pandas turn by turn on the same file, as a Markdown table.

    /usr/bin/python3 tests/bench/reading.py [--bench build/release/bin/octant_bench] [--run FOLDER] [--rounds 5]

octant_bench writes the file (63 MB) where there is none. The best of all rounds counts, by processor time where one thread reads (others use
these machines too) and by the clock where several do. Octant's time includes the file's SHA-256; pandas' is read_csv with its defaults.
"""
import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time


def octant_rates(bench, run):
    """MB/s by benchmark name: by processor time and by the clock."""
    words = [bench, "--benchmark_filter=^read/", "--benchmark_format=json", "--benchmark_min_time=0.5"]
    done = subprocess.run(words, env={**os.environ, "OCTANT_BENCH_RUN": run}, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
    megabytes = os.path.getsize(os.path.join(run, "tof.csv")) / 1e6
    rates = {}
    for found in json.loads(done.stdout)["benchmarks"]:
        rates[found["name"].removesuffix("/process_time/real_time")] = (1e3 * megabytes / found["cpu_time"], 1e3 * megabytes / found["real_time"])
    return rates


def pandas_rate(run):
    import pandas

    path = os.path.join(run, "tof.csv")
    began, ticks = time.perf_counter(), time.process_time()
    table = pandas.read_csv(path)
    by_clock, by_processor = time.perf_counter() - began, time.process_time() - ticks
    megabytes = os.path.getsize(path) / 1e6
    assert len(table) > 0
    return megabytes / by_processor, megabytes / by_clock


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bench", default="build/release/bin/octant_bench")
    parser.add_argument("--run", help="a run folder with beacons B0 to B39 and receivers r0 to r7; made if it is not there")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    has_pandas = importlib.util.find_spec("pandas") is not None
    if not has_pandas:
        print("pandas is not here (Debian: python3-pandas): only Octant is measured", file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        run = options.run or os.path.join(folder, "run")
        best = {}
        for _ in range(options.rounds):
            rates = octant_rates(options.bench, run)
            if has_pandas:
                rates["pandas.read_csv"] = pandas_rate(run)
            for name, found in rates.items():
                best[name] = tuple(max(pair) for pair in zip(best.get(name, (0, 0)), found))
    pandas = best.get("pandas.read_csv")
    print("| reader | MB/s of one processor | MB/s by the clock | times pandas |\n|---|---|---|---|")
    for name, (by_processor, by_clock) in best.items():
        one = name == "pandas.read_csv" or name.endswith("/1")
        times = "" if pandas is None else f"{by_processor / pandas[0] if one else by_clock / pandas[1]:.2f}"
        print(f"| {name} | {by_processor:.0f} | {by_clock:.0f} | {times} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
