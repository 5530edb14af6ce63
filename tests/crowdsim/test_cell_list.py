import numpy as np
import pytest

from crowdsim.cell_list import near_pairs


@pytest.mark.parametrize(
    ("count", "spread"), [(0, 1.0), (1, 1.0), (60, 30.0), (20, 3.0), (200, 12.0), (80, 0.5)]
)
def test_pairs_are_those_of_everybody_with_everybody(count, spread):
    rng = np.random.default_rng(count)
    bodies = rng.uniform(-spread, spread, (count, 4))
    present = rng.random(count) < 0.8
    distance = np.linalg.norm(bodies[:, None, :2] - bodies[None, :, :2], axis=-1)
    near = np.triu((distance < 2.0) & present[:, None] & present, 1)
    pairs = near_pairs(bodies, present, 2.0)
    found = {tuple(sorted(pair)) for pair in pairs.tolist()}
    assert len(found) == len(pairs)
    assert found == set(zip(*(index.tolist() for index in np.nonzero(near)), strict=True))


def test_two_at_one_place_are_no_pair():
    assert len(near_pairs(np.zeros((2, 4)), np.ones(2, dtype=bool), 1.0)) == 0
