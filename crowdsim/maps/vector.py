"""Maps from polygons and lines in files: GeoJSON and well-known text (WKT).

Coordinates are metres in the world frame (x right, y up). Both formats can also hold degrees:
project those first.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely
import shapely.ops
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]
Bounds = tuple[float, float, float, float]

SURFACES: Final = {surface.name.lower(): surface for surface in Surface}
WALL: Final = "wall"


@dataclass(frozen=True, kw_only=True)
class Layer:
    """One geometry of a file, and what it is called in messages."""

    name: str
    kind: str
    geometry: shapely.Geometry


def read_geojson(path: Path | str) -> Map:
    """Read a map from a GeoJSON feature collection.

    A `Polygon` or `MultiPolygon` feature needs the property `surface` (`pavement`, `road`,
    `building`, `grass`, `tree`, `crosswalk` or `water`); later features lie on top. A
    `LineString` or `MultiLineString` is a wall. The collection may carry `bbox` (the map's bounds;
    what the features cover if absent) and `background` (a surface; pavement if absent).

    Raises:
        FileNotFoundError: No such file.
        ValueError: Not such a collection, or a feature is not as above; the message names it.
    """
    text = Path(path).read_text(encoding="utf-8")
    try:
        collection = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: expected JSON, found {error}") from error
    if not isinstance(collection, dict) or collection.get("type") != "FeatureCollection":
        raise ValueError(f"{path}: expected an object of type FeatureCollection")
    features = collection.get("features")
    if not isinstance(features, list):
        raise ValueError(f"{path}: features: expected a list, found {type(features).__name__}")
    layers = [_feature(f"{path}: features[{i}]", item) for i, item in enumerate(features)]
    background = collection.get("background", "pavement")
    return _to_map(str(path), layers, collection.get("bbox"), background)


def write_geojson(path: Path | str, world_map: Map) -> None:
    """Write a map so that `read_geojson` gives the same geometry; a photograph is left out."""
    features = [
        _as_feature({"surface": surface.name.lower()}, shapely.Polygon(polygon))
        for surface, polygon in world_map.surfaces
    ]
    features += [_as_feature({}, shapely.LineString(wall)) for wall in world_map.walls]
    collection = {
        "type": "FeatureCollection",
        "bbox": list(world_map.bounds),
        "background": world_map.background.name.lower(),
        "features": features,
    }
    Path(path).write_text(json.dumps(collection, indent=1) + "\n", encoding="utf-8")


def read_wkt(path: Path | str) -> Map:
    """Read a map from lines of well-known text.

    Each line is a surface or `wall`, then a geometry: `building POLYGON ((0 0, 4 0, 4 3, 0 0))`,
    `wall LINESTRING (0 5, 9 5)`; later lines lie on top. `background building` and
    `bounds 0 0 20 10` are optional, as in GeoJSON. Empty lines and lines with `#` are skipped.

    Raises:
        FileNotFoundError: No such file.
        ValueError: A line is not as above; the message names it.
    """
    layers: list[Layer] = []
    options: dict[str, str] = {}
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), start=1):
        word, _, rest = line.strip().partition(" ")
        if word in ("background", "bounds"):
            options[word] = rest.strip()
        elif word and not word.startswith("#"):
            layers.append(_wkt_layer(f"{path}: line {number}", word, rest))
    bounds = options["bounds"].split() if "bounds" in options else None
    return _to_map(str(path), layers, bounds, options.get("background", "pavement"))


def _feature(name: str, feature: Any) -> Layer:
    if not isinstance(feature, dict) or feature.get("type") != "Feature":
        raise ValueError(f"{name}: expected an object of type Feature")
    try:
        with np.errstate(invalid="ignore"):  # NaN is refused later, by name
            geometry = shapely.from_geojson(json.dumps(feature.get("geometry")))
    except shapely.errors.GEOSException as error:
        raise ValueError(f"{name}: expected a GeoJSON geometry, found {error}") from error
    properties = feature.get("properties")
    surface = properties.get("surface") if isinstance(properties, dict) else None
    is_line = shapely.get_dimensions(geometry) == 1
    return _layer(name, WALL if surface is None and is_line else surface, geometry)


def _wkt_layer(name: str, kind: str, text: str) -> Layer:
    try:
        with np.errstate(invalid="ignore"):  # NaN is refused later, by name
            geometry = shapely.from_wkt(text)
    except shapely.errors.GEOSException as error:
        raise ValueError(f"{name}: expected a WKT geometry, found {error}") from error
    return _layer(name, kind, geometry)


def _layer(name: str, kind: Any, geometry: shapely.Geometry) -> Layer:
    """Check that a geometry is finite, simple, and of the kind that is said."""
    if kind != WALL and kind not in SURFACES:
        known = ", ".join([*SURFACES, WALL])
        raise ValueError(f"{name}: surface: expected one of {known}, found {kind!r}")
    if geometry is None or geometry.is_empty:
        raise ValueError(f"{name}: expected a geometry, found an empty one")
    expected = ("LineString", "MultiLineString") if kind == WALL else ("Polygon", "MultiPolygon")
    if geometry.geom_type not in expected:
        raise ValueError(
            f"{name}: {kind}: expected {' or '.join(expected)}, found {geometry.geom_type}"
        )
    if not np.isfinite(shapely.get_coordinates(geometry)).all():
        raise ValueError(f"{name}: expected finite coordinates, found NaN or infinity")
    if not geometry.is_valid:
        raise ValueError(
            f"{name}: expected a simple polygon, found {shapely.is_valid_reason(geometry)}"
        )
    return Layer(name=name, kind=kind, geometry=geometry)


def _to_map(source: str, layers: list[Layer], bounds: Any, background: Any) -> Map:
    if background not in SURFACES:
        known = ", ".join(SURFACES)
        raise ValueError(f"{source}: background: expected one of {known}, found {background!r}")
    surfaces = [
        (SURFACES[layer.kind], polygon)
        for layer in layers
        if layer.kind != WALL
        for polygon in _polygons(layer.geometry)
    ]
    walls = [wall for layer in layers if layer.kind == WALL for wall in _walls(layer.geometry)]
    return Map(
        bounds=_bounds(source, layers, bounds),
        surfaces=tuple(surfaces),
        walls=np.array(walls, dtype=np.float64).reshape(-1, 2, 2),
        background=SURFACES[background],
    )


def _bounds(source: str, layers: list[Layer], bounds: Any) -> Bounds:
    """The bounds that the file states, else the box around all that it holds."""
    if bounds is None:
        if not layers:
            raise ValueError(f"{source}: expected bounds or at least one geometry, found neither")
        bounds = shapely.total_bounds([layer.geometry for layer in layers])
    try:
        x_min, y_min, x_max, y_max = (float(value) for value in bounds)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{source}: bounds: expected four numbers x_min y_min x_max y_max, found {bounds}"
        ) from error
    return x_min, y_min, x_max, y_max


def _polygons(geometry: shapely.Geometry) -> Iterator[FloatArray]:
    """Outlines (P, 2) of the parts of a geometry; one with holes is cut into some without."""
    for part in shapely.get_parts(geometry):
        for piece in _without_holes(part):
            yield shapely.get_coordinates(piece)[:-1]


def _without_holes(polygon: shapely.Polygon) -> Iterable[shapely.Polygon]:
    if len(polygon.interiors) == 0:
        return [polygon]
    x = polygon.interiors[0].centroid.x
    _, y_min, _, y_max = polygon.bounds
    cut = shapely.LineString([(x, y_min - 1.0), (x, y_max + 1.0)])
    halves = shapely.get_parts(shapely.ops.split(polygon, cut))
    return [piece for half in halves for piece in _without_holes(half)]


def _walls(geometry: shapely.Geometry) -> Iterator[FloatArray]:
    """Segments (2, 2) of the lines of a geometry."""
    for part in shapely.get_parts(geometry):
        corners = shapely.get_coordinates(part)
        yield from np.stack([corners[:-1], corners[1:]], axis=1)


def _as_feature(properties: dict[str, str], geometry: shapely.Geometry) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": shapely.geometry.mapping(geometry),
    }
