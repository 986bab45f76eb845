"""The part of __init__.pyi that follows from the table of actions.

    PYTHONPATH=build-python/python /usr/bin/python3 library/python/stubs.py            # writes it anew, after the table has changed
"""
import keyword
import pathlib

import limberg

MARK = "# Actions of a script, from here on made by stubs.py.\n"


def type_of(field):
    """Of a field's kind, in words, the type."""
    kind = field["kind"]
    if kind.startswith(("points", "places")):
        return "Sequence[Point]"
    if kind.startswith(("point", "place")):
        return "Point"
    if kind.startswith("whole number"):
        return "int"
    if kind.startswith("number"):
        return "float"
    if kind.startswith("true or false"):
        return "bool"
    if kind.startswith("text"):
        return "str"
    return "Any"


def actions_part():
    """Text after MARK: one function an action; fields that only one of its forms needs may be left out."""
    forms = {}
    for a in limberg.actions():
        forms.setdefault(a["name"], []).append(a)
    lines = []
    for name in sorted(forms):
        fields = {}
        for form in forms[name]:
            for f in form["fields"]:
                fields.setdefault(f["key"], f)
        always = [k for k in fields if all(any(f["key"] == k and f["required"] for f in form["fields"]) for form in forms[name])]
        args = [f"{k}: {type_of(fields[k])}" for k in always]
        args += [f"{k}: {type_of(f)} = ..." for k, f in fields.items() if k not in always]
        if any(keyword.iskeyword(k) for k in fields):  # suture_between(**{"from": ...})
            args = [a for a in args if not keyword.iskeyword(a.split(":")[0])]
            lines.append(f"def {name}({'*, ' if args else ''}{', '.join(args + ['**more: Any'])}) -> Command: ...")
            continue
        lines.append(f"def {name}({'*, ' if args else ''}{', '.join(args)}) -> Command: ...")
    return "\n".join(lines) + "\n"


def main():
    file = pathlib.Path(__file__).parent / "__init__.pyi"
    text = file.read_text()
    file.write_text(text[:text.index(MARK) + len(MARK)] + actions_part())


if __name__ == "__main__":
    main()
