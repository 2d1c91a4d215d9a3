#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant cockpit` as a process: recording, background calibration, commands, kills, hostile requests.

    cockpit_test.py OCTANT SOURCE
"""

import csv
import http.client
import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

OCTANT, SOURCE = (os.path.abspath(word) for word in sys.argv[1:3])
HALL = os.path.join(SOURCE, "datasets", "hall")
PATIENCE_S = 120  # on a busy machine; no figure of a test


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["time_s"]]


def lines_of(run, epoch=True):
    """A run of stops as live lines."""
    for row in rows_of(os.path.join(run, "tof.csv")):
        line = {"time_s": float(row["time_s"]), "beacon": row["beacon"], "tof_s": float(row["tof_s"]), "receiver": row["receiver"]}
        if epoch:
            line["epoch"] = int(row["epoch"])
        yield json.dumps(line)


class Cockpit:
    """A running cockpit with its address and the commands of its operator."""

    def __init__(self, folder, *words, site=os.path.join(HALL, "site.yaml"), preexec=None):
        self.run = os.path.join(folder, "recorded")
        self.process = subprocess.Popen([OCTANT, "cockpit", *([site] if site else []), "--listen", "127.0.0.1:0", "-o", self.run, *words],
                                        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=preexec)
        self.notes = []
        for line in self.process.stderr:
            self.notes.append(line)
            if found := re.match(r"cockpit +http://127.0.0.1:(\d+)/", line):
                self.port = int(found.group(1))
                return
        raise AssertionError("".join(self.notes))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

    def send(self, lines):
        self.process.stdin.write("".join(line + "\n" for line in lines))
        self.process.stdin.flush()

    def ask(self, method, path, body=None, headers=None, host=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        connection.putrequest(method, path, skip_host=True)
        connection.putheader("Host", host or f"127.0.0.1:{self.port}")
        for name, value in (headers or {}).items():
            connection.putheader(name, value)
        data = None if body is None else body.encode()
        if data is not None:
            connection.putheader("Content-Length", str(len(data)))
        connection.endheaders(data)
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer, text

    def command(self, what, client="operator", **more):
        answer, text = self.ask("POST", "/api/command", json.dumps({"do": what, "client": client, **more}), {"Content-Type": "application/json"})
        return answer.status, json.loads(text)

    def state(self):
        return json.loads(self.ask("GET", "/api/state")[1])

    def until(self, holds, why):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            state = self.state()
            if holds(state):
                return state
            time.sleep(0.1)
        raise AssertionError(f"never: {why}: {json.dumps(state)[:2000]}")


def calibrated(site, run, out):
    done = subprocess.run([OCTANT, "calibrate", site, run, "-o", out, "--no-report", "--json", "--progress", "none"], capture_output=True, text=True, timeout=PATIENCE_S)
    return done.returncode, json.loads(done.stdout)


def misses(value, schema, where=""):
    """Keys of a document that its schema does not know, and required ones that are missing."""
    if isinstance(value, list):
        return [miss for item in value for miss in misses(item, schema.get("items", {}), where + "[]")]
    if not isinstance(value, dict) or "properties" not in schema:
        return []
    found = [f"{where}.{key} is missing" for key in schema.get("required", []) if key not in value]
    for key, item in value.items():
        found += misses(item, schema["properties"][key], f"{where}.{key}") if key in schema["properties"] else [f"{where}.{key} is not described"]
    return found


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="octant-cockpit-")
        self.addCleanup(shutil.rmtree, self.folder)


class Commissioning(Folder):
    def test_a_replayed_run_is_recorded_and_calibrated_as_by_calibrate(self):
        source = os.path.join(HALL, "run")
        with Cockpit(self.folder, "--source", source, "--speed", "0") as cockpit:
            state = cockpit.until(lambda s: s["source"]["is_over"] and s["light"]["colour"] == "good" and s["recording"]["arrivals"] == len(rows_of(source + "/tof.csv")), "good")
            self.assertEqual([b["id"] for b in state["beacons"]], [f"B{i}" for i in range(8)])
            self.assertTrue(all(b["radius95_m"] < 0.03 for b in state["calibration"]["beacons"]))
            self.assertGreater(len(state["calibration"]["stops"]), 30)
            self.assertIsNotNone(state["next_stop"])
            cockpit.until(lambda s: s["floor_version"] > 0, "a map")
            floor = json.loads(cockpit.ask("GET", "/api/floor")[1])
            self.assertEqual(len(floor["cells"]), len(floor["values_m"]))
            schema = json.loads(subprocess.run([OCTANT, "schema", "cockpit"], capture_output=True, text=True, check=True, timeout=PATIENCE_S).stdout)
            self.assertEqual(misses(cockpit.state(), schema) + misses(floor, schema["$defs"]["floor"]), [])
            self.assertEqual(cockpit.command("finish")[0], 200)
            finished = cockpit.until(lambda s: s["finished"], "finished")["finished"]
            self.assertEqual(finished["status"], "ok", finished)
        keys = ("time_s", "beacon", "tof_s", "epoch", "receiver")
        self.assertEqual([[row[k] for k in keys] for row in rows_of(cockpit.run + "/tof.csv")], [[row[k] for k in keys] for row in rows_of(source + "/tof.csv")])
        with open(cockpit.run + "/run.yaml", encoding="utf-8") as ours, open(source + "/run.yaml", encoding="utf-8") as theirs:
            self.assertEqual(ours.read(), theirs.read())
        out = os.path.join(self.folder, "d.json")
        code, _ = calibrated(os.path.join(HALL, "site.yaml"), cockpit.run, out)
        self.assertEqual(code, 0)
        with open(out, encoding="utf-8") as a, open(finished["deployment"], encoding="utf-8") as b:
            for x, y in zip(json.load(a)["beacons"], json.load(b)["beacons"]):
                for axis in range(3):
                    sigma = math.sqrt(x["covariance_m2"][axis][axis])
                    self.assertLessEqual(abs(x["position_m"][axis] - y["position_m"][axis]), 1e-6 * sigma)
        self.assertTrue(os.path.getsize(finished["report"]) > 10000)

    def test_finish_of_the_source_ends_as_calibrate_does(self):
        for source, code in ((os.path.join(HALL, "run"), 0), (None, 5)):
            run = os.path.join(self.folder, str(code))
            if source is None:  # two stops
                source = os.path.join(self.folder, "short")
                os.mkdir(source)
                with open(os.path.join(HALL, "run", "tof.csv"), encoding="utf-8") as file, open(source + "/tof.csv", "w", encoding="utf-8") as short:
                    short.writelines(line for line in file if line.startswith("time") or int(line.split(",")[3]) < 2)
            done = subprocess.run([OCTANT, "cockpit", os.path.join(HALL, "site.yaml"), "--source", source, "--speed", "0", "-o", run, "--finish", "--json", "--listen", "127.0.0.1:0"], capture_output=True, text=True, timeout=PATIENCE_S)
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            self.assertEqual(os.path.exists(run + "/deployment.json"), code == 0)
            self.assertEqual(json.loads(done.stdout)["arrivals"], len(rows_of(source + "/tof.csv")))

    def test_the_operator_marks_stops_and_deletes_one(self):
        lines = {}
        for line in lines_of(os.path.join(HALL, "run")):
            row = json.loads(line)
            lines.setdefault(row.pop("epoch"), []).append(json.dumps(row))
        with Cockpit(self.folder) as cockpit:
            cockpit.send(lines[0])  # before the first stop
            cockpit.until(lambda s: s["recording"]["arrivals"] == len(lines[0]), "a drive")
            for stop, epoch in enumerate((1, 2, 3)):
                self.assertEqual(cockpit.command("begin_stop")[0], 200)
                self.assertEqual(cockpit.command("begin_stop")[0], 422)
                cockpit.send(lines[epoch])
                cockpit.until(lambda s: sum(b["arrivals"] for b in s["beacons"]) == sum(len(lines[e]) for e in range(epoch + 1)), "rows")
                self.assertEqual(cockpit.command("end_stop")[0], 200)
                cockpit.until(lambda s: len(s["stops"]) == stop + 1, "a stop")
            self.assertEqual(cockpit.command("control_point", epoch=2, x_m=1.5, y_m=2.5, name="P3")[0], 200)
            self.assertEqual(cockpit.command("control_point", epoch=9, x_m=1.5, y_m=2.5)[0], 422)
            self.assertEqual(cockpit.command("control_point", epoch=2, x_m="far", y_m=2.5)[0], 422)
            self.assertEqual(cockpit.command("delete_stop", epoch=1)[0], 200)
            state = cockpit.until(lambda s: s["recording"]["deleted"] == len(lines[2]), "deleted")
            self.assertEqual([s["epoch"] for s in state["stops"]], [0, 2])
            self.assertEqual(state["stops"][1]["control_point"]["name"], "P3")
        recorded = rows_of(cockpit.run + "/tof.csv")
        self.assertEqual([row["epoch"] for row in recorded], ["0"] * len(lines[1]) + ["2"] * len(lines[3]))
        self.assertEqual([row["tof_s"] for row in rows_of(cockpit.run + "/moving.csv")], [str(json.loads(line)["tof_s"]) for line in lines[0]])
        self.assertEqual({row["reason"] for row in rows_of(cockpit.run + "/unused.csv")}, {"deleted"})
        with open(cockpit.run + "/points.csv", encoding="utf-8") as file:
            self.assertEqual(file.read(), "epoch,x_m,y_m,sigma_m\n2,1.5,2.5,0.005\n")

    def test_an_exchanged_pair_is_named_and_accepted_with_undo(self):
        site = os.path.join(self.folder, "site.yaml")
        with open(os.path.join(HALL, "site.yaml"), encoding="utf-8") as file:
            text = file.read()
        # Labels of two control points exchanged in the site file.
        wrong = text.replace("id: B0,", "id: B_,").replace("id: B3,", "id: B0,").replace("id: B_,", "id: B3,")
        with open(site, "w", encoding="utf-8") as file:
            file.write("# by hand\n" + wrong)
        with Cockpit(self.folder, site=site) as cockpit:
            cockpit.send(lines_of(os.path.join(HALL, "run")))
            state = cockpit.until(lambda s: any(f["exchange"] for f in (s["calibration"] or {}).get("findings", [])), "a pair")
            pair = next(f["exchange"] for f in state["calibration"]["findings"] if f["exchange"])
            self.assertEqual(sorted(pair), ["B0", "B3"])
            self.assertEqual(state["light"]["colour"], "contradicted")
            self.assertEqual(cockpit.command("exchange", a=pair[0], b=pair[1])[0], 200)
            cockpit.until(lambda s: s["light"]["colour"] == "good", "good")
            with open(site, encoding="utf-8") as file:
                self.assertEqual(file.read(), "# by hand\n" + text)
            self.assertEqual(cockpit.command("exchange", a="B0", b="B99")[0], 422)
            self.assertEqual(cockpit.command("undo")[0], 200)
            with open(site, encoding="utf-8") as file:
                self.assertEqual(file.read(), "# by hand\n" + wrong)
            self.assertEqual(cockpit.command("undo")[0], 422)
            cockpit.until(lambda s: s["light"]["colour"] == "contradicted", "contradicted again")

    def test_late_rows_and_a_clock_that_is_set_back_leave_a_readable_run(self):
        lines = list(lines_of(os.path.join(HALL, "run")))
        shuffled = [json.loads(line) for line in lines]
        pick = random.Random(7)
        shuffled.sort(key=lambda row: row["time_s"] + pick.uniform(0, 0.15))
        back = [{**row, "time_s": row["time_s"] - 5000, "epoch": row["epoch"] + 1000} for row in shuffled]
        with Cockpit(self.folder) as cockpit:
            cockpit.send(map(json.dumps, shuffled + back))
            state = cockpit.until(lambda s: sum(s["recording"][k] for k in ("arrivals", "late")) == 2 * len(lines), "all rows")
            self.assertEqual(state["recording"]["clock_steps"], 1)
            self.assertLess(state["recording"]["late"], 30)
        self.assertIn(calibrated(os.path.join(HALL, "site.yaml"), cockpit.run, os.path.join(self.folder, "d.json"))[0], (0, 6))


class Nameless(Folder):
    def test_a_site_is_described_from_the_names_that_are_received(self):
        with Cockpit(self.folder, site=None) as cockpit:
            self.assertEqual(cockpit.command("set_site", kind="ultrasound")[0], 422, "no name yet")
            cockpit.send(['{"time_s": 0.5, "beacon": "a\\nb", "tof_s": 0.01}', *lines_of(os.path.join(HALL, "run"))])
            state = cockpit.until(lambda s: s["recording"]["arrivals"] == 2161, "rows")
            self.assertEqual((state["mode"], sorted(b["id"] for b in state["beacons"]), len(state["receivers"])), ("setup", [f"B{i}" for i in range(8)], 8))
            self.assertEqual(sum(state["source"]["bad_lines"].values()), 1)
            self.assertEqual(cockpit.command("undo")[0], 422)
            with open(os.path.join(HALL, "site.yaml"), encoding="utf-8") as file:
                places = re.findall(r"id: (B\d), position_m: \[([^,]+), ([^,]+), ([^,]+)\]", file.read())
            control = ("B0", "B3", "B6")
            beacons = [{"id": b, "x_m": float(x), "y_m": float(y), "sigma_m": 0.0 if b in control else 0.5, **({"z_m": float(z)} if b in control else {})} for b, x, y, z in places]
            self.assertEqual(cockpit.command("set_site", beacons=[{"id": "B9", "x_m": 1, "y_m": 1}])[0], 422)
            self.assertEqual(cockpit.command("set_site", height_m="tall")[0], 422)
            status, answer = cockpit.command("set_site", temperature_degC=21, ring_radius_m=0.0653281, height_m=0.3, beacons=beacons)
            self.assertEqual(status, 200, answer)
            state = cockpit.until(lambda s: s["calibration"] and s["calibration"]["arrivals"] > 0, "a calibration")
            self.assertEqual(state["mode"], "commissioning")
            state = cockpit.until(lambda s: s["light"]["colour"] != "not_yet", "a verdict")
            self.assertEqual(state["light"]["colour"], "good", state["light"])
            with open(cockpit.run + "/site.yaml", encoding="utf-8") as file:
                self.assertIn("octant_site: 1", file.read())
            self.assertEqual(cockpit.command("set_site")[0], 422, "there is one")


class Places(Folder):
    def test_a_map_with_beacons_at_other_places_takes_a_tenth_of_a_second(self):
        with Cockpit(self.folder, "--source", os.path.join(HALL, "run"), "--speed", "0") as cockpit:
            cockpit.until(lambda s: s["floor_version"] > 0, "a map")
            before = json.loads(cockpit.ask("GET", "/api/floor")[1])
            typed, times = {"Content-Type": "application/json"}, []
            for step in range(5):
                began = time.monotonic()
                answer, text = cockpit.ask("POST", "/api/floor", json.dumps({"moves": [{"id": "B1", "x_m": 3 + step, "y_m": 6}]}), typed)
                times.append(time.monotonic() - began)
                self.assertEqual(answer.status, 200, text)
                self.assertNotEqual(json.loads(text)["values_m"], before["values_m"])
            print(f"maps with a moved beacon: {1000 * min(times):.0f} ms", file=sys.stderr)
            for moves, status in (([{"id": "B99", "x_m": 1, "y_m": 1}], 422), ([{"id": "B1", "x_m": 1e300, "y_m": 1}], 422), ("B1", 400), ([7], 400)):
                self.assertEqual(cockpit.ask("POST", "/api/floor", json.dumps({"moves": moves}), typed)[0].status, status)
            self.assertEqual(json.loads(cockpit.ask("GET", "/api/floor")[1]), before)


class Kills(Folder):
    def test_a_killed_cockpit_leaves_a_readable_run_that_misses_a_second_at_most(self):
        rate, pick = 1000, random.Random(3)
        for attempt in range(4):
            folder = os.path.join(self.folder, str(attempt))
            os.mkdir(folder)
            with Cockpit(folder) as cockpit:
                began, sent = time.monotonic(), 0
                end = began + pick.uniform(0.5, 2.5)
                while time.monotonic() < end:
                    due = int(rate * (time.monotonic() - began))
                    cockpit.send(json.dumps({"time_s": n / rate, "beacon": f"B{n % 8}", "tof_s": 0.01, "receiver": f"r{n // 8 % 8}", "epoch": n // 500}) for n in range(sent, due))
                    sent = max(sent, due)
                    time.sleep(0.02)
                cockpit.process.send_signal(signal.SIGKILL)
                cockpit.process.wait()
            with open(cockpit.run + "/tof.csv", encoding="utf-8") as file:
                text = file.read()
            self.assertTrue(text.endswith("\n"))
            rows = rows_of(cockpit.run + "/tof.csv")
            self.assertEqual([float(row["time_s"]) for row in rows], [n / rate for n in range(len(rows))])
            self.assertGreater(len(rows), sent - rate)


class Hostile(Folder):
    def test_foreign_and_malformed_requests_are_refused(self):
        with Cockpit(self.folder) as cockpit:
            port, body, typed = cockpit.port, json.dumps({"do": "finish", "client": "x"}), {"Content-Type": "application/json"}
            for status, words in ((403, ("GET", "/api/state", None, {"Origin": "http://evil.example"})),
                                  (403, ("GET", "/api/state", None, {"Sec-Fetch-Site": "cross-site"})),
                                  (403, ("GET", "/api/state", None, {}, "evil.example")),
                                  (403, ("POST", "/api/command", body, {**typed, "Origin": f"http://127.0.0.1:{port + 1}"})),
                                  (415, ("POST", "/api/command", body, {"Content-Type": "text/plain"})),
                                  (415, ("POST", "/api/command", body, {"Content-Type": "application/x-www-form-urlencoded"})),
                                  (405, ("DELETE", "/api/state")), (404, ("GET", "/../../etc/passwd")), (404, ("POST", "/api/state", body, typed)),
                                  (400, ("POST", "/api/command", "{", typed)), (400, ("POST", "/api/command", "[" * 60000, typed)),
                                  (400, ("POST", "/api/command", json.dumps({"do": "finish"}), typed)),
                                  (400, ("POST", "/api/command", json.dumps({"do": "finish", "client": "x" * 1000}), typed)),
                                  (413, ("POST", "/api/command", "x" * 70000, typed)),
                                  (431, ("GET", "/api/state", None, {"X-Long": "x" * 9000}))):
                answer, text = cockpit.ask(*words)
                self.assertEqual(answer.status, status, (words, text))
            self.assertEqual(cockpit.command("fly", client="x")[0], 422)
            self.assertEqual(cockpit.command("undo", client="y")[0], 409)
            self.assertEqual(cockpit.command("take_over", client="y")[0], 200)
            self.assertEqual(cockpit.command("undo", client="x")[0], 409)
            answer, page = cockpit.ask("GET", "/")
            self.assertIn("default-src 'none'", answer.getheader("Content-Security-Policy"))
            self.assertNotIn("unsafe", answer.getheader("Content-Security-Policy"))
            self.assertNotRegex(page, r"(src|href)=\"(https?:)?//")
            self.assertIsNone(cockpit.state()["finished"])

    def test_a_wrong_token_is_refused_and_the_right_one_sets_a_cookie(self):
        with Cockpit(self.folder, "--token", "secret-1-secret-1") as cockpit:
            for headers in ({}, {"Cookie": f"octant_{cockpit.port}=secret-2"}, {"Authorization": "Bearer secret-"}):
                self.assertEqual(cockpit.ask("GET", "/api/state", None, headers)[0].status, 401)
            self.assertEqual(cockpit.ask("GET", "/?token=secret-2")[0].status, 401)
            answer, _ = cockpit.ask("GET", "/?token=secret-1-secret-1")
            self.assertEqual((answer.status, answer.getheader("Location")), (303, "/"))
            cookie = answer.getheader("Set-Cookie")
            self.assertIn("HttpOnly; SameSite=Strict", cookie)
            self.assertEqual(cockpit.ask("GET", "/api/state", None, {"Cookie": cookie.split(";")[0]})[0].status, 200)
            self.assertEqual(cockpit.ask("GET", "/api/state", None, {"Authorization": "Bearer secret-1-secret-1"})[0].status, 200)
        done = subprocess.run([OCTANT, "cockpit", os.path.join(HALL, "site.yaml"), "--listen", "0.0.0.0:0", "-o", self.folder + "/open"], capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 2, "other machines need a token")

    def test_invalid_lines_are_counted_and_do_no_harm(self):
        with Cockpit(self.folder) as cockpit:
            cockpit.send(["<script>alert(1)</script>", '{"time_s": 1, "beacon": "<img src=x onerror=alert(1)>", "tof_s": 0.01, "receiver": "r0"}', "x" * 100000, "[" * 5000, '{"time_s": 1, "beacon": "B0", "tof_s": 1e300, "receiver": "r0"}'])
            cockpit.send(lines_of(os.path.join(HALL, "run")))
            state = cockpit.until(lambda s: s["recording"]["arrivals"] > 2000, "the run")
            self.assertEqual(sum(state["source"]["bad_lines"].values()), 5)

    def test_an_existing_recording_is_not_overwritten(self):
        done = subprocess.run([OCTANT, "cockpit", os.path.join(HALL, "site.yaml"), "-o", os.path.join(HALL, "run")], capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
