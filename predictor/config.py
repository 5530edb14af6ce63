"""Frozen configurations of model and training, free of torch so that `--help` is fast."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, Self, get_args

from predictor.backbone_config import BACKBONES, PICTURE_PX, BackboneConfig

Variant = Literal["none", "patch", "resnet18", "vit_b16"]
VARIANTS: tuple[Variant, ...] = get_args(Variant)
ModelName = Literal["iterative_attention", "history_mlp", "lstm", "social_lstm"]
ConfigName = Literal["paper", "residual", "finetune", "fast"]
Device = Literal["auto", "cpu", "cuda", "mps"]


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


@dataclass(frozen=True, kw_only=True)
class NetworkConfig:
    """What every network sees and gives; each adds its own sizes.

    Attributes:
        variant: Map features: `none`, `patch` for linear patches of the rotated crop, or those of
            a network for pictures, `resnet18` or `vit_b16`.
        history_steps: Observed frames, the last one is now.
        forecast_steps: Frames forecast in one pass.
        frame_dt: Time between two frames [s].
        neighbors: Nearest people that the network sees (K).
        crop_side: Side of the square map crop [m].
        crop_px: Side of the crop in pixels.
        residual: Goal and path are corrections of constant velocity instead of free positions.

    Raises:
        ValueError: A value is out of range.
    """

    variant: Variant = "none"
    history_steps: int = 8
    forecast_steps: int = 12
    frame_dt: float = 0.4
    neighbors: int = 8
    crop_side: float = 12.0
    crop_px: int = 64
    residual: bool = False

    def __post_init__(self) -> None:
        _require(
            self.variant in VARIANTS, f"variant must be one of {VARIANTS}, got {self.variant!r}"
        )
        self.require_counts("history_steps", "forecast_steps", "neighbors", "crop_px")
        for name in ("frame_dt", "crop_side"):
            value = getattr(self, name)
            _require(math.isfinite(value) and value > 0.0, f"{name} must be positive, got {value}")

    def require_counts(self, *names: str) -> None:
        """Raise ValueError where a field of these names is not in 1..4096."""
        for name in names:
            value = getattr(self, name)
            _require(1 <= value <= 4096, f"{name} must be in 1..4096, got {value}")

    def require_no_map(self) -> None:
        """Raise ValueError where a network that has no map encoder is asked for a map."""
        _require(
            self.variant == "none",
            f"variant must be 'none' for a network that sees no map, got {self.variant!r}",
        )

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Build from a plain dict, such as the JSON of a checkpoint.

        Raises:
            ValueError: A key is unknown or a value is out of range.
        """
        known = [field.name for field in fields(cls)]
        unknown = sorted(set(values) - set(known))
        _require(not unknown, f"unknown model keys {unknown}; known are {known}")
        return cls(**values)


@dataclass(frozen=True, kw_only=True)
class ModelConfig(NetworkConfig):
    """What the iterative-attention network is. The defaults are those of the paper.

    Attributes:
        latents: Learned latent vectors (L).
        width: Size of latents and tokens (C).
        blocks: Encoder blocks.
        heads: Attention heads; divides `width`.
        dropout: Dropout rate in training.
        time_code: Size of the sinusoidal code of the time step; the rest of `width` is the pose.
        patch_px: Side of one patch in pixels; divides `crop_px`.
        tokens: What a token of people is: `frame`, one position of one person (the paper), or
            `track`, the whole history of a neighbor, while the own one is what the latents begin
            with.
        path_rows: How the latent rows become a path: `mean` decodes each row and averages (the
            paper), `flatten` decodes all rows at once.
        modes: Modes of the mixture that is forecast beside the one path (M); 0 for none.
        backbone: The network for pictures of the variants that have one; None for the others.

    Raises:
        ValueError: A value is out of range.
    """

    latents: int = 12
    width: int = 48
    blocks: int = 4
    heads: int = 8
    dropout: float = 0.1
    time_code: int = 16
    patch_px: int = 16
    tokens: Literal["frame", "track"] = "frame"
    path_rows: Literal["mean", "flatten"] = "mean"
    modes: int = 0
    backbone: BackboneConfig | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _require(
            self.path_rows in ("mean", "flatten"),
            f"path_rows must be 'mean' or 'flatten', got {self.path_rows!r}",
        )
        _require(
            self.tokens in ("frame", "track"),
            f"tokens must be 'frame' or 'track', got {self.tokens!r}",
        )
        self.require_counts("latents", "blocks")
        _require(0 <= self.modes <= 64, f"modes must be in 0..64, got {self.modes}")
        _require(0.0 <= self.dropout < 1.0, f"dropout must be in [0, 1), got {self.dropout}")
        self._check_divisions()
        self._check_backbone()

    def _check_divisions(self) -> None:
        width, heads, code = self.width, self.heads, self.time_code
        _require(
            heads >= 1 and 1 <= width <= 4096 and width % heads == 0,
            f"heads must divide width, got width {width} and heads {heads}",
        )
        _require(width % 4 == 0, f"width must be a multiple of 4, got {width}")
        _require(
            code % 2 == 0 and 0 < code < width,
            f"time_code must be even and in 2..width-2, got {code} for width {width}",
        )
        _require(
            self.patch_px >= 1 and self.crop_px % self.patch_px == 0,
            f"patch_px must divide crop_px, got {self.patch_px} and {self.crop_px}",
        )

    def _check_backbone(self) -> None:
        published, backbone = BACKBONES.get(self.variant), self.backbone
        expected, found = (None if b is None else b.kind for b in (published, backbone))
        _require(
            expected == found,
            f"variant {self.variant!r} needs a backbone of the kind {expected}, got {found}",
        )
        if backbone is not None:
            backbone.require_crop(self.crop_px)

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Build from a plain dict, as `NetworkConfig.from_dict` says."""
        backbone = values.get("backbone")
        if backbone is not None:
            values = {**values, "backbone": BackboneConfig.from_dict(backbone)}
        return super().from_dict(values)


@dataclass(frozen=True, kw_only=True)
class TrainConfig:
    """How a model is trained. The defaults are those of the paper.

    Attributes:
        epochs: Passes over the training windows.
        batch_size: Windows in one step.
        schedule: `step` is Adam with the rate cut to a fifth every 30 epochs (the paper);
            `one_cycle` is AdamW with one cycle up to `learning_rate`.
        learning_rate: Initial (step) or highest (one cycle) rate.
        gradient_clip: Largest norm of the gradient.
        true_goal: The trajectory decoder is given the true goal in training (the paper), instead
            of the predicted one that it meets in use.
        mirror: Mirror a window along the heading with probability 1/2.
        scale: A window is scaled by a factor drawn from [1 - scale, 1 + scale].
        hide_map: Share of windows whose map is hidden: worlds may have none.
        recolor: Share of windows whose map is shown in other colours (`augment.recolor`).
        truncate: Share of windows whose first frames are hidden, so that the model learns to
            forecast from 1 to 7 observed frames.
        stride: Frames between two training windows.
        train_only: `all` trains everything together; `modes` leaves the network as it is, apart
            from its mode decoder.
        patience: Stop after so many epochs without a better validation; None never does.
        seed: Seed of initial weights, order of windows and augmentation.

    Raises:
        ValueError: A value is out of range.
    """

    epochs: int = 65
    batch_size: int = 32
    schedule: Literal["step", "one_cycle"] = "step"
    learning_rate: float = 5e-4
    gradient_clip: float = 1.0
    true_goal: bool = True
    mirror: bool = False
    scale: float = 0.0
    hide_map: float = 0.0
    recolor: float = 0.0
    truncate: float = 0.25
    stride: int = 1
    train_only: Literal["all", "modes"] = "all"
    patience: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("epochs", "batch_size", "stride"):
            value = getattr(self, name)
            _require(value >= 1, f"{name} must be at least 1, got {value}")
        for name in ("learning_rate", "gradient_clip"):
            value = getattr(self, name)
            _require(math.isfinite(value) and value > 0.0, f"{name} must be positive, got {value}")
        _require(
            self.schedule in ("step", "one_cycle"),
            f"schedule must be 'step' or 'one_cycle', got {self.schedule!r}",
        )
        _require(
            self.train_only in ("all", "modes"),
            f"train_only must be 'all' or 'modes', got {self.train_only!r}",
        )
        _require(0.0 <= self.scale < 1.0, f"scale must be in [0, 1), got {self.scale}")
        for name in ("hide_map", "recolor", "truncate"):
            value = getattr(self, name)
            _require(0.0 <= value <= 1.0, f"{name} must be in [0, 1], got {value}")
        _require(
            self.patience is None or self.patience >= 1,
            f"patience must be at least 1 or None, got {self.patience}",
        )
        _require(self.seed >= 0, f"seed must not be negative, got {self.seed}")


PAPER = (ModelConfig(), TrainConfig())
"""The paper's model and training."""

RESIDUAL = (
    ModelConfig(residual=True, path_rows="flatten"),
    TrainConfig(
        epochs=12,
        batch_size=256,
        schedule="one_cycle",
        learning_rate=2e-3,
        true_goal=False,
        mirror=True,
        scale=0.2,
        hide_map=0.2,
        recolor=0.5,
    ),
)
"""Corrections of constant velocity, trained on the goals that the model itself predicts."""

FINETUNE = (RESIDUAL[0], replace(RESIDUAL[1], epochs=4, learning_rate=1e-3, recolor=0.0))
"""Adapts trained weights to other crowds: smaller steps, and maps in the colours that they have."""

FAST = (
    replace(
        RESIDUAL[0],
        tokens="track",
        latents=6,
        width=64,
        blocks=1,
        heads=4,
        crop_px=32,
        patch_px=8,
    ),
    replace(RESIDUAL[1], epochs=6),
)
"""A fifth of the time of `residual`: for the loop, where a forecast is needed at every step."""

CONFIGURATIONS: dict[str, tuple[ModelConfig, TrainConfig]] = {
    "paper": PAPER,
    "residual": RESIDUAL,
    "finetune": FINETUNE,
    "fast": FAST,
}


def named_configuration(
    name: str, *, variant: Variant = "none", seed: int = 0, epochs: int | None = None
) -> tuple[ModelConfig, TrainConfig]:
    """Look up one of `CONFIGURATIONS` and set the few things that are chosen anew for each run.

    Args:
        name: Key of `CONFIGURATIONS`.
        variant: Map features of the model.
        seed: Seed of the training.
        epochs: Number of epochs; None keeps the configuration's own.

    Raises:
        ValueError: The name is unknown or a value is out of range.
    """
    _require(
        name in CONFIGURATIONS,
        f"configuration must be one of {sorted(CONFIGURATIONS)}, got {name!r}",
    )
    model, training = CONFIGURATIONS[name]
    training = replace(training, seed=seed)
    if epochs is not None:
        training = replace(training, epochs=epochs)
    backbone = BACKBONES.get(variant)
    crop_px = model.crop_px if backbone is None else PICTURE_PX
    return replace(model, variant=variant, backbone=backbone, crop_px=crop_px), training
