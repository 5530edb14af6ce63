"""Maps from files and from generators; every one is the same `crowdsim.map.Map`."""

from crowdsim.maps.places import PLACES, Place, make_place

__all__ = ["PLACES", "Place", "make_place"]
