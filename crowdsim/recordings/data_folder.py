"""Where the real data lies, and its pictures."""

import os
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray


def find_data(path: Path | str | None = None) -> Path:
    """Folder `eth_ucy` of the real data.

    Args:
        path: That folder or the one above it. None looks at `$CROWDNAV_DATA`, then at
            `../shared/data` beside the working directory and beside this checkout.

    Raises:
        FileNotFoundError: It is at none of these places; the message names them.
    """
    return _find(path, "eth_ucy", "splits/loo.json", "ETH/UCY")


def find_sdd(path: Path | str | None = None) -> Path:
    """Folder `sdd` of the real data, looked for as by `find_data`.

    Raises:
        FileNotFoundError: It is at none of these places; the message names them.
    """
    return _find(path, "sdd", "scales.csv", "Stanford Drone")


def _find(path: Path | str | None, name: str, mark: str, title: str) -> Path:
    candidates = _candidates() if path is None else [Path(path)]
    for candidate in candidates:
        for folder in (candidate, candidate / name):
            if (folder / mark).is_file():
                return folder
    looked = ", ".join(str(candidate) for candidate in candidates)
    raise FileNotFoundError(
        f"expected the {title} data (a folder {name} with {mark}), "
        f"found none at {looked}; name it by --data or $CROWDNAV_DATA"
    )


def _candidates() -> list[Path]:
    if "CROWDNAV_DATA" in os.environ:
        return [Path(os.environ["CROWDNAV_DATA"])]
    shared = Path("shared") / "data"
    return [Path("..") / shared, Path(__file__).resolve().parents[3] / shared]


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """(H, W, 3) RGB picture.

    Raises:
        FileNotFoundError: It is missing or damaged; OpenCV does not tell which.
    """
    return np.asarray(cv2.cvtColor(_read(path, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB), np.uint8)


def read_mask(path: Path) -> NDArray[np.uint8]:
    """(H, W) mask; the first channel of a picture that has several.

    Raises:
        FileNotFoundError: It is missing or damaged; OpenCV does not tell which.
    """
    mask = _read(path, cv2.IMREAD_UNCHANGED)
    return mask if mask.ndim == 2 else mask[..., 0]


def _read(path: Path, flags: int) -> NDArray[np.uint8]:
    image = cv2.imread(str(path), flags)
    if image is None:
        raise FileNotFoundError(f"expected a readable picture at {path}")
    return np.asarray(image, dtype=np.uint8)
