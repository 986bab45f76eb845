"""NumPy's numbers and arrays as Python's own, for JSON."""


def plain(value):
    """The same value of dicts, lists, numbers and texts only."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if hasattr(value, "tolist"):  # of NumPy
        return value.tolist()
    return value
