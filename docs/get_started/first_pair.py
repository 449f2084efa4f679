"""Numbers of the worn pair."""

import semiwear as sw

tree = sw.simulate(sw.load_scene("my_pair.toml"))
history, life = tree["history"].to_dataset(), tree["life"].to_dataset()
for step, when in ((0, "new"), (-1, "worn")):
    now = history.isel(wear_step=step)
    print(f"{when}, after {float(now.meshes):.3g} meshes of a gear tooth")
    print(f"  greatest wear of the pinion   {float(now.wear_depth_max.sel(body='pinion')):8.2f} um")
    print(f"  pressure at the pitch line    {float(now.contact_pressure_pitch):8.0f} MPa")
    print(f"  root stress of the pinion     {float(now.root_stress_max.sel(body='pinion')):8.1f} MPa")
    print(f"  transmission error, amplitude {float(now.transmission_error_amplitude):8.1f} arcsec")
print(f"life until {float(life.depth_limit):g} um: {float(life.hours_to_limit):.0f} h")
