"""What every forecaster offers, and how one is chosen by name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import FRAME_DT
from predictor.ablation import ENDINGS, split_endings
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.modal_forecast import ModalForecast

BUNDLED_WEIGHTS: Final = {
    name: Path(__file__).parent / "weights" / f"{name}.safetensors"
    for name in ("iterative_attention", "fast")
}
"""Weights trained on synthetic crowds, by the name of their forecaster; the JSON beside each says
how."""


@runtime_checkable
class Forecaster(Protocol):
    """Turns observed tracks into one future path for each person.

    Attributes:
        name: Name for tables.
        frame_dt: Time between two frames of history and forecast [s].
        history_steps: Frames of history that are used (T).
        forecast_steps: Frames that are forecast (F).
    """

    name: str
    frame_dt: float
    history_steps: int
    forecast_steps: int

    def forecast(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Forecast people of W worlds at once; a single world may be given without the W axis.

        Args:
            history: (W, T, N, 2) positions in the frame of their world [m], T frames `frame_dt`
                apart; the last one is now. What stands where `valid` is False is never read.
            valid: (W, T, N) bool, True where the person was seen.
            map_images: W pictures (H, W, 3) uint8 RGB or None; for a single world just the one.
            pixel_from_world: W homographies (3, 3), or None where there is no picture.
            select: (W, N) bool, whom to forecast; default: everyone seen now. The others are
                neighbors only (the robot may be one more column).

        Returns:
            (W, F, N, 2) positions in the frame of their world [m], finite everywhere. Who is seen
            now but not selected stays; who is not seen now is at 0.

        Raises:
            ValueError: Shapes contradict each other or a valid position is not finite.
        """
        ...


@runtime_checkable
class CalibratedForecaster(Protocol):
    """A forecaster that may know how far off it is.

    Attributes:
        radius: (T, F) radius around each forecast position within which the person was found in
            `predictor.calibration.LEVEL` of the cases kept for validation [m], in row k of people
            seen in k + 1 of the T frames of history; None if unknown.
    """

    radius: NDArray[np.float64] | None


@runtime_checkable
class ModalForecaster(Protocol):
    """A forecaster that may know several futures of each person.

    Attributes:
        modes: How many (M); 0 where it knows one only.
    """

    modes: int

    def forecast_modes(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> ModalForecast:
        """Forecast several futures, and with them the one of `Forecaster.forecast`.

        The arguments are those of `Forecaster.forecast`; who asks for both asks here only, as the
        network is then run once.

        Raises:
            ValueError: As `Forecaster.forecast`, or `modes` is 0.
        """
        ...


def steps_of(horizon: float, frame_dt: float = FRAME_DT) -> int:
    """Number of frames in a horizon [s].

    Raises:
        ValueError: The horizon is no positive whole multiple of `frame_dt`.
    """
    steps = round(horizon / frame_dt) if np.isfinite(horizon) else 0
    if steps < 1 or abs(steps * frame_dt - horizon) > 1e-6:
        raise ValueError(f"horizon must be a positive multiple of {frame_dt} s, got {horizon}")
    return steps


def make_forecaster(spec: str, *, horizon: float = 4.8) -> Forecaster | None:
    """Choose a forecaster by name.

    Args:
        spec: `none`, `constant_velocity`, `iterative_attention` or `fast` (`BUNDLED_WEIGHTS`), or
            the path of a checkpoint of any of `predictor.networks.NETWORKS` (its `.safetensors`
            file, or a folder with `best.safetensors`), or of an exported one (`.onnx`). A network's
            name or path may have endings such as `@no_map` (`predictor.ablation.ENDINGS`) that say
            what it is not to be shown.
        horizon: How far to forecast [s]; a multiple of 0.4 s.

    Returns:
        The forecaster, or None for `none`.

    Raises:
        ValueError: Unknown name or ending, bad horizon, or a damaged checkpoint.
        FileNotFoundError: The checkpoint is not there.
    """
    forecast_steps = steps_of(horizon)
    if spec == "none":
        return None
    if spec == "constant_velocity":
        return ConstantVelocityForecaster(forecast_steps=forecast_steps)
    name, ablation = split_endings(spec)
    path = BUNDLED_WEIGHTS.get(name, Path(name))
    if name not in BUNDLED_WEIGHTS and not path.exists():
        raise ValueError(
            "forecaster must be 'none', 'constant_velocity', 'iterative_attention', 'fast' or the "
            f"path of a checkpoint, perhaps with endings of {', '.join(ENDINGS)}; got {spec!r}"
        )
    # torch is imported only by who needs a network
    from predictor.network_forecaster import NetworkForecaster

    return NetworkForecaster.from_checkpoint(path, forecast_steps=forecast_steps, ablation=ablation)
