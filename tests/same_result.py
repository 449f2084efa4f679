"""Results that should be the same to the last bit."""

import xarray as xr

RUN_DEPENDENT = {"/diagnostics": ("seconds", "effect_seconds")}


def different_variables(one: xr.DataTree, other: xr.DataTree) -> list[str]:
    """Paths of what is not the same bit for bit: variables, groups, attributes; without what depends on the run."""
    found = [f"/{group}" for group in set(one.children) ^ set(other.children)]
    for node in one.subtree:
        if node.path not in other.groups:
            continue
        a, b = node.to_dataset(inherit=False), other[node.path].to_dataset(inherit=False)
        for name in [str(name) for name in {**a.variables, **b.variables}]:
            if name in RUN_DEPENDENT.get(node.path, ()):
                continue
            same = name in a.variables and name in b.variables and a[name].dtype == b[name].dtype
            if not same or a[name].values.tobytes() != b[name].values.tobytes() or a[name].dims != b[name].dims:
                found.append(f"{node.path}/{name}")
    names = {*one.attrs, *other.attrs} - {"history"}
    return found + sorted(f"attribute {name}" for name in names if one.attrs.get(name) != other.attrs.get(name))
