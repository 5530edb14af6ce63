"""Map encoders on networks for pictures, small and at random."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hand_made_crowds import walkers

from crowdsim.recordings import write_recordings
from predictor.backbone_config import BACKBONES, BackboneConfig
from predictor.backbones import BackboneEncoder, with_backbone
from predictor.checkpoint import load_checkpoint, save_checkpoint
from predictor.config import ModelConfig, named_configuration
from predictor.export import export_network
from predictor.model import IterativeAttention, loss
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import scenes
from predictor.tensors import tensors
from predictor.train import train
from predictor.windows import extract_windows

transformers = pytest.importorskip("transformers")

CROP_PX = 32
SMALL = {
    "resnet18": {"embedding_size": 4, "hidden_sizes": [4, 8], "depths": [1, 1]},
    "vit_b16": {
        "hidden_size": 12,
        "num_hidden_layers": 1,
        "num_attention_heads": 2,
        "intermediate_size": 16,
        "image_size": CROP_PX,
        "patch_size": 8,
    },
}
KINDS = {
    "resnet18": (transformers.ResNetConfig, transformers.ResNetModel),
    "vit_b16": (transformers.ViTConfig, transformers.ViTModel),
}


@pytest.fixture(params=sorted(BACKBONES))
def backbone_variant(request: pytest.FixtureRequest) -> str:
    return request.param


def small_backbone(variant: str, **changes: object) -> BackboneConfig:
    published = BACKBONES[variant]
    sizes = {**published.sizes, **SMALL[variant]}
    return replace(published, sizes=sizes, **{"source": None, **changes})


def small_config(variant: str, **changes: object) -> ModelConfig:
    return ModelConfig(
        variant=variant,
        backbone=small_backbone(variant, **changes),
        crop_px=CROP_PX,
        latents=2,
        width=24,
        time_code=8,
        blocks=1,
        heads=2,
        dropout=0.0,
        residual=True,
    )


def built(config: ModelConfig) -> IterativeAttention:
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return IterativeAttention(config)


def arguments(config: ModelConfig) -> dict[str, torch.Tensor]:
    windows = extract_windows([walkers(np.random.default_rng(0), people=5)], config)
    return tensors(windows.batch(np.arange(5))[0])


def published_folder(folder: Path, variant: str) -> Path:
    """A folder as the hub has it."""
    sizes = {**BACKBONES[variant].sizes, **SMALL[variant]}
    config, model = KINDS[variant]
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(1)
        model(config(**sizes)).save_pretrained(folder)
    picture = {"image_mean": [0.1, 0.2, 0.3], "image_std": [0.4, 0.5, 0.6]}
    (folder / "preprocessor_config.json").write_text(json.dumps(picture))
    return folder


@pytest.mark.parametrize("trained", [False, True])
def test_only_a_backbone_that_is_trained_gets_gradients(
    backbone_variant: str, trained: bool
) -> None:
    config = small_config(backbone_variant, trained=trained)
    network = built(config).train()
    goal, path = network(**arguments(config))
    loss(goal, path, torch.ones(5, 12, 2)).backward()
    without = [n for n, p in network.named_parameters() if p.grad is None or not p.grad.any()]
    backbone = [n for n, _ in network.named_parameters() if n.startswith("map_encoder.backbone.")]
    assert without == ([] if trained else backbone)


def test_forecasts_in_training_do_not_depend_on_each_other(backbone_variant: str) -> None:
    config = small_config(backbone_variant, trained=True)
    network, inputs = built(config).train(), arguments(config)
    with torch.no_grad():
        alone = network(**{name: tensor[:1] for name, tensor in inputs.items()})[1]
        torch.testing.assert_close(network(**inputs)[1][:1], alone, atol=1e-5, rtol=0.0)


def test_there_is_a_token_for_each_place_and_the_map_is_seen(backbone_variant: str) -> None:
    config = small_config(backbone_variant)
    network, inputs = built(config).eval(), arguments(config)
    assert isinstance(network.map_encoder, BackboneEncoder)
    with torch.inference_mode():
        tokens = network.map_encoder(inputs["crop"])
        seen, blank = (
            network(**{**inputs, "crop": crop})[1]
            for crop in (inputs["crop"], torch.zeros_like(inputs["crop"]))
        )
    assert tokens.shape == (5, 16, 24)
    places = tokens - network.map_encoder.position_code
    assert (places.std(dim=1) > 1e-4).all()
    assert not torch.equal(seen, blank)


def test_pictures_are_normalized_as_the_backbone_wants_them() -> None:
    mean, deviation = (0.1, 0.2, 0.3), (0.4, 0.5, 0.6)
    config = small_config("resnet18", mean=mean, deviation=deviation)
    encoder, given = built(config).map_encoder, []
    assert isinstance(encoder, BackboneEncoder)
    encoder.backbone.register_forward_pre_hook(lambda _, inputs: given.append(inputs[0]))
    crop = torch.randint(0, 256, (2, CROP_PX, CROP_PX, 3), dtype=torch.uint8)
    encoder(crop)
    for channel in range(3):
        expected = (crop[..., channel] / 255.0 - mean[channel]) / deviation[channel]
        torch.testing.assert_close(given[0][:, channel], expected)


def test_checkpoints_hold_everything(backbone_variant: str, tmp_path: Path) -> None:
    network = built(small_config(backbone_variant, source="nobody/has-this"))
    save_checkpoint(tmp_path / "best.safetensors", network, {})
    loaded, about = load_checkpoint(tmp_path)
    assert loaded.config == network.config
    assert about["config"]["backbone"]["source"] == "nobody/has-this"
    for name, tensor in network.state_dict().items():
        assert torch.equal(tensor, loaded.state_dict()[name]), name
    crowd = walkers(np.random.default_rng(0))
    scene = next(scenes(crowd, history_steps=8, forecast_steps=12))
    seen = scene.history, scene.valid, crowd.map_image, crowd.pixel_from_world
    path = NetworkForecaster(loaded).forecast(*seen)
    assert np.array_equal(path, NetworkForecaster(network).forecast(*seen))


def test_training_begins_with_the_weights_of_a_folder(
    backbone_variant: str, tmp_path: Path
) -> None:
    source = published_folder(tmp_path / "published", backbone_variant)
    write_recordings(
        tmp_path / "crowds", [walkers(np.random.default_rng(i), 3, name=f"{i}") for i in range(2)]
    )
    config = with_backbone(small_config(backbone_variant), str(source), trained=False)
    assert config.backbone is not None
    assert (config.backbone.mean, config.backbone.deviation) == ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    _, training = named_configuration("residual", epochs=1)
    found = train(
        data=str(tmp_path / "crowds"),
        out=tmp_path / "run",
        model=config,
        training=training,
        progress=False,
    )
    kept = load_checkpoint(found.checkpoint)[0].map_encoder
    assert isinstance(kept, BackboneEncoder)
    published = KINDS[backbone_variant][1].from_pretrained(source).state_dict()
    for name, tensor in kept.backbone.state_dict().items():
        assert torch.equal(tensor, published[name]), name


def test_a_backbone_is_exported_with_its_network(tmp_path: Path) -> None:
    config = small_config("vit_b16")
    network, inputs = built(config).eval(), arguments(config)
    export_network(network, {}, tmp_path / "network.pt2")
    program = torch.export.load(tmp_path / "network.pt2").module()
    with torch.inference_mode():
        torch.testing.assert_close(program(**inputs)[1], network(**inputs)[1], atol=1e-5, rtol=0.0)


@pytest.mark.parametrize(
    ("variant", "parameters"), [("resnet18", 11_176_512), ("vit_b16", 85_798_656)]
)
def test_published_backbones_are_those_of_their_papers(variant: str, parameters: int) -> None:
    config, _ = named_configuration("paper", variant=variant)
    with torch.device("meta"):
        encoder = built(config).map_encoder
    assert isinstance(encoder, BackboneEncoder)
    assert sum(p.numel() for p in encoder.backbone.parameters()) == parameters
    assert encoder.position_code.shape == ({"resnet18": 49, "vit_b16": 196}[variant], 48)


@pytest.mark.parametrize(
    ("variant", "crop_px", "message"),
    [
        ("vit_b16", 48, "crop_px must be 32, as its position codes"),
        ("resnet18", 36, "patch_px must divide crop_px"),
        ("resnet18", 48, None),
    ],
)
def test_a_crop_that_does_not_fit_is_named(variant: str, crop_px: int, message: str | None) -> None:
    if message is None:
        assert replace(small_config(variant), crop_px=crop_px).crop_px == crop_px
    else:
        with pytest.raises(ValueError, match=message):
            replace(small_config(variant), crop_px=crop_px)


def test_a_backbone_goes_with_its_variant_only() -> None:
    with pytest.raises(
        ValueError, match=r"'resnet18' needs a backbone of the kind resnet, got vit"
    ):
        replace(small_config("resnet18"), backbone=small_backbone("vit_b16"))
    with pytest.raises(ValueError, match="variants resnet18, vit_b16, got 'patch'"):
        with_backbone(ModelConfig(variant="patch"), None, trained=True)


def test_a_source_that_cannot_be_had_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = small_config("resnet18")
    with pytest.raises(ValueError, match="expected a backbone of the kind resnet, found vit"):
        with_backbone(config, str(published_folder(tmp_path, "vit_b16")), trained=False)

    def unreachable(*_: object, **__: object) -> None:
        raise OSError("We couldn't connect to 'https://huggingface.co'\nand more")

    monkeypatch.setattr(transformers.AutoConfig, "from_pretrained", unreachable)
    with pytest.raises(ValueError, match=r"microsoft/resnet-18 in a folder.*couldn't connect"):
        with_backbone(config, "microsoft/resnet-18", trained=False)


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "transformers", None)
    with pytest.raises(ValueError, match=r"pip install 'crowdnav-testbed\[backbones\]'"):
        built(small_config("resnet18"))
