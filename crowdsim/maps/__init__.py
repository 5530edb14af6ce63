"""Maps from files and from generators; every one is the same `crowdsim.map.Map`."""

from crowdsim.maps.files import read_map
from crowdsim.maps.occupancy_grid import read_map_server
from crowdsim.maps.photograph import classified_map, eth_ucy_map, sdd_map, walkable_map
from crowdsim.maps.places import PLACES, make_place
from crowdsim.maps.plan import Place
from crowdsim.maps.vector import read_geojson, read_wkt, write_geojson

__all__ = [
    "PLACES",
    "Place",
    "classified_map",
    "eth_ucy_map",
    "make_place",
    "read_geojson",
    "read_map",
    "read_map_server",
    "read_wkt",
    "sdd_map",
    "walkable_map",
    "write_geojson",
]
