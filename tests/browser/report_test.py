# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Reports in a real browser: report_test.py OCTANT [unittest's words]. Exit 77: there is no browser here."""
import base64
import json
import os
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser, again_if_the_browser_fails, pixels, skip_unless_possible  # noqa: E402
from pages import HOSTILE, Pages  # noqa: E402

OCTANT = ""
SCREENS = ((1280, 900), (400, 800))  # a desk's, a phone's


class Reports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pages = Pages(OCTANT)
        cls.browser = Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.pages.remove()

    def at(self, name):
        return self.pages.at(name)

    def assert_quiet(self):
        self.assertEqual(self.browser.errors(), [])
        self.assertEqual(self.browser.requests(), [])

    def draw_all(self):
        """As a reader would: down to the end of the page."""
        b = self.browser
        figures = b.run("return [...document.querySelectorAll('figure[data-live]')].map(f => f.id)")
        has_webgl = b.run("return !!document.createElement('canvas').getContext('webgl')")
        for figure in figures:
            b.run("document.getElementById(arguments[0]).scrollIntoView({behavior: 'instant', block: 'center'})", figure)
            if figure == "figure-space" and not has_webgl:
                print("no WebGL here: the view in space is not looked at")
                continue
            self.assertTrue(b.wait(f"document.getElementById('{figure}').dataset.drawn === '1'"), figure)
        return figures

    def is_live(self):
        return self.browser.run("return !!document.getElementById('plotly-js') || 'Plotly' in window")

    def test_every_figure_is_drawn(self):
        b = self.browser
        b.open(self.at("good.html"))
        if not self.is_live():
            self.skipTest("built without plotly.js")
        figures = self.draw_all()
        self.assertEqual(len(figures), 10)
        for figure in figures:
            # An empty frame of one colour varies by nothing, one with axes alone by some 5.
            self.assertGreater(pixels(b.picture(f"#{figure}", 0.5)).std(), 8, figure)
        # What the drawings hold: 5 calibrated beacons and 3 control points, as many bins as the tables have rows.
        names = b.run("return [...document.querySelectorAll('#figure-plan .textpoint')].map(t => t.textContent)")
        self.assertEqual(sorted(names), [f"B{i}" for i in range(8)])
        for by, bins in (("beacon", 8), ("stop", 150), ("distance", 8), ("time", 16)):
            self.assertEqual(b.run(f"return document.querySelectorAll('#figure-residuals-{by} .points path.point').length"), bins)
            self.assertEqual(b.run(f"return document.querySelectorAll('#residuals-by-{by} tbody tr').length"), bins)
            # And they stand where the table says.
            table = b.run(f"return [...document.querySelectorAll('#residuals-by-{by} tr')].map(r => [...r.cells].map(c => c.textContent))")
            mean = next(i for i, name in enumerate(table[0]) if name.startswith("mean [µs"))
            drawn = b.run(f"return [...document.querySelector('#figure-residuals-{by} .live').data[0].y]")
            for value, row in zip(drawn, table[1:]):
                self.assertAlmostEqual(value, float(row[mean]), delta=0.006)  # printed to a hundredth
        self.assert_quiet()

    def test_table_says_what_json_says(self):
        b = self.browser
        b.open(self.at("good.html"))
        table = b.run("return [...document.querySelectorAll('#beacon-table tr')].map(r => [...r.cells].map(c => c.textContent))")
        head, rows = table[0], table[1:]
        self.assertEqual(len(rows), 8)
        reliability = {x["id"]: x for x in self.pages.found["reliability"]["beacons"]}
        for beacon, row in zip(self.pages.found["beacons"], rows):
            cell = dict(zip(head, row))
            self.assertEqual(cell["beacon"], beacon["id"])
            for i, axis in enumerate("xyz"):
                self.assertEqual(cell[f"{axis} [m]"], f"{beacon['position_m'][i]:.4f}")
                self.assertEqual(cell[f"U {axis} [mm]"], f"{2e3 * beacon['sigma_m'][i]:.2f}" if beacon["sigma_m"][i] > 0 else "fixed")
            self.assertEqual(cell["delay [µs]"], f"{1e6 * beacon['delay_s']:.3f}")
            self.assertEqual(cell["U delay [µs]"], f"{2e6 * beacon['delay_sigma_s']:.3f}")
            of = reliability[beacon["id"]]
            self.assertEqual(cell["r"], f"{of['mean_redundancy_number']:.2f}")
            self.assertEqual(cell["MDB [µs]"], f"{1e6 * of['mdb_s']['median']:.1f}")
            self.assertEqual(cell["arrivals"], str(of["used"]))
            self.assertEqual(cell["rejected"], str(sum(of["rejected"].values())))
            self.assertEqual(cell["status"], {"control_point": "control point"}.get(beacon["status"], beacon["status"]))

    def test_choices_work(self):
        b = self.browser
        b.open(self.at("good.html"))
        if not self.is_live():
            self.skipTest("built without plotly.js")
        self.draw_all()
        for figure in ("figure-plan", "figure-loss"):
            n = b.run(f"return document.querySelectorAll('#drawing-{figure} input').length")
            self.assertGreaterEqual(n, 2)
            shown = f"document.querySelector('#{figure} .live').data.filter(t => t.type === 'heatmap').map(t => t.visible)"
            for k in range(n):
                b.run(f"document.getElementById('choice-{figure}-{k}').click()")
                want = json.dumps([i == k for i in range(n)])
                self.assertTrue(b.wait(f"JSON.stringify({shown}) === JSON.stringify({want})"), (figure, k))
        # By keyboard: the arrow goes from one choice to the next.
        from selenium.webdriver.common.keys import Keys
        first = b.driver.find_element("id", "choice-figure-plan-0")
        b.run("arguments[0].click(); arguments[0].focus()", first)
        first.send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(b.run("return document.activeElement.id"), "choice-figure-plan-1")
        self.assertTrue(b.run("return document.activeElement.checked"))
        # The drawings come back where the reader does not want the others.
        b.run("document.getElementById('all-live').click()")
        self.assertEqual(b.run("return document.querySelectorAll('figure.is-live').length"), 0)
        self.assertEqual(b.run("return getComputedStyle(document.querySelector('#figure-plan .still')).display"), "block")
        self.assert_quiet()

    def test_whole_without_javascript(self):
        b = self.browser
        for page in ("good.html", "still.html"):
            b.open(self.at(page), script=False)
            for figure in b.run("return [...document.querySelectorAll('figure')].map(f => f.id)"):
                self.assertGreater(pixels(b.picture(f"#{figure} svg", 0.5)).std(), 8, (page, figure))
            displays = "return [...document.querySelectorAll('#figure-plan g.layer')].map(g => getComputedStyle(g).display)"
            before = b.picture("#figure-plan svg")
            b.driver.find_element("id", "choice-figure-plan-1").click()
            self.assertEqual(b.run(displays), ["none", "block", "none", "none"])
            self.assertTrue(b.paints("#figure-plan svg", before), page)
            self.assertEqual(b.run("return getComputedStyle(document.querySelector('.controls') || document.createElement('p')).display") in ("none", ""), True)
            self.assert_quiet()
        self.assertLess(os.path.getsize(self.at("still.html")), 500_000)
        self.assertLess(os.path.getsize(self.at("good.html")), 3_000_000)

    def test_nothing_is_wider_than_the_window(self):
        b = self.browser
        for page in ("good.html", "still.html", "hostile.html", "sheet.html"):
            for width, dark in ((1280, False), (390, True)):
                b.open(self.at(page), width=width, dark=dark)
                if page == "good.html" and width == 390 and self.is_live():
                    self.draw_all()
                self.assertLessEqual(b.run("return document.documentElement.scrollWidth"), width, (page, width))
                self.assertEqual(b.run("return getComputedStyle(document.body).backgroundColor"), "rgb(18, 24, 30)" if dark else "rgb(255, 255, 255)")
                self.assert_quiet()

    def test_first_screen_says_what_to_do_and_where(self):
        b = self.browser
        box = "const r = document.querySelector(arguments[0]).getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]"
        for page in ("good.html", "still.html", "echoes.html"):
            for width, height in SCREENS:
                b.open(self.at(page), width=width, height=height)
                of = (page, width)
                sentence, step = b.run(box, "#sentence"), b.run(box, "[aria-labelledby=next] li")
                plan = b.run(box, "#figure-plan")  # still or live
                self.assertLess(sentence[3], 0.4 * height, of)
                self.assertLess(sentence[3], step[1], of)  # the verdict first, then what to do, then where
                self.assertLess(step[3], plan[1], of)
                self.assertLess((plan[1] + plan[3]) / 2, height, of)  # half of it and more
                self.assertLessEqual(b.run("return document.documentElement.scrollWidth"), width, of)
        b.open(self.at("still.html"), width=400, height=800)
        for figure in b.run("return [...document.querySelectorAll('figure')].map(f => f.id)"):
            left, _, right, _ = b.run(box, f"#{figure} svg")
            self.assertGreaterEqual(left, 0, figure)
            self.assertLessEqual(right, 400, figure)  # whole, nothing to scroll for

    def test_a_wide_table_is_read_on_a_phone_without_scrolling_aside(self):
        b = self.browser
        for page in ("good.html", "still.html", "hostile.html"):
            b.open(self.at(page), width=390, height=800)
            tables = b.run("return [...document.querySelectorAll('table.wide')].map(t => [t.id, t.parentElement.scrollWidth, t.parentElement.clientWidth])")
            self.assertIn("beacon-table", [table[0] for table in tables])
            for name, content, room in tables:
                self.assertLessEqual(content, room, (page, name))
            # Each value stands beside its column's name, and the same names are the heads of a desk's table.
            labels = b.run("return [...document.querySelector('#beacon-table tbody tr').querySelectorAll('td')].map(c => getComputedStyle(c, '::before').content)")
            heads = b.run("return [...document.querySelectorAll('#beacon-table thead th')].slice(1).map(c => c.textContent)")
            self.assertEqual(labels, [f'"{head}"' for head in heads])
            self.assertEqual(b.run("return getComputedStyle(document.querySelector('#beacon-table thead')).display"), "none")
            b.open(self.at(page), width=1280)
            self.assertEqual(b.run("return getComputedStyle(document.querySelector('#beacon-table thead')).display"), "table-header-group")
            self.assert_quiet()

    def test_survey_is_judged_at_its_tolerance(self):
        b = self.browser
        for page in ("survey.html", "survey-still.html"):
            for width, height in SCREENS:
                b.open(self.at(page), width=width, height=height)
                said, tone = b.run("const p = document.getElementById('sentence'); return [p.textContent.replaceAll('\\u00a0', ' '), p.className]")
                self.assertEqual(tone.split()[-1], "good" if said.startswith("Good ") else "bad")
                self.assertIn("of the floor is within the tolerance of 50 mm", said)
                step = b.run("return document.querySelector('[aria-labelledby=next] li').getBoundingClientRect().bottom")
                self.assertLess(step, height)
                self.assertLessEqual(b.run("return document.documentElement.scrollWidth"), width)
                self.assert_quiet()
        # The drawing in classes of the tolerance; not a red bin where the banner says that all is well.
        fills = b.run("return [...document.querySelectorAll('#figure-maps .layer-0 g[shape-rendering] path')].map(p => p.getAttribute('fill'))")
        classes = ["#d9f0d3", "#b2dfa5", "#8cc97d", "#f6b53c", "#e8713c", "#bf2f2f", "#6b0f1a", "#787878"]
        self.assertEqual([f for f in fills if f not in classes], [])
        if said.startswith("Good 100.0 %"):
            self.assertEqual([f for f in fills if f in classes[4:]], [])

    def test_what_was_left_out_is_on_a_map(self):
        b = self.browser
        left_out = self.pages.echoing["left_out"]["arrivals"]
        self.assertGreater(left_out["total"], 100)
        for width, height in SCREENS:
            b.open(self.at("echoes.html"), width=width, height=height)
            if self.is_live():
                self.draw_all()
            places = b.run("return [...document.querySelectorAll('#figure-left-out .missed title')].map(t => parseInt(t.textContent))")
            self.assertEqual(sum(places), left_out["total"])  # none is lost on the way
            self.assertGreater(b.run("return document.querySelectorAll('#figure-left-out path.miss:not(.legend *)').length"), 50)
            rows = b.run("return [...document.querySelectorAll('#left-out-table tbody tr')].map(r => [...r.cells].map(c => c.textContent))")
            self.assertEqual(len(rows), len(places))
            self.assertEqual(sum(int(row[4]) + int(row[5]) + int(row[6]) for row in rows), left_out["total"])
            right = b.run("return document.querySelector('#figure-left-out svg').getBoundingClientRect().right")
            self.assertLessEqual(right, width)
            self.assertGreater(pixels(b.picture("#figure-left-out svg", 0.5)).std(), 8)
            self.assert_quiet()

    def test_every_table_leads_to_its_words(self):
        b = self.browser
        for width, height in SCREENS:
            b.open(self.at("echoes.html"), width=width, height=height)
            words = b.run("return [...document.querySelectorAll('#words-table tbody th')].map(t => t.textContent)")
            for word in ("arrival", "mdb", "variance factor", "control point", "moved from the site file", "redundancy", "lateness", "late", "gate"):
                self.assertIn(word, words)
            links = b.run("return document.querySelectorAll('caption a.words-link').length")
            self.assertGreater(links, 5)
            # At once, and it stays there: no drawing passed on the way, none that comes later moves it.
            b.run("document.querySelector('#caption-beacon-table a.words-link').click()")
            top = "Math.abs(document.getElementById('words').getBoundingClientRect().top)"
            self.assertTrue(b.wait(f"{top} < 2"))
            b.wait(f"{top} > 2", 2)
            self.assertLess(b.run(f"return {top}"), 2)
            table = b.run("const r = document.getElementById('words-table').getBoundingClientRect(); return [r.left, r.right]")
            self.assertLessEqual(table[1], width)  # read without scrolling aside
            self.assert_quiet()

    def test_no_chart_has_one_point(self):
        b = self.browser
        for page in ("good.html", "echoes.html", "hostile.html"):
            b.open(self.at(page))
            for by, rows in b.run("return [...document.querySelectorAll('table[id^=residuals-by-]')].map(t => [t.id, t.tBodies[0].rows.length])"):
                self.assertGreater(rows, 1, (page, by))
            fixed = b.run("return [...document.querySelectorAll('#beacon-table tbody tr')].filter(r => r.textContent.includes('control point')).map(r => r.cells[4].textContent)")
            self.assertEqual(set(fixed), {"fixed"})

    def test_paper_has_all_sections(self):
        if not shutil.which("pdftotext"):
            self.skipTest("poppler-utils is not here")
        b = self.browser
        for page in ("good.html", "still.html"):
            b.open(self.at(page))
            if page == "good.html" and self.is_live():
                self.draw_all()
            titles = b.run("return [...document.querySelectorAll('h2')].map(h => h.textContent)")
            self.assertEqual(len(titles), 11)
            b.cdp("Emulation.setEmulatedMedia", features=[])
            pdf = base64.b64decode(b.cdp("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"])
            with open(self.at("page.pdf"), "wb") as file:
                file.write(pdf)
            text = subprocess.run(["pdftotext", "-layout", self.at("page.pdf"), "-"], capture_output=True, text=True, check=True).stdout
            for title in titles:
                self.assertIn(title, text)
            self.assertIn("drawn 100 times as large as they are", text)  # the still plan, not the other
            last = self.pages.found["beacons"][-1]
            row = [line for line in text.splitlines() if line.split()[:2] == [last["id"], f"{last['position_m'][0]:.4f}"]]
            self.assertEqual(len(row), 1)
            self.assertIn("calibrated", row[0])  # the last column is on the paper too
            info = subprocess.run(["pdfinfo", self.at("page.pdf")], capture_output=True, text=True, check=True).stdout
            self.assertRegex(info, r"Page size: +59[45][.0-9]* x 84[12]")  # A4 in points

    def test_hostile_names_do_nothing(self):
        b = self.browser
        kinds = "return ['script', 'style', 'img', 'b', 'iframe', 'table', 'figure', 'fieldset'].map(k => document.body.querySelectorAll(k).length)"
        b.open(self.at("hostile.html"))
        title = b.run("return document.title")
        counts = b.run(kinds)
        live = self.is_live()
        if live:
            self.draw_all()
        self.assertEqual(counts[2:5], [0, 0, 0])
        self.assertEqual(b.run("return document.title"), title)
        self.assertTrue(title.startswith(HOSTILE[0]))
        names = b.run("return [...document.querySelectorAll('#beacon-table tbody th')].map(t => t.textContent)")
        self.assertEqual(names, HOSTILE)
        self.assertEqual(b.run("return [...document.querySelectorAll('#figure-plan .still .name')].map(t => t.textContent)"), HOSTILE)
        if live:
            labels = b.run("return [...document.querySelectorAll('#figure-plan .live .textpoint')].map(t => t.textContent)")
            self.assertEqual(sorted(labels), sorted(HOSTILE))
            self.assertEqual(b.run("return document.querySelectorAll('.live a[*|href]').length"), 0)
            b.run("document.querySelectorAll('fieldset input').forEach(i => i.click())")
            data = b.run("return document.querySelector('#figure-residuals-beacon .live').data[0].x")
            self.assertEqual(len(data), len(HOSTILE))
        from selenium.common.exceptions import NoAlertPresentException
        with self.assertRaises(NoAlertPresentException):
            b.driver.switch_to.alert.accept()
        self.assert_quiet()
        b.open(self.at("hostile-sheet.html"))
        self.assertEqual(b.run("return document.querySelectorAll('img, script, b, a').length"), 0)
        self.assert_quiet()

    def test_survey_is_drawn_and_quiet(self):
        b = self.browser
        b.open(self.at("survey.html"))
        self.assertEqual(b.run("return ['script', 'img', 'b', 'a[href^=javascript]'].map(k => document.querySelectorAll('main ' + k + ':not([type])').length)"), [0, 0, 0, 0])
        figure = "#figure-maps"
        if self.is_live():
            self.assertEqual(self.draw_all(), ["figure-maps"])
            self.assertGreater(pixels(b.picture(figure, 0.5)).std(), 8)
            shown = b.run(f"return [...document.querySelectorAll('{figure} .live .textpoint')].map(t => t.textContent)")
            self.assertEqual(sorted(t for t in shown if t), sorted(HOSTILE + [HOSTILE[0], HOSTILE[1], HOSTILE[5], HOSTILE[6]]))  # beacons, walls, the route
            self.assertEqual(b.run("return document.querySelectorAll('.live a[*|href]').length"), 0)
            traces = b.run(f"return document.querySelector('{figure} .live').data.map(t => t.name)")
            self.assertIn("wall", traces)
            self.assertIn("route", traces)
            # Each map can be chosen.
            n = b.run(f"return document.querySelectorAll('#drawing-{figure[1:]} input').length")
            self.assertGreater(n, 8)
            for k in range(n):
                b.run(f"document.getElementById('choice-{figure[1:]}-{k}').click()")
                want = json.dumps([i == k for i in range(n)])
                visible = f"document.querySelector('{figure} .live').data.filter(t => t.type === 'heatmap').map(t => t.visible)"
                self.assertTrue(b.wait(f"JSON.stringify({visible}) === JSON.stringify({want})"), k)
        self.assert_quiet()
        for page in ("survey.html", "survey-still.html"):
            b.open(self.at(page), script=False, width=390)
            self.assertGreater(pixels(b.picture(f"{figure} svg", 0.5)).std(), 8, page)
            self.assertLessEqual(b.run("return document.documentElement.scrollWidth"), 390, page)
            choice = b.driver.find_element("id", "choice-figure-maps-1")
            b.run("arguments[0].scrollIntoView({behavior: 'instant', block: 'center'})", choice)
            choice.click()
            displays = b.run(f"return [...document.querySelectorAll('{figure} g.layer')].map(g => getComputedStyle(g).display)")
            self.assertEqual([i for i, d in enumerate(displays) if d != "none"], [1])
            names = b.run("return [...document.querySelectorAll('#routes-table tbody th')].map(t => t.textContent)")
            self.assertEqual(names, [HOSTILE[6]])
            self.assert_quiet()
        self.assertLess(os.path.getsize(self.at("survey-still.html")), 500_000)
        self.assertLess(os.path.getsize(self.at("survey.html")), 3_000_000)

    def test_codes_can_be_read(self):
        if not shutil.which("zbarimg"):
            self.skipTest("zbar-tools is not here")
        b = self.browser
        for sheet, deployment, names in (("sheet.html", "d.json", [f"B{i}" for i in range(8)]), ("hostile-sheet.html", "h.json", HOSTILE)):
            with open(self.at(deployment)) as file:
                truth = json.load(file)
            b.open(self.at(sheet))
            for i, beacon in enumerate(truth["beacons"]):
                with open(self.at("code.png"), "wb") as file:
                    file.write(b.picture(f".tag:nth-child({i + 1}) svg"))
                read = subprocess.run(["zbarimg", "--quiet", "--raw", "-Sdisable", "-Sqrcode.enable", self.at("code.png")], capture_output=True, text=True)
                tag = json.loads(read.stdout)
                self.assertEqual((tag["beacon"], tag["site"], tag["deployment"]), (names[i], truth["site"], truth["digest"]))
                self.assertEqual(tag["position_m"], [round(x, 4) for x in beacon["position_m"]])


if __name__ == "__main__":
    skip_unless_possible()
    OCTANT = os.path.abspath(sys.argv.pop(1))
    again_if_the_browser_fails(Reports)
    unittest.main(verbosity=2)
