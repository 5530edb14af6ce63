"""Maps from files and from generators; every one is the same `crowdsim.map.Map`."""

from crowdsim.maps.places import PLACES, make_place
from crowdsim.maps.plan import Place

__all__ = ["PLACES", "Place", "make_place"]
