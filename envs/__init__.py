"""Crowd navigation environments for Gymnasium: forecasts of people inside the observation.

Importing this package registers `crowdnav/CrowdNav-v0` (flat Dict observation) and
`crowdnav/CrowdNavFlat-v0` (the same, every key flattened to one dimension), each with a natively
batched vector environment. There is another `envs` on the package index; this one belongs to
the distribution `crowdnav-testbed`.
"""

import gymnasium


def register_environments() -> None:
    """Registers the environments with Gymnasium; calling it again changes nothing."""
    for name in ("CrowdNav", "CrowdNavFlat"):
        env_id = f"crowdnav/{name}-v0"
        if env_id not in gymnasium.registry:
            gymnasium.register(
                env_id,
                entry_point=f"envs.crowd_nav:{name}",
                vector_entry_point=f"envs.vector:{name}Vector",
            )


register_environments()
