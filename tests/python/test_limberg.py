"""import limberg: the program's own bits and words, arrays without copies, and stubs that tell the truth.

    PYTHONPATH=build-python/python LIMBERG_PROGRAM=build/limberg /usr/bin/python3 tests/python/test_limberg.py
"""
import ast
import gc
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import limberg

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.path.abspath(os.environ.get("LIMBERG_PROGRAM", ROOT / "build/limberg"))
PACKAGE = pathlib.Path(limberg.__file__).parent


def result_of(folder):
    return json.loads(pathlib.Path(folder, "r.json").read_text())


SMALL = """name = "small"
[body]
source = "block"
size_mm = [40, 40, 10]
skin_cell_mm = 2
[[layer]]
name = "skin"
thickness_mm = 2
young_kPa = 60
poisson = 0.45
prestretch_along = 1.08
[[layer]]
name = "fat"
thickness_mm = 8
young_kPa = 15
poisson = 0.45
[lattice]
cell_mm = 5
[landmarks]
lid = [12, 3]
"""


def small_world(**more):
    return limberg.World(limberg.parse_scene(SMALL), **more)


def program(*words, cwd=None):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, cwd=cwd)


class SameBits(unittest.TestCase):
    def test_rhomboid_has_the_programs_hash_and_figures(self):
        with tempfile.TemporaryDirectory() as tmp:
            script = str(ROOT / "recordings/rhomboid.jsonl")
            done = program("operate", "rhomboid", script, "--cell-mm", "6", "--json", tmp + "/r.json", cwd=tmp)
            self.assertIn(done.returncode, (0, 3), done.stderr)
            was = result_of(tmp)
        scene = limberg.open_scene("rhomboid")
        scene.cell_mm = 6
        world = limberg.World(scene, workers=2)
        operation = world.operate(limberg.load_script(script))
        self.assertEqual(world.state_hash, was["state_hash"])
        self.assertEqual(world.topology_hash, was["topology_hash"])
        self.assertEqual([s[0] for s in operation.stages], [s["name"] for s in was["stages"]])
        found = world.measures()
        for name, value in was["metrics"].items():
            if isinstance(value, (int, float)) and name in found:
                self.assertAlmostEqual(found[name], value, delta=1e-6 * abs(value) + 1e-12, msg=name)
        self.assertGreater(len(found), 30)
        self.assertEqual([s["id"] for s in found["sutures"]], [s["id"] for s in was["metrics"]["sutures"]])

    def test_any_number_of_workers(self):
        hashes = set()
        for workers in (1, 3):
            w = small_world(workers=workers)
            w.apply(limberg.incise(path=[[-10, 0], [10, 0]], depth_mm=3))
            w.settle()
            hashes.add(w.state_hash)
        self.assertEqual(len(hashes), 1)


class Words(unittest.TestCase):
    def same(self, call, *words):
        """The exception says what the program prints after 'limberg: '."""
        with tempfile.TemporaryDirectory() as tmp:
            old = os.getcwd()
            os.chdir(tmp)
            try:
                with open("bad.toml", "w") as f:
                    f.write(SMALL.replace("poisson", "poison", 1))
                with open("bad.jsonl", "w") as f:
                    f.write('{"limberg_script":1,"scene":"rhomboid"}\n{"action":"incise","path":[[0,0]]}\n')
                with open("deep.jsonl", "w") as f:
                    f.write('{"limberg_script":1,"scene":"rhomboid"}\n{"action":"incise","path":[[0,0],[9,0]],"depth_mm":50}\n')
                with self.assertRaises(limberg.InputError) as caught:
                    call()
                done = program(*words)
                self.assertEqual(done.returncode, 2)
                self.assertEqual(done.stderr, f"limberg: {caught.exception}\n")
                return caught.exception
            finally:
                os.chdir(old)

    def test_errors_are_the_programs(self):
        e = self.same(lambda: limberg.open_scene("bad.toml"), "check", "bad.toml")
        self.assertEqual((e.file, e.line), ("bad.toml", 6))  # the layer that lacks what is misspelt
        self.assertIsInstance(e, ValueError)
        self.same(lambda: limberg.open_scene("nowhere"), "operate", "nowhere", "bad.jsonl")
        self.same(lambda: limberg.load_script("bad.jsonl"), "operate", "rhomboid", "bad.jsonl")
        self.same(lambda: limberg.World(limberg.open_scene("rhomboid")).operate(limberg.load_script("deep.jsonl")),
                  "operate", "rhomboid", "deep.jsonl")
        self.same(lambda: limberg.read_recording("bad.toml"), "replay", "bad.toml")

    def test_a_refused_act_changes_nothing(self):
        w = small_world()
        before = w.state_hash
        with self.assertRaisesRegex(limberg.Refused, "depth 50 mm is deeper than the scene allows; expected at most 9 mm"):
            w.apply(limberg.incise(path=[[-10, 0], [10, 0]], depth_mm=50))
        with self.assertRaisesRegex(limberg.Refused, "not on the skin"):
            w.apply(limberg.incise(path=[[-1000, 0], [10, 0]], depth_mm=3))
        self.assertEqual((w.state_hash, w.done), (before, []))

    def test_commands_that_cannot_be_read(self):
        w = small_world()
        for told in ({"action": "incise"}, {"action": "wave"}, '{"action":"incise","path":[[0,0],[1,"x"]]}',
                     {"action": "incise", "path": [[0, 0], [5, 0]], "colour": 1}):
            with self.assertRaisesRegex(limberg.InputError, "expected"):
                w.apply(told)
        with self.assertRaises(TypeError):
            w.apply(7)
        with self.assertRaises(limberg.InputError):
            limberg.World(limberg.parse_scene(SMALL), workers=0)
        with self.assertRaisesRegex(limberg.InputError, "no constant"):
            limberg.Material(law="ogden", constants={"mu": 3})


class Arrays(unittest.TestCase):
    def test_views_look_into_what_keeps_them(self):
        w = small_world()
        s = w.snapshot(tension=True)
        x = s.x_mm
        self.assertTrue(np.shares_memory(x, s.x_mm))
        self.assertIs(x.base, s)
        self.assertFalse(x.flags.writeable)
        self.assertEqual((x.shape[1], x.dtype), (3, np.float32))
        self.assertEqual(s.tension.shape, (len(x),))
        self.assertEqual(s.triangles.max(), len(x) - 1)
        before = x.copy()
        w.apply(limberg.incise(path=np.array([[-10, 0], [10, 0]]), depth_mm=np.float32(3)))
        w.settle()
        del s, w
        gc.collect()
        np.testing.assert_array_equal(x, before)  # a snapshot is of its moment, and lives as long as its arrays

    def test_fields(self):
        w = small_world()
        w.apply({"action": "excise", "outline": [[-5, -5], [5, -5], [5, 5], [-5, 5]], "depth_mm": 3})
        w.settle()
        f = w.lattice_fields()
        self.assertIs(f.stress_kPa.base, f)
        m = len(f.cells)
        for name, shape in dict(stretch=(m,), stress_kPa=(m, 6), pressure_kPa=(m,), material=(m,), fraction=(m,),
                                piece=(m,), cells=(m, 8)).items():
            self.assertEqual(getattr(f, name).shape, shape, name)
        self.assertEqual(f.displacement_mm.shape, f.X_mm.shape)
        self.assertLess(f.cells.max(), len(f.X_mm))
        np.testing.assert_allclose(f.pressure_kPa, -f.stress_kPa[:, :3].sum(1) / 3, atol=1e-4)
        states = w.skin_states()
        area = states.area_mm2
        self.assertIs(area.base, states)
        skin = w.snapshot().kind == 0
        self.assertEqual(len(area), len(skin))
        self.assertTrue((area[~skin] == 0).all())
        self.assertAlmostEqual(area.sum(), 40 * 40 - 100, delta=1)
        # Percentiles of the measures, from the arrays.
        order = np.argsort(states.stretch[skin])
        weight = np.cumsum(area[skin][order])
        p99 = states.stretch[skin][order][np.searchsorted(weight, 0.99 * weight[-1])]
        self.assertAlmostEqual(p99, w.measures()["stretch_p99"], delta=1e-3)

    def test_measures(self):
        w = small_world()
        m = w.measures({"here": (0, 5)})
        self.assertEqual(m["landmarks"], {"lid": 0.0, "here": 0.0})
        w.apply(limberg.incise(path=[[-10, 0], [10, 0]], depth_mm=3))
        w.apply(limberg.suture(a=[0, 1], b=[0, -1]))
        w.settle()
        m = w.measures()
        self.assertEqual(len(m["sutures"]), 1)
        self.assertAlmostEqual(m["closure_force_N"], w.snapshot().sutures[0].force_N, delta=1e-6)
        self.assertIsInstance(m["pieces"], int)


class Scripts(unittest.TestCase):
    def test_every_action_has_a_function_that_makes_it(self):
        for a in limberg.actions():
            fields = json.loads(a["example"])
            c = getattr(limberg, fields.pop("action"))(**fields)
            self.assertEqual(c, limberg.Command(a["example"]), a["name"])
            self.assertEqual(c, limberg.Command(c.fields))
            self.assertEqual(c.action, a["name"])
            doc = getattr(limberg, a["name"]).__doc__
            for f in a["fields"]:
                self.assertIn(f["help"], doc)
                if f["unit"]:
                    self.assertIn(f["unit"], doc)

    def test_round_trip(self):
        s = limberg.load_script(str(ROOT / "recordings/zplasty.jsonl"))
        again = limberg.parse_script(s.to_text())
        self.assertEqual(again.commands, s.commands)
        self.assertEqual((again.scene, len(again)), ("zplasty", len(s)))
        mine = limberg.Script([c.fields for c in s.commands], scene="zplasty", note="mine")
        self.assertEqual((mine.commands, mine.note), (s.commands, "mine"))

    def test_procedure_is_the_programs(self):
        with tempfile.TemporaryDirectory() as tmp:
            done = program("procedure", "bilobed", "--at", "0,5", "--turn", "30", "--set", "diameter_mm=12", "--out", tmp + "/b.jsonl")
            self.assertEqual(done.returncode, 0, done.stderr)
            theirs = limberg.load_script(tmp + "/b.jsonl")
        mine = limberg.procedure("bilobed", limberg.open_scene("rhomboid"), at=(0, 5), turn_deg=30,
                                 values={"diameter_mm": 12})
        self.assertEqual(mine.commands, theirs.commands)
        with self.assertRaisesRegex(limberg.InputError, "expected"):
            limberg.procedure("bilobed", limberg.open_scene("rhomboid"), values={"diameter_mm": 1e6})


class Muscles(unittest.TestCase):
    def test_a_muscle_pulls_and_rests(self):
        text = SMALL + """[[region]]
name = "bundle"
law = "muscle"
mu_kPa = 5
k1_kPa = 10
k2 = 1
active_kPa = 50
poisson = 0.45
path_mm = [[-10, 0, -5], [10, 0, -5]]
radius_mm = 3
"""
        scene = limberg.parse_scene(text)
        self.assertEqual([r["name"] for r in scene.regions], ["bundle"])
        self.assertEqual(scene.regions[0]["law"], "muscle")
        world = limberg.World(scene)

        def moved():
            world.settle()
            s = world.snapshot()
            return float(np.abs(s.x_mm - s.X_mm).max())

        rest = moved()
        world.apply(limberg.activate(region="bundle", level=0.8))
        self.assertGreater(moved(), rest + 0.3)
        world.apply(limberg.activate(region="bundle", level=0))
        self.assertAlmostEqual(moved(), rest, delta=0.01)
        with self.assertRaises(limberg.Refused):
            world.apply(limberg.activate(region="nobody", level=1))


class Recordings(unittest.TestCase):
    def test_read(self):
        r = limberg.read_recording(str(ROOT / "recordings/rhomboid.lcm"))
        s = r.stylus()
        n = len(s["t_s"])
        self.assertEqual((s["tip_mm"].shape, s["quat"].shape, s["buttons"].shape), ((n, 3), (n, 4), (n,)))
        self.assertTrue((np.diff(s["t_s"]) >= 0).all())
        np.testing.assert_allclose(np.linalg.norm(s["quat"], axis=1), 1, atol=1e-6)
        self.assertEqual((r.damaged, r.ended, r.scene().name), (0, True, "rhomboid"))
        self.assertGreater(len(r.checkpoints), 20)

    def test_write_and_replay(self):
        with tempfile.TemporaryDirectory() as tmp:
            scene = limberg.parse_scene(SMALL)
            rng = np.random.default_rng(1)
            t = np.arange(120) / 120
            tip = np.column_stack([20 * t, 0 * t, 40 + rng.normal(0, .1, 120)])
            buttons = (t > .5).astype(np.uint32)
            cut = limberg.incise(path=[[-10, 0], [10, 0]], depth_mm=3)
            file = tmp + "/mine.lcm"
            limberg.write_recording(file, scene, t_s=t, tip_mm=tip, buttons=buttons, commands=[(0.25, cut)])
            r = limberg.read_recording(file)
            s = r.stylus()
            np.testing.assert_array_equal(s["tip_mm"], tip)
            np.testing.assert_allclose(s["t_s"], t, atol=1e-9)
            np.testing.assert_array_equal(s["buttons"], buttons)
            self.assertEqual(r.commands, [(0.25, cut)])
            self.assertEqual((r.scene().hash, r.damaged), (scene.hash, 0))
            done = program("replay", file, "--json", tmp + "/r.json")
            self.assertIn(done.returncode, (0, 3), done.stderr)
            self.assertEqual(result_of(tmp)["metrics"]["pieces"], 1)
            self.assertGreater(result_of(tmp)["metrics"]["wound_gape_mm"], 0)
            with self.assertRaisesRegex(limberg.InputError, "exist"):
                limberg.write_recording(file, scene, commands=[(0, cut)])
            with self.assertRaises(ValueError):
                limberg.write_recording(file, scene, t_s=t, tip_mm=tip[:5], replace=True)
            with self.assertRaises(limberg.InputError):
                limberg.write_recording(file, scene, t_s=t, tip_mm=tip * np.nan, replace=True)
            self.assertEqual(len(limberg.read_recording(file).stylus()["t_s"]), 120)  # nothing of it was lost


class Study(unittest.TestCase):
    def test_rows(self):
        def gape(depth_mm, length_mm):
            w = small_world()
            w.apply(limberg.incise(path=[[0, -length_mm / 2], [0, length_mm / 2]], depth_mm=depth_mm))  # across the tension
            w.settle()
            return {"gape_mm": w.measures()["wound_gape_mm"]}

        rows = limberg.study(gape, depth_mm=[3, 50], length_mm=[10, 20])
        self.assertEqual([(r["depth_mm"], r["length_mm"]) for r in rows], [(3, 10), (3, 20), (50, 10), (50, 20)])
        self.assertGreater(rows[1]["gape_mm"], rows[0]["gape_mm"])
        self.assertIn("deeper", rows[2]["refused"])
        self.assertEqual(limberg.study(gape, jobs=2, depth_mm=[3, 50], length_mm=[10, 20]), rows)


class Examples(unittest.TestCase):
    def run_example(self, name, *words):
        done = subprocess.run([sys.executable, str(ROOT / "library/python/examples" / name), *words], capture_output=True,
                              text=True, env={**os.environ, "PYTHONPATH": str(PACKAGE.parent), "PYTHONIOENCODING": "utf-8"})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_flap_force(self):
        out = self.run_example("flap_force.py", "--angles", "0,90", "--cell-mm", "7")
        forces = [float(v) for v in re.findall(r"° +([\d.]+) N", out)]
        self.assertEqual(len(forces), 2, out)
        self.assertTrue(all(0.1 < f < 50 for f in forces), out)
        self.assertNotAlmostEqual(forces[0], forces[1], delta=0.005)  # the lines of tension make a difference: of 1 %

    def test_law_curve(self):
        worst = [float(v) for v in re.findall(r"closed form ([\d.e+-]+) of", self.run_example("law_curve.py"))]
        self.assertEqual(len(worst), 3)
        self.assertLess(max(worst), 1e-9)

    def test_hand_paths(self):
        with tempfile.TemporaryDirectory() as tmp:
            out = self.run_example("hand_paths.py", str(ROOT / "recordings/rhomboid.lcm"), "--csv", tmp + "/h.csv")
            rows = np.loadtxt(tmp + "/h.csv", delimiter=",", skiprows=1)
        parts = {m[0]: float(m[1]) for m in re.findall(r"^(\w+) +(\d+) mm", out, re.M)}
        step = np.linalg.norm(np.diff(rows[:, 1:4], axis=0), axis=1).sum()
        self.assertAlmostEqual(parts.pop("all"), step, delta=1)
        self.assertAlmostEqual(sum(parts.values()), step, delta=len(parts))
        self.assertGreater(parts["scalpel"], 50)


class Stubs(unittest.TestCase):
    """The .pyi, which a checker of types reads, says of the module what is there, no more and no less."""

    @classmethod
    def setUpClass(cls):
        cls.text = (PACKAGE / "__init__.pyi").read_text()
        cls.tree = ast.parse(cls.text)

    def test_names(self):
        named = {n.name for n in self.tree.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(named, set(limberg.__all__))
        self.assertTrue((PACKAGE / "py.typed").exists())

    def test_members(self):
        for c in (n for n in self.tree.body if isinstance(n, ast.ClassDef)):
            cls = getattr(limberg, c.name)
            if issubclass(cls, Exception):
                continue
            told = {n.name: any(isinstance(d, ast.Name) and d.id == "property" for d in n.decorator_list)
                    for n in c.body if isinstance(n, ast.FunctionDef) and not n.name.startswith("_")}
            told.update({n.target.id: True for n in c.body if isinstance(n, ast.AnnAssign)})
            there = {k: isinstance(v, property) for k, v in vars(cls).items() if not k.startswith("_")}
            self.assertEqual(told, there, c.name)
            for k in ("__init__", "__len__", "__eq__", "__hash__"):
                self.assertEqual(any(isinstance(n, ast.FunctionDef) and n.name == k for n in c.body),
                                 f"{k}(self" in (getattr(vars(cls).get(k), "__doc__", "") or ""),
                                 f"{c.name}.{k}")

    def arguments(self, node):
        a = node.args
        return [x.arg for x in a.args + a.kwonlyargs if x.arg != "self"]

    def test_arguments(self):
        compared = 0
        for owner, node in [(limberg, n) for n in self.tree.body] + [
                (getattr(limberg, c.name), n) for c in self.tree.body if isinstance(c, ast.ClassDef) for n in c.body]:
            if not isinstance(node, ast.FunctionDef) or node.decorator_list or node.name in ("__eq__", "__hash__", "study"):
                continue
            doc = getattr(owner, node.name).__doc__ or ""
            first = re.match(rf"{node.name}\((.*)\) ->", doc.split("\n")[0])
            if not first:
                continue  # a function of an action: below
            named = [a for a in re.findall(r"(?:^|, )(\w+): ", first.group(1)) if a != "self"]
            self.assertEqual(self.arguments(node), named, node.name)
            compared += 1
        self.assertGreater(compared, 25)

    def test_actions(self):
        sys.path.insert(0, str(ROOT / "library/python"))
        import stubs
        self.assertEqual(self.text.split(stubs.MARK)[1], stubs.actions_part(),
                         "run library/python/stubs.py: the table of actions has changed")

    def test_everything_says_what_it_is(self):
        for name in limberg.__all__:
            thing = getattr(limberg, name)
            self.assertTrue(thing.__doc__, name)
            if not isinstance(thing, type) or issubclass(thing, Exception):
                continue
            for k, v in vars(thing).items():
                if k.startswith("_"):
                    continue
                doc = v.__doc__ or ""
                self.assertTrue(doc.split("\n")[-1].strip() or len(doc) > 20, f"{name}.{k}")
                for end, unit in (("_mm", "mm"), ("_kPa", "kPa"), ("_N", "N"), ("_mm2", "mm2"), ("_mm3", "mm3"), ("_uJ", "uJ")):
                    if k.endswith(end):
                        self.assertIn(unit, doc, f"{name}.{k}")
        for cls in (limberg.LatticeFields, limberg.Snapshot):
            for k in ("X_mm",):
                self.assertRegex(getattr(cls, k).__doc__, r"\((n|m)[,)]")


if __name__ == "__main__":
    unittest.main()
