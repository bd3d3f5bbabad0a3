"""The page in a browser: the line between the pictures is moved, and pixels, values and exposure are read."""

import os
import shutil
import subprocess
import unittest
from pathlib import Path

import numpy as np
from browser import Browser
from files import ROOT, scratch, write_exr

from evaluation.tonemap import MIDDLE_GREY, show

WIDTH, HEIGHT = 60, 40
A, B = np.float64([0.5, 0.25, 2.0]), np.float64([1.0, 0.5, 0.25])  # exact as half floats

READY = "return new Promise(done => { (function wait() { document.body.dataset.ready ? done(1) : setTimeout(wait, 20); })(); })"
# After a frame has been drawn, the colour at a place of the first pane, in window coordinates.
COLOR = """const [x, y] = arguments, canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();
return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(
  [...canvas.getContext('2d').getImageData(x - box.left, y - box.top, 1, 1).data].slice(0, 3)))))"""
BOX = "const b = document.querySelector('.pane').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]"
TEXT = "return document.getElementById(arguments[0]).textContent"
SET = """const e = document.getElementById(arguments[0]); e.value = arguments[1];
e.dispatchEvent(new Event(e.tagName === 'SELECT' ? 'change' : 'input'))"""


def shown(rgb, exposure):
    return np.round(255 * show(rgb[None], exposure, False)[0])


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(scratch("page"), ignore_errors=True)  # of a run before
        a = write_exr("a.exr", beauty=np.tile(A, (HEIGHT, WIDTH, 1)))
        b = write_exr("b.exr", beauty=np.tile(B, (HEIGHT, WIDTH, 1)))
        done = subprocess.run([os.path.join(ROOT, "tools/eval/compare"), a, b, "--html", scratch("page")],
                              capture_output=True, text=True, check=True)
        cls.printed = done.stdout
        cls.page = Path(scratch("page")) / "index.html"

    def setUp(self):
        self.browser = self.enterContext(Browser())
        self.browser.open(self.page.as_uri())
        self.browser.run(READY)
        left, top, width, height = self.browser.run(BOX)
        self.at = lambda x, y=0.5: (left + width * x, top + height * y)

    def assert_color(self, place, expected):
        np.testing.assert_allclose(self.browser.run(COLOR, *place), expected, atol=1)

    def test_slider(self):
        exposure = MIDDLE_GREY / B.mean()
        self.assert_color(self.at(0.45), shown(A, exposure))
        self.assert_color(self.at(0.55), shown(B, exposure))
        self.browser.drag(self.at(0.5), self.at(0.4))
        self.assertAlmostEqual(float(self.browser.run("return slider.value")), 0.4, places=2)
        self.assert_color(self.at(0.45), shown(B, exposure))
        self.assertEqual(self.browser.run(TEXT, "value-a"), "0.5  0.25  2")
        self.assertEqual(self.browser.run(TEXT, "value-b"), "1  0.5  0.25")

    def test_exposure(self):
        self.browser.run(SET, "exposure", 1.5)
        self.assertEqual(self.browser.run(TEXT, "exposure-value"), "1.5 EV")
        self.assert_color(self.at(0.45), shown(A, MIDDLE_GREY / B.mean() * 2**1.5))

    def test_zoom_is_common(self):
        """What is dragged in one of three panes moves in all: their pictures stay at equal places."""
        self.browser.run("document.querySelector('[data-mode=side]').click()")
        self.assertEqual(self.browser.run("return panes.length"), 3)
        before = self.browser.run("return [view.x, view.y]")
        x, y = self.at(1 / 6)
        self.browser.drag((x, y), (x + 40, y + 10))
        after, zoom = self.browser.run("return [view.x, view.y]"), self.browser.run("return view.zoom")
        np.testing.assert_allclose(np.subtract(before, after) * zoom, (40, 10), atol=0.01)

    def test_error_map(self):
        self.browser.run("document.querySelector('[data-mode=map]').click()")
        self.browser.run(SET, "map", "Absolute error over the mean")
        self.assert_color(self.at(0.5), (252, 253, 191))  # uniform: the top of the scale everywhere
        error = np.abs(A - B).mean() / B.mean()
        self.assertAlmostEqual(self.browser.run("return shown.a.maps[1].values[0]"), error, places=2)

    def test_table(self):
        rse = self.browser.run("return document.querySelector('#figure-rse td').textContent")
        self.assertIn(rse, self.printed)

    def test_no_network(self):
        """Nothing but the file itself was loaded."""
        self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').length"), 0)
        self.assertNotIn("http", self.page.read_text(encoding="utf-8").replace("http-equiv", ""))
