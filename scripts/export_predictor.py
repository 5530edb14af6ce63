"""`crowdnav export-predictor`: a trained predictor for other programs."""

from pathlib import Path

from scripts.output import require_file


def export_predictor(
    checkpoint: str = "iterative_attention",
    out: Path = Path("runs/predictor.onnx"),
) -> None:
    """Write a trained predictor as ONNX or as a program of `torch.export`.

    The numbers of agents and of neighbors stay open. A file of ONNX is a `--forecaster` of the
    other commands, too: `pip install 'crowdnav-testbed[onnx]'`.

    Args:
        checkpoint: `iterative_attention` or `fast` (the bundled weights), or a checkpoint: its
            folder or its `.safetensors` file.
        out: File to write: `.onnx` or `.pt2`.
    """
    require_file(out)
    from predictor.checkpoint import load_checkpoint
    from predictor.export import export_network
    from predictor.forecaster import BUNDLED_WEIGHTS

    path = BUNDLED_WEIGHTS.get(checkpoint, Path(checkpoint))
    network, about = load_checkpoint(path)
    export_network(network, about, out)
    print(f"Written to {out}: {about['model']}, {out.stat().st_size / 1e6:.1f} MB")
