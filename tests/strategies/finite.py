"""What a result may hold: numbers, or nothing with a reason."""

import numpy as np
import xarray as xr

BALANCE = 1e-9  # of the torque
COMPLEMENTARITY = {"line": 1e-9, "patch": 1e-6}  # of the approach: rounding; the tolerance that patches are solved to


def assert_finite_or_explained(name: object, values: xr.DataArray) -> None:
    """No infinite number, and none that is missing without a reason."""
    if values.dtype.kind != "f":
        return
    assert not np.isinf(values.values).any(), name
    assert not np.isnan(values.values).any() or values.attrs.get("missing_because"), name


def equations_hold(tree: xr.DataTree) -> None:
    """Finite or explained, not negative, balanced, complementary: loaded contact or a run, of either fidelity."""
    for group in ("engagement", "mesh_cycle", "history", "flank"):
        if group in tree.children:
            for name, values in tree[group].data_vars.items():
                assert_finite_or_explained(name, values)
    for name in ("line_load", "load_share", "contact_pressure_max", "contact_pressure_max_edge", "root_stress"):
        if name in tree["engagement"]:
            assert float(tree["engagement"][name].min()) >= 0.0, name
    diagnostics = tree["diagnostics"]
    assert float(diagnostics.load_balance_residual.max()) < BALANCE
    assert float(diagnostics.complementarity_residual.max()) < COMPLEMENTARITY[tree.attrs["fidelity"]]
    share = tree["engagement"].load_share.values
    by_position = share.reshape(share.shape[0], -1, tree["mesh_cycle"].sizes["mesh_position"])
    np.testing.assert_allclose(by_position.sum(axis=1), 1.0, atol=1e-9)
