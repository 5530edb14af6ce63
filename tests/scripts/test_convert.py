"""`crowdnav convert` end to end: it says what it read, and nothing is lost on the way."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from command_line import Crowdnav

from crowdsim.recordings import read_eth_ucy, read_recordings, read_scene

SUMMARY = (
    "148 people, 5153 positions in 872 rows of 0.4 s (10 frames), mean speed 1.07 m/s, "
    "x -0.1 to 15.5 m, y -0.4 to 12.4 m\n"
)


def test_a_crowd_goes_through_all_formats(
    crowdnav: Crowdnav, data_root: Path, tmp_path: Path
) -> None:
    crowd = data_root / "eth_ucy" / "splits" / "all" / "crowds_zara01.txt"
    steps = ["zara.ndjson", "zara", "zara.txt.gz", "x/obsmat.txt", "zara.csv", "back.txt"]
    source = crowd
    for step in steps:
        options = ["--metres_per_px", 0.01]
        # Frame numbers of 25 fps in a format whose own are of 30 fps explain nothing.
        options += ["--dt", 0.4] if source.suffix == ".csv" else []
        outcome = crowdnav("convert", *options, source, tmp_path / step)
        assert outcome.status == 0, outcome.err
        assert outcome.out.partition(": ")[2].startswith(SUMMARY)
        source = tmp_path / step
    original, found = read_scene(data_root, "crowds_zara01"), read_eth_ucy(tmp_path / "back.txt")
    np.testing.assert_array_equal(found.valid, original.valid)
    np.testing.assert_allclose(found.positions, original.positions, atol=1.1e-3)
    assert yaml.safe_load((tmp_path / "zara" / "config.yaml").read_text())["dt"] is None


def test_many_recordings_become_a_data_set_or_a_folder_of_files(
    crowdnav: Crowdnav, data_root: Path, tmp_path: Path
) -> None:
    outcome = crowdnav("convert", data_root / "sdd" / "standard_test.csv.gz", tmp_path / "sdd")
    assert outcome.out.count("rows of 0.4 s (12 frames)") == 17
    recordings = read_recordings(tmp_path / "sdd")
    assert sum(len(recording.ids) for recording in recordings) == 2829
    form = ("--output_format", "trajnet")
    assert crowdnav("convert", *form, tmp_path / "sdd", tmp_path / "files").status == 0
    files = sorted(path.stem for path in (tmp_path / "files").glob("*.ndjson"))
    assert files == sorted(recording.name for recording in recordings)


@pytest.mark.parametrize("out", ["again", "again.txt"])
def test_a_refused_file_leaves_nothing(crowdnav: Crowdnav, tmp_path: Path, out: str) -> None:
    crowd = tmp_path / "crowd.txt"
    crowd.write_text("".join(f"{10 * i} 1 {9.0 * i} 0.0\n" for i in range(9)))
    outcome = crowdnav("convert", crowd, tmp_path / out)
    assert (outcome.status, "22.50 m/s" in outcome.err) == (2, True)
    assert list(tmp_path.iterdir()) == [crowd]
