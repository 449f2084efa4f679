"""How many examples a property is tried on."""

from typing import Any

from hypothesis import HealthCheck, Phase, settings


def share_of_examples(divisor: int, least: int) -> Any:
    """A share of the profile's examples, for properties that take seconds: shrinking would be as slow."""
    return settings(
        max_examples=max(settings.default.max_examples // divisor, least),
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
        phases=[Phase.explicit, Phase.reuse, Phase.generate],
    )
