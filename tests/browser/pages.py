# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""The pages that are looked at, written by octant: of a hall, of one with echoes, and of one whose names are meant to do harm."""
import csv
import json
import os
import shutil
import subprocess
import tempfile

import yaml

SOURCES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HOSTILE = ["<script>alert(1)</script>", '"];//', "</script><b>bold</b>", "]]>", "&lt;", "<img src=x onerror=\"document.title='taken'\">",
           "<a href='javascript:alert(1)'>B6</a>", "var(--bad)"]


class Pages:
    """In a folder of their own. found, echoing: what calibrate said of the hall and of that with echoes."""

    def __init__(self, octant):
        self.program = octant
        self.folder = tempfile.mkdtemp(prefix="octant-browser-")
        at = self.at
        self.octant("demo", "-o", at("hall"), "-q")
        self.found = json.loads(self.octant("calibrate", at("hall/site.yaml"), at("hall/run"), "-o", at("d.json"), "--report", at("r.json"), "--json"))
        self.octant("report", at("r.json"), at("hall/heldout"), "--since", at("hall/deployment.true.json"), "-o", at("good.html"))
        self.octant("report", at("r.json"), at("hall/heldout"), "--since", at("hall/deployment.true.json"), "-o", at("still.html"), "--report-static")
        self.octant("report", at("d.json"), "--site-sheet", at("sheet.html"))
        self._echoes()
        self._hostile_site()
        self.octant("calibrate", at("hostile/site.yaml"), at("hostile/run"), "-o", at("h.json"), "--report", at("hostile.html"))
        self.octant("report", at("h.json"), "--site-sheet", at("hostile-sheet.html"))
        self._hostile_hall()
        self.octant("survey", at("hall.yaml"), "-o", at("survey.html"))
        self.octant("survey", at("hall.yaml"), "-o", at("survey-still.html"), "--report-static")

    def at(self, name):
        return os.path.join(self.folder, name)

    def octant(self, *words, exit_code=0):
        done = subprocess.run([self.program, *words, "--progress", "none"], capture_output=True, text=True)
        assert done.returncode == exit_code, (words, done.returncode, done.stderr)
        return done.stdout

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def _echoes(self):
        """A hall in which one arrival in eight is an echo."""
        with open(os.path.join(SOURCES, "datasets/hall/scenario.yaml")) as file:
            scenario = file.read()
        with open(self.at("echoes.yaml"), "w") as file:
            file.write(scenario + "\necho_fraction: 0.12\n")
        self.octant("simulate", self.at("echoes.yaml"), "-o", self.at("echoes"))
        self.echoing = json.loads(self.octant("calibrate", self.at("echoes/site.yaml"), self.at("echoes/run"), "-o", self.at("e.json"),
                                               "--report", self.at("echoes.html"), "--json"))

    def _hostile_site(self):
        """The hall with beacons whose names are meant to do harm."""
        shutil.copytree(self.at("hall"), self.at("hostile"))
        with open(self.at("hall/site.yaml")) as file:
            site = yaml.safe_load(file)
        new = {beacon["id"]: name for beacon, name in zip(site["beacons"], HOSTILE)}
        for beacon in site["beacons"]:
            beacon["id"] = new[beacon["id"]]
        site["name"] = HOSTILE[0]
        with open(self.at("hostile/site.yaml"), "w") as file:
            yaml.safe_dump(site, file)
        with open(self.at("hall/run/tof.csv")) as file:
            rows = list(csv.reader(file))
        column = rows[0].index("beacon")
        for row in rows[1:]:
            row[column] = new[row[column]]
        with open(self.at("hostile/run/tof.csv"), "w", newline="") as file:
            csv.writer(file).writerows(rows)

    def _hostile_hall(self):
        """That site with walls and routes of such names, for a survey."""
        with open(self.at("hostile/site.yaml")) as file:
            site = yaml.safe_load(file)
        site["scene"] = {"floor_m": [[0, 0], [20, 0], [20, 12], [0, 12]], "cell_m": 1.0, "acoustics": {"range_m": 15.0},
                         "obstacles": [{"id": HOSTILE[0], "points_m": [[4, 4], [6, 4], [6, 6], [4, 6]], "top_m": 3.0}],
                         "walls": [{"id": HOSTILE[1], "points_m": [[12, 5], [16, 5]], "top_m": 3.0}, {"id": HOSTILE[5], "points_m": [[9, 9], [9, 11]], "top_m": 2.0}],
                         "routes": [{"id": HOSTILE[6], "points_m": [[1, 1], [18, 1], [18, 9]]}]}
        with open(self.at("hall.yaml"), "w") as file:
            yaml.safe_dump(site, file)
