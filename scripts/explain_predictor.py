"""`crowdnav explain-predictor`: where the network looked for one forecast."""

from pathlib import Path

from jsonargparse.typing import NonNegativeInt

from scripts.output import require_file


def explain_predictor(
    forecaster: str = "iterative_attention",
    data: str = "runs/dataset",
    scene: NonNegativeInt = 0,
    agent: NonNegativeInt = 0,
    out: Path = Path("runs/explanation.png"),
) -> None:
    """Draw the attention of the network to map, neighbors and history for one forecast.

    The map carries the attention of each patch as heat, neighbors are as wide as the attention to
    them; forecasts without map and without neighbors say what the looking changed.

    Args:
        forecaster: `iterative_attention` or `fast` (the bundled weights), or a checkpoint.
        data: As `--data` of `evaluate-predictor`; the tests of all folds, one after the other.
        scene: Number of the window in the data.
        agent: Number of the agent in the window.
        out: File to write: `.png`.
    """
    if out.suffix != ".png":
        raise ValueError(f"expected a file named .png, found {out.name!r}")
    require_file(out)
    from crowdsim.recordings.store import write_atomic
    from predictor.attention_picture import attention_picture
    from predictor.datasets import read_tests
    from predictor.explanation import attentive_network, explain

    network = attentive_network(forecaster)
    recordings = [recording for fold in read_tests(data).values() for recording in fold]
    found = explain(network, recordings, scene=scene, agent=agent)
    out.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(out, attention_picture(found))
    print(f"Drawn in {out}")
