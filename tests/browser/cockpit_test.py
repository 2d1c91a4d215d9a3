#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""The page of `octant cockpit` in headless Chromium: a commissioning by an operator who follows "go there next".

    cockpit_test.py OCTANT SOURCE [--pictures FOLDER]
"""

import base64
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import browser as browsers  # noqa: E402

browsers.skip_unless_possible()
OCTANT, SOURCE = (os.path.abspath(word) for word in sys.argv[1:3])
PICTURES = sys.argv[4] if sys.argv[3:4] == ["--pictures"] else None
SIZES = ((1280, 900), (1024, 768), (390, 844))
SPEED_MPS, SIGMA_S, ROUNDS = 343.9873, 1e-5, 3


class Hall:
    """A hall of 12 x 8 m with its site file, and a cart that receives the beacons wherever it stands."""

    def __init__(self, folder, seed):
        self.pick = random.Random(seed)
        self.beacons = {f"B{i}": [x + self.pick.uniform(-0.3, 0.3), y + self.pick.uniform(-0.3, 0.3), self.pick.uniform(2.2, 2.8)]
                        for i, (x, y) in enumerate(((0, 0), (6, 0), (12, 0), (12, 8), (6, 8), (0, 8)))}
        self.delays = {name: self.pick.gauss(1e-4, 3e-5) for name in self.beacons}
        self.receivers = [[0.065 * math.cos(k * math.pi / 4), 0.065 * math.sin(k * math.pi / 4), 0.3] for k in range(8)]
        self.site, self.time_s, self.stop = os.path.join(folder, "site.yaml"), 0.0, 0
        places = "".join(
            f"  - {{id: {name}, position_m: {p if i % 3 == 0 else [c + self.pick.gauss(0, 0.3) for c in p]}, sigma_m: {0 if i % 3 == 0 else 0.3}}}\n"
            for i, (name, p) in enumerate(self.beacons.items()))
        receivers = "".join(f"      - {{id: r{k}, position_m: {p}, sigma_m: 0.001}}\n" for k, p in enumerate(self.receivers))
        with open(self.site, "w", encoding="utf-8") as file:
            file.write("octant_site: 1\nname: <b>hall</b>\nmotion: planar\nmedium: {model: cramer1993, temperature_degC: 20, relative_humidity: 0.5, sigma_mps: 2}\n"
                       "timing: {clock: synchronised, delay_per: beacon, delay_s: 1.0e-4, delay_sigma_s: 5.0e-5}\nnoise: {tof_sigma_s: 1.0e-5}\n"
                       f"beacons:\n{places}vehicles:\n  - id: robot\n    receivers:\n{receivers}tolerance: {{beacon_m: 0.03, fix_m: 0.05}}\n")

    def lines_at(self, x, y, heading):
        for _ in range(ROUNDS):
            for name, p in self.beacons.items():
                for k, (rx, ry, rz) in enumerate(self.receivers):
                    at = (x + rx * math.cos(heading) - ry * math.sin(heading), y + rx * math.sin(heading) + ry * math.cos(heading), rz)
                    yield json.dumps({"time_s": self.time_s, "beacon": name, "receiver": f"r{k}", "epoch": self.stop,
                                      "tof_s": math.dist(at, p) / SPEED_MPS + self.delays[name] + self.pick.gauss(0, SIGMA_S)})
                self.time_s = round(self.time_s + 0.1, 3)
        self.stop += 1
        self.time_s += 5


@browsers.again_if_the_browser_fails
class Page(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="octant-page-")
        self.addCleanup(shutil.rmtree, self.folder)

    @classmethod
    def setUpClass(cls):
        cls.browser = browsers.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def start(self, site):
        process = subprocess.Popen([OCTANT, "cockpit", *([site] if site else []), "--listen", "127.0.0.1:0", "-o", os.path.join(self.folder, "run")],
                                   stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        for line in process.stderr:
            if found := re.match(r"cockpit +(http\S+)", line):
                return process, found.group(1)
        raise AssertionError("no address")

    def open(self, url, width=1280, height=900):
        browser = self.browser
        browser.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        browser.errors()
        browser.driver.get(url)
        self.assertTrue(browser.wait("['Live', 'The source has ended'].includes(document.getElementById('connection').textContent)"))

    def text(self, name):
        return self.browser.run("return document.getElementById(arguments[0]).textContent", name)

    def test_an_operator_who_follows_the_next_stop_commissions_a_hall(self):
        hall = Hall(self.folder, 5)
        process, url = self.start(hall.site)
        self.open(url)
        place, stops = (6.0, 4.0, 0.0), 0
        while "good" not in self.browser.run("return document.getElementById('light').className") and stops < 12:
            process.stdin.write("".join(line + "\n" for line in hall.lines_at(*place)))
            process.stdin.flush()
            stops += 1
            sent = stops * ROUNDS * 48
            calibrated = f"fetch('/api/state').then(a => a.json()).then(s => [s.recording.arrivals, s.calibrating, (s.calibration?.arrivals ?? 0) + (s.calibration?.rejected ?? 0), s.next_stop, s.light.colour])"
            end = time.monotonic() + browsers.PATIENCE_S
            while time.monotonic() < end:
                recorded, busy, used, target, colour = self.browser.run(f"return {calibrated}")
                if recorded == sent and not busy and used == sent:
                    break
                time.sleep(0.2)
            place = (target["x_m"], target["y_m"], target["heading_rad"]) if target else (hall.pick.uniform(1, 11), hall.pick.uniform(1, 7), 0)
            if colour == "good":
                break
        self.assertTrue(self.browser.wait("document.getElementById('light').className.includes('good')"), self.text("light-words"))
        self.assertLessEqual(stops, 8)
        self.assertEqual(self.text("site"), "<b>hall</b>", "text, not markup")
        self.check_layout(url)
        self.assertEqual(self.browser.errors(), [])
        self.browser.run("document.getElementById('finish').click()")
        self.browser.run("document.getElementById('ask-ok').click()")
        self.assertTrue(self.browser.wait("document.getElementById('light-words').textContent.startsWith('Finished. Deployment')"), self.text("light-words"))
        with open(os.path.join(self.folder, "run", "deployment.json"), encoding="utf-8") as file:
            deployment = json.load(file)
        worst = max(math.dist(b["position_m"][:2], hall.beacons[b["id"]][:2]) for b in deployment["beacons"])
        self.assertLess(worst, 0.03)

    def test_a_site_is_described_on_the_page(self):
        hall = Hall(self.folder, 6)
        process, url = self.start(None)
        self.open(url)
        for place in ((3, 2, 0), (9, 2, 1), (9, 6, 2), (3, 6, 3), (6, 4, 1), (6, 1, 2), (1, 4, 0), (11, 4, 2)):
            process.stdin.write("".join(line + "\n" for line in hall.lines_at(*place)))
        process.stdin.flush()
        self.assertTrue(self.browser.wait("document.querySelectorAll('#beacons button').length === 6"))
        self.browser.run("window.kept = document.querySelector(`[data-key='place B0']`), window.before = kept.closest('tr').textContent")
        process.stdin.write("".join(line + "\n" for line in hall.lines_at(2, 6, 1)))
        process.stdin.flush()
        self.assertTrue(self.browser.wait("document.querySelector('#beacons tr').textContent !== window.before"))
        self.assertTrue(self.browser.run("return window.kept.isConnected"), "a click is not lost when a state comes")
        for name, p in hall.beacons.items():
            self.browser.run("document.querySelector(`[data-key='place ${arguments[0]}']`).click()", name)
            self.browser.run("""const c = document.getElementById('plan'), box = c.getBoundingClientRect(), [x, y] = arguments;
                // the empty plan shows 20 x 15 m
                const scale = Math.min((c.clientWidth - 90) / 20, (c.clientHeight - 100) / 15);
                const at = {clientX: box.left + c.clientWidth / 2 + (x - 10) * scale, clientY: box.top + c.clientHeight / 2 - (y - 7.5) * scale, pointerId: 1, bubbles: true};
                c.setPointerCapture = () => {};
                for (const kind of ['pointerdown', 'pointerup']) c.dispatchEvent(new PointerEvent(kind, at));""", p[0], p[1])
        self.browser.run("for (const [id, value] of [['setup-radius', '0.065'], ['setup-temperature', '20,0']]) document.getElementById(id).value = value;")
        self.browser.run("document.querySelector('#setup-form button').click()")
        self.assertTrue(self.browser.wait("document.body.className === 'commissioning' && document.querySelectorAll('#beacons td').length > 0 && !document.getElementById('light-words').textContent.startsWith('No arrival')"), self.text("failure"))
        with open(os.path.join(self.folder, "run", "site.yaml"), encoding="utf-8") as file:
            places = {name: (float(x), float(y)) for name, x, y in re.findall(r"id: (B\d), position_m: \[([^,]+), ([^,]+),", file.read())}
        self.assertEqual(sorted(places), sorted(hall.beacons))
        self.assertLess(max(math.dist(place, hall.beacons[name][:2]) for name, place in places.items()), 0.1)
        self.assertEqual(self.browser.errors(), [])

    def check_layout(self, url):
        for width, height in SIZES:
            self.open(url, width, height)
            self.assertTrue(self.browser.wait("document.getElementById('legend').children.length > 3"))
            size, overflow = self.browser.run(
                "const sizes = [...document.body.querySelectorAll('*')].filter(e => e.checkVisibility() && [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()))"
                ".map(e => parseFloat(getComputedStyle(e).fontSize)); return [Math.min(...sizes), document.documentElement.scrollWidth - innerWidth]")
            self.assertGreaterEqual(size, 16)
            self.assertLessEqual(overflow, 0, f"at {width}")
            wide, order = self.browser.run("const top = id => document.getElementById(id).getBoundingClientRect().top; return [document.querySelector('th.wide').checkVisibility(), top('act') - top('plan-part')]")
            self.assertEqual(wide, width >= 600)
            if width < 900:
                self.assertLess(order, 0, "commands above the plan")
            small = self.browser.run("return [...document.querySelectorAll('button')].filter(b => b.checkVisibility()).filter(b => b.getBoundingClientRect().height < 48).length")
            self.assertEqual(small, 0, "buttons for gloves")
            if PICTURES:
                data = self.browser.cdp("Page.captureScreenshot", captureBeyondViewport=width < 600)["data"]
                with open(os.path.join(PICTURES, f"cockpit-{width}.png"), "wb") as file:
                    file.write(base64.b64decode(data))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
