#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant localize --follow` under load: how long after the line that completes it a fix comes out, and what memory it takes.

    live.py OCTANT [SECONDS [ARRIVALS_PER_SECOND]]

Stops of datasets/hall, each ended by a flush, sent in time; the time is that from before the write of the line to after the
read of the fix, so both pipes count. Fixes are read by a process of their own: a thread would wait for the sender to let go of
the interpreter, up to 5 ms, and that is not Octant's. What the machine itself takes is measured in the same run, for a tenth of
the time before and after: `grep`, which lets the flushes through.
"""

import array
import csv
import json
import multiprocessing
import os
import subprocess
import sys
import time

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HALL = os.path.join(SOURCE, "datasets", "hall")


def stops_of_hall():
    stops = {}
    with open(os.path.join(HALL, "heldout", "tof.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(file):
            stops.setdefault(int(row["epoch"]), []).append(row)
    return list(stops.values())


def resident_kb(process):
    with open(f"/proc/{process.pid}/status", encoding="utf-8") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS:"))


def read(process, result):
    """Reads the fixes to their end, then hands over of which stops they were and when they came: two arrays of one length."""
    os.close(process.stdin.fileno())  # else the stream would never end
    of, times = array.array("q"), array.array("d")
    with os.fdopen(process.stdout.fileno(), "rb") as fixes:
        for line in fixes:
            times.append(time.monotonic())
            of.append(json.loads(line).get("epoch", len(of)))
    result.send((of, times))


def measure(command, stops, seconds, rate):
    """The latencies of a command's answers [s], sorted, and its memory [kB] as it goes."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0)
    received, result = multiprocessing.Pipe(duplex=False)
    reader = multiprocessing.get_context("fork").Process(target=read, args=(process, result))
    reader.start()
    process.stdout.close()
    time.sleep(1.0)  # until it has read its deployment: what waits for a start is not of the stream
    sent, memory, arrivals = array.array("d"), [], 0
    began = time.monotonic()
    while (now := time.monotonic() - began) < seconds:
        if arrivals > now * rate:
            time.sleep(min(0.0005, arrivals / rate - now))
            continue
        stop = len(sent)
        rows = stops[stop % len(stops)]
        text = "".join(f'{{"time_s":{now + 1e-6 * i},"beacon":"{r["beacon"]}","tof_s":{r["tof_s"]},'
                       f'"epoch":{stop},"receiver":"{r["receiver"]}"}}\n' for i, r in enumerate(rows)) + '{"flush":1}\n'
        sent.append(time.monotonic())
        process.stdin.write(text.encode())
        arrivals += len(rows)
        if stop % 5000 == 100:
            memory.append(resident_kb(process))
    memory.append(resident_kb(process))
    process.stdin.close()
    of, came = received.recv()
    reader.join()
    process.wait()
    return sorted(at - sent[stop] for stop, at in zip(of, came)), memory, arrivals


def words(latencies):
    return ", ".join(f"{name} {1e3 * latencies[int(q * (len(latencies) - 1))]:.3f}"
                     for name, q in (("median", 0.5), ("p99", 0.99), ("p99.9", 0.999), ("largest", 1.0)))


def main():
    octant = [sys.argv[1], "localize", os.path.join(HALL, "deployment.true.json"), "--follow", "-q"]
    echo = ["grep", "--line-buffered", "flush"]
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    rate = float(sys.argv[3]) if len(sys.argv) > 3 else 10000.0
    stops = stops_of_hall()
    before = measure(echo, stops, 0.1 * seconds, rate)[0]
    latencies, memory, arrivals = measure(octant, stops, seconds, rate)
    after = measure(echo, stops, 0.1 * seconds, rate)[0]
    print(f"{arrivals} arrivals in {seconds:.0f} s ({arrivals / seconds:.0f}/s), {len(latencies)} fixes")
    print(f"latency [ms]: {words(latencies)}")
    print(f"of the machine itself (grep), before: {words(before)}; after: {words(after)}")
    print(f"memory [kB]: {memory[0]} at first, {max(memory)} at most, {memory[-1]} in the end")


main()
