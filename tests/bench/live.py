#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant localize --follow` under load: how long after the line that completes it a fix comes out, and what memory it takes.

    live.py OCTANT [SECONDS [ARRIVALS_PER_SECOND]]

Stops of datasets/hall, each ended by a flush, sent in time; the time is that from before the write of the line to after the
read of the fix, so both pipes count.
"""

import csv
import json
import os
import subprocess
import sys
import threading
import time

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HALL = os.path.join(SOURCE, "datasets", "hall")
octant = sys.argv[1]
seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
rate = float(sys.argv[3]) if len(sys.argv) > 3 else 10000.0

stops = {}
with open(os.path.join(HALL, "heldout", "tof.csv"), encoding="utf-8") as file:
    for row in csv.DictReader(file):
        stops.setdefault(int(row["epoch"]), []).append(row)
stops = list(stops.values())
process = subprocess.Popen([octant, "localize", os.path.join(HALL, "deployment.true.json"), "--follow", "-q"],
                           stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0)
sent, latencies, memory = {}, [], []


def resident_kb():
    with open(f"/proc/{process.pid}/status", encoding="utf-8") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS:"))


def read():
    for line in os.fdopen(os.dup(process.stdout.fileno()), "rb"):
        now = time.perf_counter()
        latencies.append(now - sent.pop(json.loads(line)["epoch"]))


reader = threading.Thread(target=read)
reader.start()
began = time.perf_counter()
arrivals = stop = 0
while (now := time.perf_counter() - began) < seconds:
    if arrivals > now * rate:
        time.sleep(min(0.0005, arrivals / rate - now))
        continue
    rows = stops[stop % len(stops)]
    text = "".join(f'{{"time_s":{1000.0 * (stop // len(stops)) + float(r["time_s"])},"beacon":"{r["beacon"]}","tof_s":{r["tof_s"]},'
                   f'"epoch":{stop},"receiver":"{r["receiver"]}"}}\n' for r in rows) + '{"flush":1}\n'
    sent[stop] = time.perf_counter()
    process.stdin.write(text.encode())
    arrivals += len(rows)
    stop += 1
    if stop % 5000 == 100:
        memory.append(resident_kb())
memory.append(resident_kb())
process.stdin.close()
reader.join()
process.wait()
latencies.sort()
print(f"{arrivals} arrivals in {seconds:.0f} s ({arrivals / seconds:.0f}/s), {len(latencies)} fixes")
print("latency [ms]: " + ", ".join(f"{name} {1e3 * latencies[int(q * (len(latencies) - 1))]:.3f}"
                                   for name, q in (("median", 0.5), ("p99", 0.99), ("p99.9", 0.999), ("largest", 1.0))))
print(f"memory [kB]: {memory[0]} at first, {max(memory)} at most, {memory[-1]} in the end")
