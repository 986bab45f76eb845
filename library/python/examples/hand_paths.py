"""The paths of the hand in a recording: how far it went with each tool, and how far with the tool engaged.

    PYTHONPATH=build-python/python /usr/bin/python3 library/python/examples/hand_paths.py recordings/rhomboid.lcm --csv out/hand.csv
"""
import argparse

import numpy as np

import limberg

SELECT_TOOL = 1  # a control's kind (devices/sample.h)


def paths(recording):
    """tool -> (path in mm, of it engaged in mm, time in s)."""
    s = recording.stylus()
    chosen = [(c["t_s"], c["tool"]) for c in recording.controls if c["kind"] == SELECT_TOOL]
    t, step = s["t_s"], np.linalg.norm(np.diff(s["tip_mm"], axis=0), axis=1)
    engaged = (s["buttons"][1:] & 1).astype(bool)
    which = np.searchsorted([c[0] for c in chosen], t[1:], side="right")  # 0: before the first choice
    out = {}
    for k, tool in enumerate(["none"] + [c[1] for c in chosen]):
        now = which == k
        if now.any():
            was = out.get(tool, (0.0, 0.0, 0.0))
            out[tool] = (was[0] + step[now].sum(), was[1] + step[now & engaged].sum(), was[2] + np.diff(t)[now].sum())
    return out


def main(arguments=None):
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("recording", help="a recording (.lcm)")
    p.add_argument("--csv", help="every reading into this file")
    o = p.parse_args(arguments)
    recording = limberg.read_recording(o.recording)
    found = paths(recording)
    print(f"{recording.session['scene_name']}, recorded by {recording.session['program']}")
    for tool, (path, engaged, seconds) in found.items():
        print(f"{tool:12s} {path:8.0f} mm, engaged {engaged:7.0f} mm, {seconds:6.1f} s")
    print(f"{'all':12s} {sum(v[0] for v in found.values()):8.0f} mm")
    if o.csv:
        s = recording.stylus()
        np.savetxt(o.csv, np.column_stack([s["t_s"], s["tip_mm"], s["buttons"]]), delimiter=",",
                   header="t_s,x_mm,y_mm,z_mm,buttons", comments="")
    return found


if __name__ == "__main__":
    main()
