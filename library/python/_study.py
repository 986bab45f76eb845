"""A family of operations."""
import itertools
from concurrent.futures import ThreadPoolExecutor


def study(operation, *, jobs=1, **values):
    """Calls operation(name=value, ...) for every combination of the values, and returns one dict a row.

    operation  a function that returns a dict of what it found (one World of its own in each call)
    jobs       so many at once, each on a thread (a World lets others run while it works); rows keep their order, and do
               not depend on jobs
    values     name=[v1, v2, ...]; the last one given varies fastest

    A row has the values and what operation returned. An act that was refused (Refused, InputError) gives a row with
    "refused": its reason, so that one impossible member does not end the study.

        rows = limberg.study(close, angle_deg=[60, 75, 90], tension=[1.05, 1.1])
    """
    from . import InputError, Refused

    names = list(values)
    members = [dict(zip(names, v)) for v in itertools.product(*(list(values[n]) for n in names))]

    def row(member):
        try:
            return {**member, **operation(**member)}
        except (Refused, InputError) as e:
            return {**member, "refused": str(e)}

    if jobs <= 1:
        return [row(m) for m in members]
    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(row, members))
