"""A recorded crowd and the picture that it walks on."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

FRAME_DT: Final = 0.4
"""Seconds between two rows of a recording, unless it says otherwise."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of the ground with its camera.

    Attributes:
        image: (H, W, 3) uint8 RGB.
        pixel_from_world: (3, 3) homography: world metres (x, y, 1) to pixels (u right, v down)
            after dividing by the third component. Pixel (0, 0) is the centre of the corner pixel.

    Raises:
        ValueError: Wrong shape or type, or a homography that cannot be inverted.
    """

    image: NDArray[np.uint8]
    pixel_from_world: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.image.ndim != 3 or self.image.shape[2] != 3 or self.image.dtype != np.uint8:
            raise ValueError(
                f"image must be (H, W, 3) uint8, got {self.image.shape} {self.image.dtype}"
            )
        matrix = self.pixel_from_world
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise ValueError(f"pixel_from_world must be a finite (3, 3) matrix, got {matrix}")
        if abs(np.linalg.det(matrix)) < 1e-12:
            raise ValueError(f"pixel_from_world must be invertible, got {matrix}")


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """Tracks of a crowd, sampled every `dt` seconds. World metres.

    Rows are *listed* frames: a source that skips the frames in which nobody is seen leaves rows
    whose `frames` are further apart than one step. `regular` puts the empty rows back.

    Attributes:
        name: Name of the recording; unique within a data set.
        positions: (T, N, 2) float64 [m], 0 where not `valid`.
        valid: (T, N) bool, True where the person was seen.
        ids: (N,) int64, unique.
        frames: (T,) int64, strictly increasing frame numbers of the source.
        dt: Time of one frame step [s].
        picture: The ground seen from above, if there is one.

    Raises:
        ValueError: Shapes, types or values contradict the above.
    """

    name: str
    positions: NDArray[np.float64]
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]
    frames: NDArray[np.int64]
    dt: float = FRAME_DT
    picture: Picture | None = None

    def __post_init__(self) -> None:
        self._check_shapes()
        if not (np.isfinite(self.dt) and self.dt > 0.0):
            raise ValueError(f"{self.name}: dt must be positive seconds, got {self.dt}")
        if not np.isfinite(self.positions).all():
            raise ValueError(f"{self.name}: positions must be finite")
        if np.any(self.positions[~self.valid] != 0.0):
            raise ValueError(f"{self.name}: positions must be 0 where not valid")
        if np.any(np.diff(self.frames) <= 0):
            raise ValueError(f"{self.name}: frames must increase strictly")
        if len(np.unique(self.ids)) != len(self.ids):
            raise ValueError(f"{self.name}: ids must be unique")

    def _check_shapes(self) -> None:
        steps, people = len(self.frames), len(self.ids)
        for field, dtype, shape in (
            ("positions", np.float64, (steps, people, 2)),
            ("valid", np.bool_, (steps, people)),
            ("ids", np.int64, (people,)),
            ("frames", np.int64, (steps,)),
        ):
            array = getattr(self, field)
            if array.shape != shape or array.dtype != dtype:
                raise ValueError(
                    f"{self.name}: {field} must be {shape} {np.dtype(dtype).name}, "
                    f"got {array.shape} {array.dtype}"
                )

    @classmethod
    def from_rows(
        cls,
        name: str,
        frame: NDArray[np.int64],
        identity: NDArray[np.int64],
        position: NDArray[np.float64],
        *,
        dt: float = FRAME_DT,
        picture: Picture | None = None,
        frames: NDArray[np.int64] | None = None,
    ) -> Self:
        """Build a recording from R rows (frame, person, (R, 2) position) in any order.

        Args:
            name: Name of the recording.
            frame: (R,) frame numbers.
            identity: (R,) who it is.
            position: (R, 2) where [m].
            dt: Time of one frame step [s].
            picture: The ground seen from above.
            frames: (T,) all listed frames, where nobody may be seen in some; None lists those
                of the rows.

        Raises:
            ValueError: There is no frame, one person has two positions in one frame, or a frame
                is not listed.
        """
        frames = np.unique(frame) if frames is None else frames
        if len(frames) == 0:
            raise ValueError(f"{name}: a recording needs at least one row, got none")
        row = np.searchsorted(frames, frame)
        if np.any(frames[np.minimum(row, len(frames) - 1)] != frame):
            raise ValueError(f"{name}: expected rows in listed frames, found others")
        ids, column = np.unique(identity, return_inverse=True)
        valid = np.zeros((len(frames), len(ids)), dtype=np.bool_)
        valid[row, column] = True
        if valid.sum() != len(frame):
            raise ValueError(f"{name}: {len(frame) - valid.sum()} rows repeat a person and frame")
        positions = np.zeros((*valid.shape, 2))
        positions[row, column] = position
        return cls(
            name=name,
            positions=positions,
            valid=valid,
            ids=ids.astype(np.int64),
            frames=frames.astype(np.int64),
            dt=dt,
            picture=picture,
        )

    def to_rows(
        self, *, by_frame: bool = False
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """(R,) frames, (R,) ids and (R, 2) positions of all that was seen.

        Args:
            by_frame: Sort by frame and then by person, instead of the other way round.
        """
        if by_frame:
            row, person = np.nonzero(self.valid)
        else:
            person, row = np.nonzero(self.valid.T)
        return self.frames[row], self.ids[person], self.positions[row, person]

    @property
    def map_image(self) -> NDArray[np.uint8] | None:
        """(H, W, 3) uint8 RGB picture of the ground, or None."""
        return None if self.picture is None else self.picture.image

    @property
    def pixel_from_world(self) -> NDArray[np.float64] | None:
        """(3, 3) homography into `map_image`, or None."""
        return None if self.picture is None else self.picture.pixel_from_world

    @property
    def frame_step(self) -> int:
        """Frame numbers per `dt`: the smallest distance between two rows."""
        return int(np.diff(self.frames).min()) if len(self.frames) > 1 else 1

    @property
    def mean_speed(self) -> float:
        """Mean speed [m/s] over all pairs of neighboring frames of one person; NaN without any."""
        frames, lengths = self.steps()
        single = lengths[frames == self.frame_step]
        return float(single.mean()) / self.dt if len(single) > 0 else float("nan")

    def steps(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(P,) frames and (P,) distances [m] from each position of a person to the next one."""
        frame, identity, position = self.to_rows()
        same = np.diff(identity) == 0
        step = np.diff(position, axis=0)[same]
        return np.diff(frame)[same], np.asarray(np.hypot(step[:, 0], step[:, 1]))

    def windows(
        self, history_steps: int = 8, forecast_steps: int = 12, stride: int = 1
    ) -> Iterator[int]:
        """First rows of all stretches of history + forecast consecutive *listed* rows.

        Raises:
            ValueError: A count below 1.
        """
        if min(history_steps, forecast_steps, stride) < 1:
            raise ValueError(
                "history_steps, forecast_steps and stride must be at least 1, "
                f"got {history_steps}, {forecast_steps}, {stride}"
            )
        yield from range(0, len(self.frames) - history_steps - forecast_steps + 1, stride)

    def regular(self) -> Self:
        """The same recording with an empty row for every frame that the source did not list.

        Rows are then `dt` apart throughout, and `frames` counts on from the first one; a gap that
        is no whole number of steps (a cut between two videos) is rounded to one.
        """
        step = self.frame_step
        gaps = np.rint(np.diff(self.frames) / step).astype(np.int64)
        row = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(gaps)])
        count = int(row[-1]) + 1
        positions = np.zeros((count, len(self.ids), 2))
        valid = np.zeros((count, len(self.ids)), dtype=np.bool_)
        positions[row], valid[row] = self.positions, self.valid
        frames = self.frames[0] + step * np.arange(count, dtype=np.int64)
        return replace(self, positions=positions, valid=valid, frames=frames)
