"""`crowdnav convert`: recordings from one format into another."""

from pathlib import Path
from typing import Literal

from scripts.options import PositiveNumber
from scripts.output import require_folder

FormatName = Literal["dataset", "eth_ucy", "obsmat", "trajnet", "sdd"]


def convert(
    recordings: Path,
    out: Path,
    input_format: FormatName | None = None,
    output_format: FormatName | None = None,
    dt: PositiveNumber | None = None,
    metres_per_px: PositiveNumber | None = None,
) -> None:
    """Convert recordings from one format into another, and say what they hold.

    Formats are data sets as `crowdnav generate` writes them, text of ETH/UCY and its `obsmat`,
    TrajNet++ ndjson and SDD csv; text may be gzipped. A file whose frames or speeds contradict
    its time step is refused. Files of any length are converted in little memory, if they are
    sorted by frame.

    Args:
        recordings: What to read, a file or the folder of a data set.
        out: What to write: the name of a file tells its format; no ending is a data set, or a
            folder of one file for every recording if --output_format says so.
        input_format: Format of the recordings; their contents tell it otherwise.
        output_format: Format to write; the name tells it otherwise.
        dt: Time of a frame step [s], for text that does not explain it.
        metres_per_px: Scale of SDD pixels; read from scales.csv beside the file otherwise.
    """
    require_folder(out.parent)
    from crowdsim.recordings.formats import (
        format_of_input,
        format_of_output,
        iter_format,
        write_format,
    )
    from crowdsim.recordings.rate import tallied

    read_as = format_of_input(recordings) if input_format is None else input_format
    write_as = format_of_output(out) if output_format is None else output_format
    stretches = iter_format(recordings, read_as, dt=dt, metres_per_px=metres_per_px)
    write_format(out, write_as, tallied(stretches, print), metres_per_px=metres_per_px)
    print(f"Converted {read_as} into {write_as} in {out}")
