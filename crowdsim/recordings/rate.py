"""The one check of time steps: what a source's frame numbers and speeds say about its rate."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

import numpy as np

from crowdsim.recordings.recording import FRAME_DT, Recording

VIDEO_FPS: Final = (1.0 / FRAME_DT, 15.0, 25.0, 30.0)
"""Frame rates that explain frame numbers: rows that are counted, ETH, UCY, SDD."""
SPEED_RANGE: Final = (0.1, 3.0)
"""Mean speeds of a crowd [m/s] that a time step can be believed with."""
WALKING_SPEED: Final = 1.8
"""A crowd whose mean speed [m/s] is higher runs, or its time step is too short."""
SINGLE_SHARE: Final = 0.9
"""Least share of positions that follow the person's last one by one frame step."""
TOLERANCE: Final = 0.03
"""Relative difference of two time steps that count as the same: 30 fps video has 29.97."""


def explain_dt(
    source: str, frame_step: int, dt: float | None, fps: Sequence[float] = VIDEO_FPS
) -> float:
    """Find the time of one frame step [s].

    Args:
        source: What is read, for the message.
        frame_step: Distance of two rows in frame numbers.
        dt: The caller's word, which wins; None asks for 0.4 s, the step of all public crowds.
        fps: Frame rates that the source may have been filmed at.

    Raises:
        ValueError: No word was given, and no frame rate makes the step 0.4 s.
    """
    if dt is not None:
        return dt
    implied = [frame_step / rate for rate in fps]
    if any(abs(step - FRAME_DT) <= TOLERANCE * FRAME_DT for step in implied):
        return FRAME_DT
    found = " or ".join(
        f"{step:.3g} s (at {rate:g} fps)" for step, rate in zip(implied, fps, strict=True)
    )
    raise ValueError(
        f"{source}: frames {frame_step} apart imply a time step of {found}, "
        f"expected {FRAME_DT} s; state dt if it is another one"
    )


class Tally:
    """Counts of one recording, which may come in stretches: how many, how fast, where.

    Attributes:
        name: The recording's name.
        dt: Time of one frame step [s].
        frame_step: Distance of two rows in frame numbers.
        rows: Listed frames.
        positions: Positions of all people together.
        ids: Everybody's; all else is of constant size.
        bounds: x_min, y_min, x_max, y_max of the positions [m].
    """

    def __init__(self, first: Recording) -> None:
        self.name, self.dt, self.frame_step = first.name, first.dt, first.frame_step
        self.rows, self.positions = 0, 0
        self.ids: set[int] = set()
        self.bounds = np.array([np.inf, np.inf, -np.inf, -np.inf])
        self._steps, self._single_steps, self._path = 0, 0, 0.0

    def add(self, stretch: Recording) -> None:
        """Count one more stretch; speeds over the border between two are left out."""
        self.rows += len(stretch.frames)
        self.positions += int(stretch.valid.sum())
        self.ids.update(stretch.ids.tolist())
        seen = stretch.positions[stretch.valid]
        if len(seen) > 0:
            self.bounds[:2] = np.minimum(self.bounds[:2], seen.min(axis=0))
            self.bounds[2:] = np.maximum(self.bounds[2:], seen.max(axis=0))
        frames, lengths = stretch.steps()
        single = lengths[frames == self.frame_step]
        self._steps += len(frames)
        self._single_steps += len(single)
        self._path += float(single.sum())

    @property
    def mean_speed(self) -> float:
        """Mean speed [m/s] over all single frame steps of all people; NaN without any."""
        if self._single_steps == 0:
            return float("nan")
        return self._path / self._single_steps / self.dt

    def check(self, source: str) -> None:
        """Refuse a `dt` that frames or speeds contradict; `check_rate` says when.

        Args:
            source: What is read, for the message.

        Raises:
            ValueError: They contradict it.
        """
        share = self._single_steps / self._steps if self._steps > 0 else 1.0
        if share < SINGLE_SHARE:
            raise ValueError(
                f"{source}: expected positions of a person {self.frame_step} frames apart, "
                f"found it for only {share:.0%} of them"
            )
        if self._single_steps == 0:
            raise ValueError(
                f"{source}: expected two frames with the same person, which tell the rate, "
                "found nobody seen twice"
            )
        if not SPEED_RANGE[0] <= self.mean_speed <= SPEED_RANGE[1]:
            raise ValueError(
                f"{source}: {self.frame_step} frames as {self.dt:g} s imply a mean speed of "
                f"{self.mean_speed:.2f} m/s, expected {SPEED_RANGE[0]}-{SPEED_RANGE[1]} m/s"
            )

    def __str__(self) -> str:
        """One line for people to read."""
        x_min, y_min, x_max, y_max = self.bounds
        doubt = " (faster than people walk)" if self.mean_speed > WALKING_SPEED else ""
        return (
            f"{self.name}: {len(self.ids)} people, {self.positions} positions in {self.rows} rows "
            f"of {self.dt:g} s ({self.frame_step} frames), mean speed {self.mean_speed:.2f} m/s"
            f"{doubt}, x {x_min:.1f} to {x_max:.1f} m, y {y_min:.1f} to {y_max:.1f} m"
        )


def tally(recording: Recording) -> Tally:
    """Count a whole recording."""
    counts = Tally(recording)
    counts.add(recording)
    return counts


def check_rate(recording: Recording, *, source: str | None = None) -> None:
    """Refuse a recording whose `dt` its own frames or speeds contradict.

    Args:
        recording: What to check.
        source: What it was read from, for the message; None takes its name.

    Raises:
        ValueError: Fewer than 9 in 10 positions follow the person's last one by one frame step, or
            the mean speed over one step is outside 0.1-3 m/s, which no crowd walks.
    """
    tally(recording).check(recording.name if source is None else source)


def tallied(stretches: Iterable[Recording], tell: Callable[[Tally], None]) -> Iterator[Recording]:
    """Pass stretches on, and tell the counts of every recording when it has passed."""
    for _, parts in groupby(stretches, key=lambda part: part.name):
        counts = None
        for part in parts:
            counts = Tally(part) if counts is None else counts
            counts.add(part)
            yield part
        if counts is not None:
            tell(counts)


def rated(
    stretches: Iterable[Recording],
    name: str,
    *,
    dt: float | None,
    fps: Sequence[float] = VIDEO_FPS,
) -> Iterator[Recording]:
    """Give a recording that was just read its name and time step; every reader ends here.

    Args:
        stretches: The recording in one or more stretches, named by their source.
        name: Name of the recording.
        dt: As `explain_dt`.
        fps: As `explain_dt`.

    Yields:
        Stretches named `name`, as long as all that was seen passes `check_rate`.

    Raises:
        ValueError: As `explain_dt` and `check_rate`.
    """
    counts = None
    for stretch in stretches:
        if counts is None:
            if len(stretch.frames) < 2:
                raise ValueError(f"{stretch.name}: expected two frames, which tell the rate")
            explained = explain_dt(stretch.name, stretch.frame_step, dt, fps)
            counts = Tally(replace(stretch, name=name, dt=explained))
        part = replace(stretch, name=name, dt=counts.dt)
        counts.add(part)
        counts.check(stretch.name)
        yield part
