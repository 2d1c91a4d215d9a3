# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium for tests, with what it logged and what it asked the network for."""
import base64
import functools
import json
import os
import shutil
import struct
import sys
import tempfile
import time
import zlib

import numpy

SKIPPED = 77  # as ctest is told
PATIENCE_S = 120  # what a busy machine may take for what a quiet one does at once: no figure of a test


def skip_unless_possible():
    """Debian's packages, or a line that says what is missing."""
    try:
        import selenium  # noqa: F401
    except ImportError:
        print("skipped: python3-selenium is not here")
        sys.exit(SKIPPED)
    for program in ("chromium", "chromedriver"):
        if not shutil.which(program):
            print(f"skipped: {program} is not here")
            sys.exit(SKIPPED)


def pixels(png):
    """Grey values of an 8-bit PNG, rows x columns."""
    width, height, depth, kind = struct.unpack(">IIBB", png[16:26])
    assert depth == 8 and kind in (2, 6), "RGB or RGBA"
    channels = 3 if kind == 2 else 4
    data, at = b"", 8
    while at < len(png):
        length, name = struct.unpack(">I4s", png[at:at + 8])
        if name == b"IDAT":
            data += png[at + 8:at + 8 + length]
        at += length + 12
    raw = numpy.frombuffer(zlib.decompress(data), numpy.uint8).reshape(height, 1 + width * channels)
    image = numpy.zeros((height, width * channels), numpy.uint8)
    above = numpy.zeros(width * channels, numpy.uint8)
    for y in range(height):
        filtered, row = int(raw[y, 0]), raw[y, 1:].copy()
        if filtered == 1:  # each channel adds up along the row
            row = numpy.cumsum(row.reshape(width, channels), axis=0, dtype=numpy.uint8).ravel()
        elif filtered == 2:
            row = row + above
        elif filtered in (3, 4):
            for i in range(len(row)):
                left = int(row[i - channels]) if i >= channels else 0
                up, corner = int(above[i]), int(above[i - channels]) if i >= channels else 0
                if filtered == 3:
                    guess = (left + up) // 2
                else:
                    p = left + up - corner
                    guess = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))[2]
                row[i] = (int(row[i]) + guess) & 255
        image[y] = above = row
    return image.reshape(height, width, channels)[:, :, :3].mean(axis=2)


def browser_failures():
    """What is thrown where the browser or its driver gave up."""
    from selenium.common.exceptions import WebDriverException
    from urllib3.exceptions import HTTPError
    return WebDriverException, HTTPError


def again_if_the_browser_fails(tests):
    """A class of tests, each of which runs once more, in a new browser, where the browser or its driver gave up (a crash of a tab,
    a start that took too long, as a busy machine has them now and then). What a test finds wrong with a page is final."""
    def patient(test):
        @functools.wraps(test)
        def run(self):
            try:
                test(self)
            except browser_failures() as failure:
                print(f"{test.__name__}: the browser failed, once more in a new one: {str(failure).splitlines()[:1]}", file=sys.stderr)
                type(self).browser.close()
                type(self).browser = Browser()
                test(self)
        return run

    for name in [name for name in vars(tests) if name.startswith("test_")]:
        setattr(tests, name, patient(getattr(tests, name)))
    return tests


class Browser:
    STARTS = 3

    def __init__(self):
        for attempt in range(1, self.STARTS + 1):
            try:
                return self._start()
            except browser_failures() as failure:
                shutil.rmtree(self.profile, ignore_errors=True)
                if attempt == self.STARTS:
                    raise
                print(f"the browser did not start, once more: {str(failure).splitlines()[:1]}", file=sys.stderr)

    def _start(self):
        from selenium import webdriver
        from selenium.webdriver.chrome.options import Options
        from selenium.webdriver.chrome.service import Service
        from selenium.webdriver.common import utils

        class LocalService(Service):
            """Asked for by its number: a bare system may know no name for it, not even localhost."""
            service_url = property(lambda service: f"http://127.0.0.1:{service.port}")

            def is_connectable(self):
                return utils.is_connectable(self.port, "127.0.0.1")

        options = Options()
        options.binary_location = shutil.which("chromium")
        self.profile = tempfile.mkdtemp(prefix="octant-chromium-")
        # By a pipe, as the driver would look for the browser by the name localhost too.
        words = ["--headless=new", "--remote-debugging-pipe", "--window-size=1280,1000", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                 "--ignore-gpu-blocklist", "--no-first-run", "--disable-dev-shm-usage", "--disable-extensions", f"--user-data-dir={self.profile}"]
        if os.geteuid() == 0:
            words.append("--no-sandbox")  # Chromium's sandbox does not run as root
        for word in words:
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=LocalService(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(PATIENCE_S)

    def close(self):
        try:
            self.driver.quit()
        except Exception as gone:  # whatever a driver that is dead lets through
            print(f"the browser's driver is gone: {gone}", file=sys.stderr)
        shutil.rmtree(self.profile, ignore_errors=True)

    def cdp(self, name, **words):
        return self.driver.execute_cdp_cmd(name, words)

    def run(self, script, *words):
        return self.driver.execute_script(script, *words)

    def open(self, path, width=1280, height=1000, dark=False, script=True):
        self.cdp("Emulation.setScriptExecutionDisabled", value=not script)
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.driver.get_log("browser"), self.driver.get_log("performance")  # of the page before
        self.url = "file://" + os.path.abspath(path)
        self.driver.get(self.url)

    def errors(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]

    def requests(self):
        """All that the page asked for beside itself; what is in the page (data:) is not asked for."""
        asked = []
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] in ("Network.requestWillBeSent", "Network.webSocketCreated"):
                asked.append(message["params"].get("request", message["params"])["url"])
        return [url for url in asked if url.split("#")[0] != self.url and not url.startswith("data:")]

    def wait(self, script, seconds=PATIENCE_S):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.run("return " + script):
                return True
            time.sleep(0.1)
        return False

    def picture(self, selector, scale=1):
        """PNG of an element's box."""
        box = self.run("const r = document.querySelector(arguments[0]).getBoundingClientRect();"
                       "return [r.left + scrollX, r.top + scrollY, r.width, r.height]", selector)
        clip = dict(zip(("x", "y", "width", "height"), box), scale=scale)
        return base64.b64decode(self.cdp("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"])

    def paints(self, selector, before):
        """Whether an element's picture becomes another one than before."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if self.picture(selector) != before:
                return True
            time.sleep(0.5)
        return False
