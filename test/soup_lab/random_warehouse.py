"""Warehouses drawn at random: nothing about them is like the ones that policies were tuned on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

LAYOUTS = ("rows", "dense", "hexagonal")
WORDS = Path(__file__).resolve().parents[2] / "config/words"


def draw(seed: int, folder: Path) -> Path:
    """Draw a warehouse; its scenario file. Not each is valid: there may be more buckets than storage spots.

    Floors are 30 to 150 m wide, with 3 to 60 bots, 1 to 12 stations of each kind, buckets of 4 to 100 tiles, transfers
    of 1 to 10 s, bundles of 1 to 12 tiles, 1 to 4 open words, 1 to 5 staged bundles.
    """
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 2)

    def number(low: int, high: int) -> int:
        return int(rng.integers(low, high + 1))

    kind = LAYOUTS[number(0, 2)]
    radius, capacity, bots = between(0.4, 1.0), int(rng.choice([4, 6, 8, 12, 16, 30, 40, 100])), number(3, 60)
    layout = {
        "kind": kind, "pitch_m": round(2 * radius * between(1.55, 2.0), 2), "aisle_lanes": number(1, 2),
        "margin_columns": number(2, 5), "block_rows": number(4, 12),
    }  # fmt: skip
    if kind != "hexagonal":
        layout["block_columns"] = 2 if kind == "rows" else number(3, 6)
    scenario = {
        "name": f"drawn {seed}",
        "floor": {"width_m": between(30.0, 150.0), "height_m": between(30.0, 150.0)},
        "bots": bots,
        "buckets": number(bots, 4 * bots),
        "word_stations": number(1, 12),
        "letter_stations": number(1, 12),
        "bot": {
            "radius_m": radius, "max_speed_mps": between(0.8, 5.0), "max_acceleration_mps2": between(1.0, 20.0),
        },
        "bucket": {"radius_m": radius, "capacity": capacity},
        "word_station": {"open_words": number(1, 4), "transfer_s": between(1.0, 10.0)},
        "letter_station": {"staged_bundles": number(1, 5), "transfer_s": between(1.0, 10.0)},
        "bundle_size": min(capacity, number(1, 12)),
        "initial_inventory": between(0.2, 0.9),
        "words": str(WORDS / "jargon.txt"),
        "colours": [0.8, 0.1, 0.05, 0.05],
        "orders": {"kind": "backlog", "visible": int(rng.choice([20, 50, 200]))},
        "layout": layout,
    }  # fmt: skip
    path = folder / f"{seed}.yaml"
    path.write_text(yaml.safe_dump(scenario), encoding="utf-8")
    return path
