"""A light crowd simulator: solid bodies, social forces, maps, recordings.

Usable alone: it knows nothing of learning libraries. Import from the submodules
(`crowdsim.world`, `crowdsim.scenarios`, `crowdsim.recordings`, ...); this package itself imports
nothing, so that reading a recording does not load the physics.
"""
