"""What `limberg export` writes, read by VTK: an independent reader that must find the session's own numbers.

    /usr/bin/python3 tests/app/export/read_vtk.py build/limberg        (Debian: python3-vtk9 python3-numpy)

Without VTK it says so and is skipped.
"""
import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkMassProperties
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkSTLReader
    from vtkmodules.vtkIOPLY import vtkPLYReader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader
except ImportError as e:
    print("exports_read_by_vtk: Skipped")
    print(f"needs VTK in Python ({e}); Debian: python3-vtk9 python3-numpy")
    sys.exit(77)

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else "build/limberg"

SCENE = """name = "small"
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
cell_mm = 2.5
"""
SCRIPT = """{"limberg_script":1,"scene":"small"}
{"action":"excise","outline":[[-6,-4],[6,-4],[6,4],[-6,4]],"depth_mm":3}
{"action":"stage","name":"excised"}
{"action":"suture","a":[0,5],"b":[0,-5]}
{"action":"stage","name":"closed"}
"""


def read(reader, file):
    r = reader()
    r.SetFileName(file)
    r.Update()
    out = r.GetOutput()
    assert r.GetErrorCode() == 0, file
    return out


def points(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def cells(data, name):
    return vtk_to_numpy(data.GetCellData().GetArray(name))


def word(data, name):
    return data.GetFieldData().GetAbstractArray(name).GetValue(0)


class ReadByVtk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tmp = tempfile.TemporaryDirectory()
        cls.out = cls.tmp.name + "/x"
        for name, text in (("small.toml", SCENE), ("s.jsonl", SCRIPT)):
            with open(f"{cls.tmp.name}/{name}", "w") as f:
                f.write(text)
        call = [PROGRAM, "operate", "small.toml", "s.jsonl", "--out", "op"]
        done = subprocess.run(call, cwd=cls.tmp.name, capture_output=True, text=True)
        assert done.returncode in (0, 3), done.stderr
        done = subprocess.run([PROGRAM, "export", "op", "--at", "all", "--out", "x"], cwd=cls.tmp.name,
                              capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        cls.result = json.load(open(cls.out + "/result.json"))
        cls.operated = json.load(open(cls.tmp.name + "/op/result.json"))
        cls.end = cls.out + "/03-end/"

    @classmethod
    def tearDownClass(cls):
        cls.tmp.cleanup()

    def test_lattice_is_that_of_the_session(self):
        for m in self.result["moments"]:
            grid = read(vtkXMLUnstructuredGridReader, f"{m['folder']}/lattice.vtu" if os.path.isabs(m["folder"]) else
                        f"{self.tmp.name}/{m['folder']}/lattice.vtu")
            self.assertEqual(word(grid, "state_hash"), m["state_hash"])
            self.assertEqual(word(grid, "moment"), m["name"])
            self.assertEqual(word(grid, "layers"), "0 skin, 1 fat")
            u = vtk_to_numpy(grid.GetPointData().GetArray("displacement_mm"))
            self.assertAlmostEqual(float(np.linalg.norm(u, axis=1).max()), m["displacement_max_mm"], delta=1e-5)
        grid = read(vtkXMLUnstructuredGridReader, self.end + "lattice.vtu")
        self.assertEqual(grid.GetNumberOfCells(), self.operated["lattice"]["cell_copies"])
        self.assertEqual(grid.GetNumberOfPoints(), self.operated["lattice"]["nodes"])
        self.assertTrue(all(grid.GetCellType(i) == 12 for i in range(grid.GetNumberOfCells())))

    def test_hexahedra_have_their_volume(self):
        """VTK's own volumes, so the order of the corners is right: at rest the shares of all add up to what is left."""
        grid = read(vtkXMLUnstructuredGridReader, self.end + "lattice.vtu")
        size = vtkCellSizeFilter()
        size.SetInputData(grid)
        size.Update()
        now = cells(size.GetOutput(), "Volume")
        self.assertGreater(now.min(), 0)
        volume = float((now * cells(grid, "fraction")).sum())
        self.assertAlmostEqual(volume / self.operated["metrics"]["volume_mm3"], 1, delta=0.03)  # at present, not at rest

    def test_stress_and_pressure_belong_together(self):
        grid = read(vtkXMLUnstructuredGridReader, self.end + "lattice.vtu")
        stress, pressure = cells(grid, "stress_kPa"), cells(grid, "pressure_kPa")
        self.assertEqual(stress.shape, (grid.GetNumberOfCells(), 6))
        self.assertEqual([grid.GetCellData().GetArray("stress_kPa").GetComponentName(i) for i in range(6)],
                         ["XX", "YY", "ZZ", "XY", "YZ", "XZ"])
        np.testing.assert_allclose(pressure, -stress[:, :3].sum(axis=1) / 3, atol=1e-3)
        self.assertEqual(set(np.unique(cells(grid, "material"))), {0, 1})
        self.assertGreater(float(cells(grid, "stretch").max()), 1.08)
        # Skin is pulled, fat is not: by material, as the scene says.
        pulled = np.maximum(stress[:, 0], stress[:, 1])
        self.assertGreater(np.median(pulled[cells(grid, "material") == 0]),
                           3 * np.median(pulled[cells(grid, "material") == 1]))

    def test_skin_has_the_figures_of_the_session(self):
        skin = read(vtkXMLPolyDataReader, self.end + "skin.vtp")
        area, stretch, stress = (cells(skin, n) for n in ("rest_area_mm2", "stretch", "stress_kPa"))
        kind = cells(skin, "kind")
        self.assertEqual(set(np.unique(kind)), {0, 1, 3})  # a block: skin, fixed sides, the walls of the cut
        # The percentile of `limberg measures`, by rest area, computed anew.
        order = np.argsort(stretch[area > 0])
        weight = np.cumsum(area[area > 0][order])
        p99 = stretch[area > 0][order][np.searchsorted(weight, 0.99 * weight[-1])]
        self.assertAlmostEqual(float(p99), self.operated["metrics"]["stretch_p99"], delta=2e-3)
        self.assertTrue(np.isfinite(stress).all())
        m = vtkMassProperties()
        m.SetInputData(skin)
        m.Update()
        x, tri = points(skin), vtk_to_numpy(skin.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        a, b, c = (x[tri[:, k]].astype(float) for k in range(3))
        self.assertAlmostEqual(m.GetVolume(), float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6), delta=1)

    def test_collections_name_every_moment(self):
        for name, inner in (("lattice.pvd", "lattice.vtu"), ("skin.pvd", "skin.vtp")):
            sets = ET.parse(f"{self.out}/{name}").getroot().findall("./Collection/DataSet")
            self.assertEqual([s.get("file").split("/")[1] for s in sets], [inner] * 3)
            times = [float(s.get("timestep")) for s in sets]
            self.assertEqual(times, [m["t_s"] for m in self.result["moments"]])
            self.assertEqual(times, sorted(times))
            for s in sets:
                self.assertTrue(os.path.exists(f"{self.out}/{s.get('file')}"))

    def test_surfaces_agree(self):
        skin = read(vtkXMLPolyDataReader, self.end + "skin.vtp")
        stl, ply = read(vtkSTLReader, self.end + "skin.stl"), read(vtkPLYReader, self.end + "skin.ply")
        for other in (stl, ply):
            self.assertEqual(other.GetNumberOfCells(), skin.GetNumberOfCells())
            np.testing.assert_allclose(other.GetBounds(), skin.GetBounds(), atol=1e-4)

    def test_gltf_is_the_same_surface(self):
        r = vtkGLTFReader()
        r.SetFileName(self.out + "/operation.glb")
        r.Update()
        # The last surface: its vertices as of its first frame, in metres and y up under the root node.
        glb = open(self.out + "/operation.glb", "rb").read()
        j = json.loads(glb[20:20 + int.from_bytes(glb[12:16], "little")])
        surfaces = [m for m in j["meshes"] if m["name"] == "surface"]
        skin = read(vtkXMLPolyDataReader, self.end + "skin.vtp")
        last = surfaces[-1]["primitives"]
        self.assertEqual(sum(j["accessors"][p["indices"]]["count"] for p in last), 3 * skin.GetNumberOfCells())
        self.assertEqual(j["accessors"][last[0]["attributes"]["POSITION"]]["count"], skin.GetNumberOfPoints())
        self.assertGreater(r.GetOutput().GetNumberOfBlocks(), 0)
        self.assertEqual(r.GetNumberOfAnimations() if hasattr(r, "GetNumberOfAnimations") else 1, 1)

    def test_tables(self):
        rows = list(csv.DictReader(open(self.out + "/measures.csv")))
        self.assertEqual([r["moment"] for r in rows], [m["name"] for m in self.result["moments"]])
        for name in ("volume_mm3", "closure_force_N", "stretch_p99", "wound_gape_mm"):
            self.assertAlmostEqual(float(rows[-1][name]), self.operated["metrics"][name],
                                   delta=1e-5 * abs(self.operated["metrics"][name]) + 1e-9)


if __name__ == "__main__":
    unittest.main(warnings="ignore")
