"""report.html in a real browser: it turns, it plays, its colours are those of the PNG pictures, and nothing leaves the file.

    python3 tests/app/report/turn_page.py build/limberg [FOLDER for pictures]        (Debian: chromium)

Without Chromium, or where the program has no viewer, it says so and is skipped.
"""
import os
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Browser, chromium, difference, file_picture  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else "build/limberg"
PICTURES = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else None
V = "document.getElementById('viewer').limberg"
READY = f"!!{V} || !!document.querySelector('#viewer .notice')"

# Of the difference of a PNG's colours and the page's, of 255 levels, over places of the skin: the median and nine in ten.
# The page has no shadow, no darkening of hollows and lines of the grid of another width.
MEDIAN, MOST = 2, 12


def skip(why):
    print("report_in_chromium: Skipped")
    print(why)
    sys.exit(77)


if not chromium():
    skip("needs Chromium; Debian: chromium")


def operate(scene, script, out, *more):
    done = subprocess.run([PROGRAM, "operate", scene, script, "--out", out, *more], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise RuntimeError(done.stderr)


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="limberg-pages-")
        cls.expert, cls.student, cls.head = (os.path.join(cls.folder.name, n) for n in ("expert", "student", "head"))
        operate("rhomboid", "recordings/rhomboid.jsonl", cls.expert, "--cell-mm", "5")
        if not os.path.exists(os.path.join(cls.expert, "model.glb")):
            skip("this program was built without a viewer (libjs-three)")
        operate("rhomboid", "recordings/rhomboid.jsonl", cls.student, "--cell-mm", "7")
        operate("craniofacial", "recordings/craniofacial.jsonl", cls.head)
        cls.both = os.path.join(cls.folder.name, "both.html")
        subprocess.run([PROGRAM, "report", "--compare", cls.expert, cls.student, "--out", cls.both], check=True,
                       stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def browser(self, **more):
        b = Browser(chromium(), **more)
        self.addCleanup(b.close)
        b.size(1280, 800)
        return b

    def opened(self, page, width=1280, height=800, phone=False):
        b = self.browser()
        b.size(width, height, phone)
        b.open(page)
        b.wait(READY)
        self.assertTrue(b.run(f"!!{V}"), b.run("document.querySelector('#viewer .notice')?.textContent"))
        b.run("document.querySelector('#viewer .stage').scrollIntoView({block: 'center'})")
        self.settle(b)
        return b

    @staticmethod
    def settle(b):
        """Until nothing moves and the picture is there."""
        b.run(f"(async () => {{ while ({V}.moving || {V}.playing) await new Promise((d) => setTimeout(d, 30));"
              " for (let i = 0; i < 3; ++i) await new Promise(requestAnimationFrame); })()")

    def stage(self, b, name=None):
        self.settle(b)
        return b.picture(PICTURES and name and os.path.join(PICTURES, name + ".png"), "#viewer .stage")

    def quiet(self, b):
        self.assertEqual(b.errors, [])
        away = [r for r in b.requests if not r.startswith(("data:", "file:"))]
        self.assertEqual(away, [])
        self.assertEqual(len([r for r in b.requests if r.startswith("file:")]), 1)

    @staticmethod
    def changed(a, b):
        """The share of places whose colour is another."""
        places = [(x, y) for y in range(4, a.height - 4, 9) for x in range(4, a.width - 4, 9)]
        return sum(difference(a.pixel(*p), b.pixel(*p)) > 8 for p in places) / len(places)

    def middle(self, b):
        return b.run("(() => { const r = document.querySelector('#viewer canvas').getBoundingClientRect();"
                     " return [r.x + r.width / 2, r.y + r.height / 2] })()")

    def test_turns_and_goes_back(self):
        b = self.opened(self.expert + "/report.html")
        first = self.stage(b, "turn-0")
        x, y = self.middle(b)
        b.drag(x, y, x + 180, y + 40)
        turned = self.stage(b, "turn-1")
        self.assertGreater(self.changed(first, turned), 0.2)
        b.key("Home")
        self.assertLess(self.changed(first, self.stage(b)), 0.002)
        for key, least in (("ArrowLeft", 0.05), ("+", 0.05)):
            b.key("Home")
            b.key(key)
            self.assertGreater(self.changed(first, self.stage(b)), least, key)
        b.key("Home")
        b.mouse("mouseWheel", x, y, deltaX=0, deltaY=-240)  # it has the focus: the wheel is its own
        self.assertGreater(self.changed(first, self.stage(b)), 0.05)
        b.key("Home")
        b.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        b.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": x - 120, "y": y}])
        b.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        self.assertGreater(self.changed(first, self.stage(b)), 0.1)
        self.quiet(b)

    def test_plays_from_act_to_act(self):
        b = self.opened(self.expert + "/report.html")
        acts = b.run(f"{V}.told.acts.filter((a) => !a.stage).length")
        self.assertEqual(acts, 18)
        closed = self.stage(b)
        b.run("document.querySelector('#viewer input[type=range]').focus()")
        said = []
        for _ in range(3):
            b.key("ArrowLeft")
            said.append(b.run("document.querySelector('#viewer input[type=range]').getAttribute('aria-valuetext')"))
        self.assertEqual(len(set(said)), 3, said)
        # Each stage by its button: other places, its name.
        pictures = [closed]
        for i, name in enumerate(("Defect", "Flap cut", "Undermined", "Flap raised")):
            b.run(f"document.querySelectorAll('#viewer .chips button')[{i}].click()")
            self.assertIn(name.lower(), b.run("document.querySelector('#viewer .now').textContent"))
            pictures.append(self.stage(b, f"stage-{i + 1}"))
        for p in pictures[1:]:
            self.assertGreater(self.changed(closed, p), 0.02)
        # Half way between two acts the patient is half way.
        way = b.run(f"(() => {{ const p = {V}.patients[0], x = (t) => {{ {V}.goTo(t);"
                    " return Array.from(p.shapes[p.shown].position.array) };"
                    " const a = x(6), b = x(7), c = x(6.5); let off = 0, far = 0;"
                    " for (let i = 0; i < a.length; ++i) { off = Math.max(off, Math.abs(c[i] - (a[i] + b[i]) / 2));"
                    " far = Math.max(far, Math.abs(b[i] - a[i])) } return [off, far] })()")
        self.assertLess(way[0], 1e-3)
        self.assertGreater(way[1], 1)
        b.run(f"{V}.goTo(0); {V}.toggle()")
        b.wait(f"{V}.at > 2")
        b.run(f"{V}.toggle()")
        self.quiet(b)

    def compare_colours(self, field, png, folder, name, face=None):
        # As the program chooses the eye, so that the pictures lie upon each other.
        made = file_picture(os.path.join(folder, png))
        b = self.opened(folder + "/report.html", made.width + 60, made.height + 120)
        b.run("(() => { const s = document.querySelector('#viewer .stage').style; document.body.style.maxWidth = 'none';"
              f" s.width = '{made.width}px'; s.height = '{made.height}px' }})()")
        if face:
            b.run(f"{V}.showFace('{face}')")
        which = b.run(f"{V}.told.fields.findIndex((f) => f.name === '{field}')")
        self.assertGreaterEqual(which, 0)
        b.run(f"{V}.colourBy({which}); {V}.showForces(false); {V}.legend.hidden = true")
        b.run("new Promise((d) => setTimeout(d, 300))")
        page = self.stage(b, name)
        self.assertEqual((page.width, page.height), (made.width, made.height))
        places = [(x, y) for y in range(40, made.height - 10, 29) for x in range(20, made.width - 10, 31)
                  if y > 130 and x < 0.78 * made.width]  # neither its title nor its legend
        here = b.run(f"{str([list(p) for p in places])}.map(([x, y]) => {V}.valueAt(x / {made.width}, y / {made.height}) !== null)")
        off = sorted(difference(page.mean(*p, 1), made.mean(*p, 1)) for p, on in zip(places, here) if on)
        self.assertGreater(len(off), 120)
        print(f"{name}: {len(off)} places, median {off[len(off) // 2]:.1f}, nine in ten {off[int(0.9 * len(off))]:.1f} of 255")
        self.assertLessEqual(off[len(off) // 2], MEDIAN)
        self.assertLessEqual(off[int(0.9 * len(off))], MOST)
        self.quiet(b)

    def test_colours_of_displacement_are_those_of_the_picture(self):
        self.compare_colours("Displacement", "moved.png", self.expert, "colours-moved")

    def test_colours_of_height_are_those_of_the_picture(self):
        self.compare_colours("Height: dog-ears", "height.png", self.expert, "colours-height")

    def test_colours_of_a_face_are_those_of_the_picture(self):
        self.compare_colours("Displacement", "head/moved.png", self.head, "colours-face", "solid")

    def test_a_face_has_its_picture(self):
        """Brows, lips and hair are where the program's own picture has them."""
        script, folder = os.path.join(self.folder.name, "face.jsonl"), os.path.join(self.folder.name, "face")
        with open(script, "w") as f:
            f.write('{"limberg_script":1,"scene":"face"}\n{"action":"stage","name":"before"}\n')
        operate("face", script, folder)
        made = file_picture(os.path.join(folder, "stages/01-before.png"))
        b = self.opened(folder + "/report.html", made.width + 60, made.height + 120)
        b.run("(() => { const s = document.querySelector('#viewer .stage').style; document.body.style.maxWidth = 'none';"
              f" s.width = '{made.width}px'; s.height = '{made.height}px' }})()")
        b.wait(f"{V}.patients[0].uniforms.picture.value.image.width > 1")
        places = [(int(x * made.width), int(y * made.height)) for y in (0.14 + 0.012 * i for i in range(56))
                  for x in (0.40 + 0.008 * i for i in range(26))]  # the face, as it is seen at first

        def alike(name):
            """The coefficient of correlation of how light the places are in both."""
            b.run(f"{V}.ask(); new Promise((d) => setTimeout(d, 500))")
            page = self.stage(b, name)
            pairs = [(sum(page.mean(*p, 2)), sum(made.mean(*p, 2))) for p in places]
            m = [sum(v) / len(pairs) for v in zip(*pairs)]
            var = [sum((v[i] - m[i]) * (v[j] - m[j]) for v in pairs) for i, j in ((0, 0), (1, 1), (0, 1))]
            return var[2] / (var[0] * var[1]) ** 0.5

        with_it = alike("face")
        b.run(f"{V}.patients[0].uniforms.picture.value = {V}.tables.magnitude")
        without = alike("face-without")
        print(f"face: {with_it:.3f} like the program's picture, {without:.3f} without its own")
        self.assertGreater(with_it, 0.9)
        self.assertLess(without, with_it - 0.1)
        self.quiet(b)

    def test_without_scripts_the_pictures_stay(self):
        b = self.browser(scripts=False)
        b.open(self.expert + "/report.html")
        # Scripts of the page do not run; those of the test do.
        seen = b.run("(() => ({viewer: document.getElementById('viewer').offsetHeight,"
                     " images: [...document.images].filter((i) => i.complete && i.naturalWidth > 100).length,"
                     " told: document.querySelector('noscript').textContent,"
                     " stages: document.querySelectorAll('.story figure').length})) ()")
        self.assertEqual(seen["viewer"], 0)
        self.assertGreaterEqual(seen["images"], 10)
        self.assertGreaterEqual(seen["stages"], 7)
        self.assertIn("pictures", seen["told"])
        self.quiet(b)

    def test_a_phone_shows_it_all(self):
        for page in (self.expert + "/report.html", self.head + "/report.html", self.both):
            b = self.opened(page, 390, 844, True)
            self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 390)
            shown = self.stage(b, "phone-" + os.path.basename(os.path.dirname(page)))
            self.assertLess(shown.height, 700)  # the page can be scrolled beside it
            self.quiet(b)

    def test_two_operations_from_one_eye(self):
        b = self.opened(self.both)
        self.assertEqual(b.run(f"{V}.patients.length"), 2)
        x, y = self.middle(b)
        first = self.stage(b, "both-0")
        b.drag(x - 100, y, x - 20, y)  # on the left
        turned = self.stage(b, "both-1")

        def half(p, q, from_x):
            places = [(i, j) for j in range(60, p.height - 60, 9) for i in range(from_x, from_x + p.width // 2 - 60, 9)]
            return sum(difference(p.pixel(*k), q.pixel(*k)) > 8 for k in places) / len(places)
        self.assertGreater(half(first, turned, 30), 0.2)
        self.assertGreater(half(first, turned, first.width // 2 + 30), 0.2)  # and the right one turns too
        # At a stage of one both are at it.
        b.run("document.querySelectorAll('#viewer .chips button')[3].click()")
        self.assertEqual(b.run(f"{V}.timeOf(1) === {V}.patients[1].told.acts.find((a) => a.words === 'flap raised').at"), True)
        self.quiet(b)

    # Frames of three seconds, as the screen shows them, while the patient is turned and while the operation plays.
    TURNED = """(async () => { const v = %s, until = performance.now() + 3000, at = [];
        v.goTo(v.told.until);
        await new Promise((done) => { const next = (now) => { at.push(now); v.eye.turn(.02, 0); v.ask(true);
            performance.now() < until ? requestAnimationFrame(next) : done() }; requestAnimationFrame(next) });
        return (at.length - 1) / (at[at.length - 1] - at[0]) * 1000 })()""" % V
    PLAYED = """(async () => { const v = %s, until = performance.now() + 3000, at = [];
        v.goTo(v.told.from);
        v.toggle();
        await new Promise((done) => { const next = (now) => { at.push(now);
            performance.now() < until ? requestAnimationFrame(next) : done() }; requestAnimationFrame(next) });
        v.toggle();
        return (at.length - 1) / (at[at.length - 1] - at[0]) * 1000 })()""" % V

    def test_first_picture_and_frames(self):
        for page in (self.expert, self.head):
            b = self.opened(page + "/report.html")
            first_s = b.run("Number(document.getElementById('viewer').dataset.firstPicture)") / 1000
            b.run(self.TURNED)  # finds its pace
            turned = b.run(self.TURNED)
            self.settle(b)
            played = b.run(self.PLAYED)
            print(f"{os.path.basename(page)}: first picture after {first_s:.2f} s, {turned:.0f} frames/s turned and "
                  f"{played:.0f} played, {os.path.getsize(page + '/report.html') / 1e6:.1f} MB")
            self.assertLess(first_s, 20)  # of a machine with other work; docs/report.md says what it takes alone
            self.assertGreater(min(turned, played), 4)
            self.quiet(b)

    def test_what_moves_slowly_is_coarser(self):
        b = self.opened(self.head + "/report.html")
        # A picture that moves, frames of so many ms each, so many of them; what is drawn then.
        moved = ("((gap, n) => { const v = %s, gl = v.renderer; v.ask(true); v.last_ms = 0; v.gaps = [];"
                 " for (let i = 0; i <= n; ++i) v.pace(1000 + gap * i); v.draw();"
                 " return [gl.getPixelRatio(), gl.info.render.triangles] })" % V)
        rest = f"(() => {{ const r = {V}.renderer; return [r.getPixelRatio(), r.info.render.triangles] }})()"
        whole = b.run(rest)
        fast, slow, slower = (b.run(f"{moved}({gap}, {n})") for gap, n in ((30, 6), (60, 12), (60, 60)))
        self.assertLess(fast[0], whole[0])
        self.assertLess(fast[1], whole[1])
        self.assertLess(slow[0], 0.8 * fast[0])
        self.assertLess(slower[1], 0.8 * fast[1])
        self.assertGreater(b.run(f"{moved}(16, 60)")[0], slower[0])  # time to spare again
        self.settle(b)
        b.run(f"{V}.draw()")
        self.assertEqual(b.run(rest), whole)
        self.quiet(b)

    def test_forces_stand_beside_their_stitches(self):
        b = self.opened(self.expert + "/report.html")
        off = """(() => { const v = %s, w = v.stage.clientWidth, h = v.stage.clientHeight, c = v.eye.camera;
            const stage = v.stage.getBoundingClientRect();
            const at = v.patients[0].current.stitches.map((s) => { const p = new THREE.Vector3(...s.path[3]).project(c);
                return [s.force_N.toFixed(2), w * (.5 + .5 * p.x), h * (.5 - .5 * p.y)] });
            return [...v.labels.children].map((e) => { const r = e.getBoundingClientRect();
                return Math.min(...at.filter((s) => Number(s[0]).toFixed(2) === Number(e.textContent.slice(0, -2)).toFixed(2))
                    .map((s) => Math.hypot(r.x + r.width / 2 - stage.x - s[1], r.bottom + .45 * r.height - stage.y - s[2]))) }) })()""" % V
        for turn in (0, 0.5, -0.3):
            b.run(f"{V}.eye.turn({turn}, 0); {V}.draw()")
            far = b.run(off)
            self.assertGreater(len(far), 4)
            self.assertLess(max(far), 3, f"pixels, after turning by {turn}")
        b.run(f"{V}.goTo({V}.told.from); {V}.draw()")
        self.assertEqual(b.run(off), [])  # no stitch yet, none left over

    def test_colours_are_told_where_one_points(self):
        b = self.opened(self.expert + "/report.html")
        which = b.run(f"{V}.told.fields.findIndex((f) => f.name === 'Displacement')")
        b.run(f"{V}.colourBy({which})")
        x, y = self.middle(b)
        b.mouse("mouseMoved", x, y)
        b.wait("document.querySelector('#viewer .tip').textContent !== ''", 10)
        self.assertRegex(b.run("document.querySelector('#viewer .tip').textContent"), r"^Displacement: (≥ )?[0-9.]+ mm$")


if __name__ == "__main__":
    if PICTURES:
        os.makedirs(PICTURES, exist_ok=True)
    began = time.monotonic()
    unittest.main(argv=[sys.argv[0]] + sys.argv[1:], verbosity=2)
