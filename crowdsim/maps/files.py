"""Maps from files, by the ending of their name."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from crowdsim.map import Map
from crowdsim.maps.occupancy_grid import read_map_server
from crowdsim.maps.vector import read_geojson, read_wkt

READERS: Final[dict[str, Callable[[Path], Map]]] = {
    ".geojson": read_geojson,
    ".json": read_geojson,
    ".wkt": read_wkt,
    ".yaml": read_map_server,
    ".yml": read_map_server,
}


def read_map(path: Path | str) -> Map:
    """Read a map from GeoJSON, WKT, or a ROS map_server pair (its YAML file).

    Each call gives a new map object; keep it, so that what physics derives from it is computed
    once.

    Raises:
        FileNotFoundError: No such file.
        ValueError: No reader for this ending, or the content is not as the reader says.
    """
    path = Path(path)
    if path.suffix not in READERS:
        raise ValueError(f"{path}: expected a name that ends in one of {', '.join(READERS)}")
    return READERS[path.suffix](path)
