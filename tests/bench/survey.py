#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""A million cells and forty beacons: octant beside NumPy in one run, and the memory of `octant survey` as a whole.

    /usr/bin/python3 tests/bench/survey.py [--build build/release] [--repeats 5]

Times are the smallest of the repeats; each side takes turns, as others use these machines too. "CPU" is the process' own time on
all threads, which tells more than the clock where the machine is busy.
"""
import argparse
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

SIDE, BEACONS, WALLS = 1000, 40, 60


def places():
    import numpy as np
    return np.random.default_rng(40).uniform([0, 0, 3], [100, 100, 5], (BEACONS, 3))


def numpy_hdop():
    """Vectorised NumPy, a beacon at a time: wall-clock and CPU seconds."""
    import numpy as np
    wall, cpu = time.perf_counter(), time.process_time()
    x, y = np.meshgrid(0.1 * (np.arange(SIDE) + 0.5), 0.1 * (np.arange(SIDE) + 0.5))
    xx, xy, yy = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for px, py, pz in places():
        dx, dy = x - px, y - py
        inverse = 1 / (dx * dx + dy * dy + (0.3 - pz) ** 2)
        xx += dx * dx * inverse
        xy += dx * dy * inverse
        yy += dy * dy * inverse
    np.sqrt((xx + yy) / (xx * yy - xy * xy))
    return time.perf_counter() - wall, time.process_time() - cpu


def numpy_blocks():
    """The same by rows that stay in the cache."""
    import numpy as np
    b = places()
    wall, cpu = time.perf_counter(), time.process_time()
    x = 0.1 * (np.arange(SIDE) + 0.5)
    hdop = np.empty((SIDE, SIDE))
    for first in range(0, SIDE, 8):
        y = 0.1 * (np.arange(first, first + 8) + 0.5)
        dx = x[None, :, None] - b[:, 0]
        dy = y[:, None, None] - b[:, 1]
        inverse = 1 / (dx * dx + dy * dy + (0.3 - b[:, 2]) ** 2)
        xx, xy, yy = (dx * dx * inverse).sum(-1), (dx * dy * inverse).sum(-1), (dy * dy * inverse).sum(-1)
        hdop[first:first + 8] = np.sqrt((xx + yy) / (xx * yy - xy * xy))
    return time.perf_counter() - wall, time.process_time() - cpu


def bench(build, name):
    """Wall-clock and CPU seconds of one entry of octant_bench."""
    out = subprocess.run([build / "bin/octant_bench", f"--benchmark_filter=^{name}$", "--benchmark_format=json", "--benchmark_min_time=0.05"],
                         check=True, capture_output=True, text=True).stdout
    entry = json.loads(out)["benchmarks"][0]
    scale = {"ms": 1e-3, "us": 1e-6, "s": 1.0}[entry["time_unit"]]
    return entry["real_time"] * scale, entry["cpu_time"] * scale


def site_text():
    draw = random.Random(1)
    lines = ["octant_site: 1", "name: million", "motion: planar", "medium: {model: cramer1993, temperature_degC: 20, relative_humidity: 0.5, pressure_pa: 101325, sigma_mps: 0.1}",
             "timing: {clock: synchronised, delay_per: none}", "noise: {tof_sigma_s: 1.0e-5}", "vehicles: [{receivers: [{id: r0, position_m: [0, 0, 0.3]}]}]",
             "tolerance: {fix_m: 0.02}", "beacons:"]
    lines += [f"  - {{id: B{i}, position_m: [{draw.uniform(1, 99):.3f}, {draw.uniform(1, 99):.3f}, {draw.uniform(3, 5):.3f}], sigma_m: 0.0}}" for i in range(BEACONS)]
    lines += ["scene:", "  floor_m: [[0, 0], [100, 0], [100, 100], [0, 100]]", "  cell_m: 0.1", "  patterns: [{id: p, kind: cosine_power, exponent: 1.5, half_angle_rad: 1.5}]",
              "  beacon_pattern: p", "  acoustics: {frequency_hz: 40000, amplitude_1m_v: 300, threshold_v: 0.01}", "  walls:"]
    for _ in range(WALLS):
        x, y = draw.uniform(0, 95), draw.uniform(0, 95)
        lines.append(f"    - {{points_m: [[{x:.3f}, {y:.3f}], [{x + draw.uniform(-9, 9):.3f}, {y + draw.uniform(-9, 9):.3f}]], top_m: {draw.uniform(1, 5):.2f}}}")
    lines.append("  beacons:")
    lines += [f"    - {{id: B{i}, axis: [{draw.uniform(-1, 1):.3f}, {draw.uniform(-1, 1):.3f}, -0.4]}}" for i in range(BEACONS)]
    return "\n".join(lines) + "\n"


def process(command):
    """Wall-clock and CPU seconds, largest resident set [MB]."""
    began = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"{command} ended with {child.returncode}")
    return time.perf_counter() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    print("| a million cells, forty beacons, sixty walls | wall | CPU | memory |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        site = pathlib.Path(folder, "site.yaml")
        site.write_text(site_text(), encoding="utf-8")
        # Before NumPy takes its memory, which a child would be charged with.
        for words in (["--failures", "0"], []):
            runs = [process([options.build / "bin/octant", "survey", site, "--threads", "2", "-q", *words]) for _ in range(options.repeats)]
            print(f"| octant survey {' '.join(words)} | {min(r[0] for r in runs):.2f} s | {min(r[1] for r in runs):.2f} s (all threads) | {max(r[2] for r in runs):.0f} MB |")
    sides = {"NumPy, plain HDOP": numpy_hdop, "NumPy, plain HDOP in blocks": numpy_blocks}
    for name in ("survey_scalar_hdop/real_time", "survey_million/maps/2/real_time",
                 "survey_million/integrity/2/real_time", "survey_million/one_failure/2/real_time", "survey_million/two_failures/2/real_time"):
        sides[name.removesuffix("/real_time")] = lambda name=name: bench(options.build, name)
    best = {side: (float("inf"), float("inf")) for side in sides}
    for _ in range(options.repeats):
        for side, measure in sides.items():
            best[side] = tuple(map(min, best[side], measure()))
    base = best["NumPy, plain HDOP"]
    print("\n| a million cells, forty beacons | wall | CPU of one thread | NumPy's time by it |\n|---|---|---|---|")
    for side, (wall, cpu) in best.items():
        ratio = f"{base[0] / wall:.0f} (wall)" if "hdop" in side or "HDOP" in side else ""
        print(f"| {side} | {1e3 * wall:.1f} ms | {1e3 * cpu:.1f} ms | {ratio} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
