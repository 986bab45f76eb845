"""Limberg: open reconstructive surgery on skin, fat and bone.

    import limberg

    world = limberg.World(limberg.open_scene("rhomboid"))
    world.apply(limberg.incise(path=[[-12, 0], [12, 0]], depth_mm=4))
    world.settle()
    print(world.measures()["wound_gape_mm"])

Units are mm, s, kg; hence kPa, uJ; names say other ones (force_N). A place on the skin is a point of its chart in mm, as
scripts have it. Arrays are NumPy's; those of a snapshot look into it, without a copy, and are read-only.

For each action of a script there is a function of its name that makes the Command (suture_row for "suture_row"); its
documentation has units, limits and defaults, from the same table as `limberg actions`.
"""
from . import _limberg
from ._limberg import (  # noqa: F401
    Command, Hook, InputError, LatticeFields, Material, Operation, Recording, Refused, Scene, Script, SkinStates,
    Snapshot, StepReport, Stitch, World, __version__, actions, laws, load_script, open_scene, parse_scene, parse_script,
    procedure, procedures, program_name, read_recording, shipped_file, write_recording)
from ._study import study  # noqa: F401

Scene.__module__ = World.__module__ = Command.__module__ = __name__


def _action_function(name, forms):
    """The function that makes commands of that action."""
    def make(**fields):
        return Command({"action": name, **fields})

    lines = []
    for form in forms:
        if form["form"]:
            lines += ["", name + form["form"] + ":"]
        lines += [form["help"], ""]
        for f in form["fields"]:
            rest = ", ".join(w for w in (f["kind"], (f["limits"] + " " + f["unit"]).strip(),
                                         "" if f["required"] else "left out: " + (f["default"] or "none")) if w)
            lines.append(f"    {f['key']}: {f['help']} ({rest})")
        lines += ["", "    " + form["example"]]
    make.__name__ = make.__qualname__ = name
    make.__module__ = __name__
    make.__doc__ = "\n".join(lines).strip()
    return make


def _action_functions():
    forms = {}
    for a in actions():
        forms.setdefault(a["name"], []).append(a)
    return {name: _action_function(name, of_name) for name, of_name in forms.items()}


_functions = _action_functions()
globals().update(_functions)
__all__ = sorted([
    "Command", "Hook", "InputError", "LatticeFields", "Material", "Operation", "Recording", "Refused", "Scene", "Script",
    "SkinStates", "Snapshot", "StepReport", "Stitch", "World", "actions", "laws", "load_script", "open_scene",
    "parse_scene", "parse_script", "procedure", "procedures", "program_name", "read_recording", "shipped_file", "study", "write_recording",
    *_functions])
