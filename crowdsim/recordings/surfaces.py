"""What the ground is made of, and what that means for walking and for looking."""

import enum


class Surface(enum.IntEnum):
    """A kind of ground; 1 to 5 are the classes of the Stanford Drone Dataset's masks, 0 is unknown.

    One palette for simulated and real maps, so that a network that learned on one can read the
    other.
    """

    PAVEMENT = 1
    ROAD = 2
    BUILDING = 3
    GRASS = 4
    TREE = 5
    CROSSWALK = 6
    WATER = 7

    @property
    def walkable(self) -> bool:
        """Whether a pedestrian or a robot can stand here."""
        return self not in (Surface.BUILDING, Surface.TREE, Surface.WATER)

    @property
    def see_through(self) -> bool:
        """Whether one can look across it."""
        return self not in (Surface.BUILDING, Surface.TREE)

    @property
    def color_rgb(self) -> tuple[int, int, int]:
        """Color in top-down pictures, 8 bits per channel."""
        return _COLORS_RGB[self]


_COLORS_RGB = {
    Surface.PAVEMENT: (214, 208, 196),
    Surface.ROAD: (112, 114, 120),
    Surface.BUILDING: (158, 102, 84),
    Surface.GRASS: (142, 182, 110),
    Surface.TREE: (66, 120, 72),
    Surface.CROSSWALK: (240, 238, 230),
    Surface.WATER: (104, 160, 206),
}
