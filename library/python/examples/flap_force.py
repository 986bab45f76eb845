"""The force that closes a Limberg flap against its angle to the tension lines.

    PYTHONPATH=build-python/python /usr/bin/python3 library/python/examples/flap_force.py
    PYTHONPATH=build-python/python /usr/bin/python3 library/python/examples/flap_force.py --angles 0,90 --cell-mm 6

The flap is turned about the middle of its defect; the skin of the scene is pulled harder along the lines (+x) than across.
"""
import argparse

import limberg


def close(turn_deg, cell_mm):
    """The shipped procedure, turned, carried out to equilibrium: what its stitches pull with."""
    scene = limberg.open_scene("rhomboid")
    scene.cell_mm = cell_mm
    world = limberg.World(scene)
    world.operate(limberg.procedure("rhomboid", scene, turn_deg=turn_deg))
    m = world.measures()
    return {"closure_N": m["closure_force_N"], "largest_N": m["suture_force_max_N"], "gape_mm": m["wound_gape_mm"]}


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--angles", default="0,30,60,90,120,150", help="degrees, separated by commas")
    p.add_argument("--cell-mm", type=float, default=5, help="size of the lattice's cells")
    o = p.parse_args()
    rows = limberg.study(lambda turn_deg: close(turn_deg, o.cell_mm), turn_deg=[float(a) for a in o.angles.split(",")])
    print("turned   all stitches   largest   gape")
    for r in rows:
        if "refused" in r:
            print(f"{r['turn_deg']:5.0f} °   refused: {r['refused']}")
        else:
            print(f"{r['turn_deg']:5.0f} °   {r['closure_N']:9.3f} N {r['largest_N']:9.3f} N {r['gape_mm']:6.2f} mm")
    return rows


if __name__ == "__main__":
    main()
