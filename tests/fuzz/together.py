"""What of a scenario must fit together, where keys alone do not say so: what is drawn at random is made to fit."""

import json
from typing import Any

from fuzz.values import Drawer

BANDS = (5.0, 6.3, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0)
LEVELS = ["VC-A", "VC-C", "VC-E", "workshop", "office", "residential"]
FILES = {
    "record.csv": "time [s],z [mm/s]\n" + "".join(f"{k / 500:.3f},{k * 37 % 101 / 500:.4f}\n" for k in range(600)),
    "drive.csv": "time [s],U [V],F [N]\n" + "".join(f"{k / 500:.3f},{k % 7 / 50},{k % 11}\n" for k in range(600)),
    "floor.csv": "band [Hz],z [µm/s],x [µm/s],y [µm/s]\n" + "".join(f"{band:g},9,8,7\n" for band in BANDS),
    "moves.csv": "0,0\n0.02,0.001\n0.05,0.0\n",
    "limits.csv": "band [Hz],good [µm/s],bad [µm/s]\n" + "".join(f"{band:g},5,50\n" for band in BANDS),
}  # fmt: skip
"""Files that scenarios name, by name."""


def law_file(mounts: list[str], gain: float) -> str:
    """A law of one state that makes the pistons give way to the ground."""
    inputs = [f"ground_velocity {mount} z" for mount in mounts]
    n = len(mounts)
    matrices = {
        "A": [[0.5]],
        "B": [[0.0] * n],
        "C": [[0.0]] * n,
        "D": [[gain * (j == k) for j in range(n)] for k in range(n)],
    }
    outputs = [f"valve_command {mount}" for mount in mounts]
    return json.dumps({"inputs": inputs, "outputs": outputs, "period_s": 1e-4, **matrices})


def rising(*names: str) -> Any:
    """A hook that sorts the values of some keys, where all are stated."""

    def hook(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
        if all(name in table for name in names):
            table.update(zip(names, sorted(table[name] for name in names), strict=True))
        return table

    return hook


def _one_or_all(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    """Bounds of a range are stated together or not at all: one alone may pass the other's default."""
    if ("first" in table) != ("last" in table) and not {"frequencies", "density"} & set(table):
        table.pop("first", None)
        table.pop("last", None)
    return rising("first", "last")(draw, table)


def _axes(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "axes" in table:
        table["axes"] = draw.random.sample("xyz", draw.random.randint(1, 3))
    return _one_or_all(draw, _waved(draw, table))


def _waved(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "wave" in table and str(table.get("dof", "z")).startswith("r"):
        del table["dof"]
    if "coherence" in table and "wave" not in table:
        table["wave"] = {"speed": 200.0}
    return _sines(draw, _one_or_all(draw, table) if "amplitude" in table else table)


def _sines(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    frequencies = table.get("frequencies")
    if isinstance(frequencies, list):
        table["frequencies"] = sorted({round(one, 3) for one in frequencies})
        count = len(table["frequencies"])
        for name in ("phases", "velocities", "density"):
            if isinstance(table.get(name), list):
                table[name] = ((table[name] or [1e-6]) * count)[:count]
    return table


def _third_octaves(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    begin, count = draw.random.randrange(6), draw.random.randint(2, 4)
    table["bands"] = list(BANDS[begin : begin + count])
    table["levels"] = [10.0 ** draw.random.uniform(-7, -4) for _ in table["bands"]]
    return table


def _machine(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "size" in table:
        table["size"] = [round(side * draw.random.uniform(1.0, 1.3), 3) for side in (2.2, 1.6, 1.9)]
    mass, size = table.get("mass", 4000.0), table.get("size", [2.2, 1.6, 1.9])
    if "inertia" in table:
        x, y, z = (side**2 * draw.random.uniform(0.8, 1.2) for side in size)
        diagonal = [mass / 12 * one for one in (y + z, x + z, x + y)]
        off = 0.01 * min(diagonal)
        whole = [[diagonal[0], off, 0.0], [off, diagonal[1], 0.0], [0.0, 0.0, diagonal[2]]]
        table["inertia"] = draw.random.choice([diagonal, whole])
    if "cg" in table:
        table["cg"] = [draw.random.uniform(-0.2, 0.2), draw.random.uniform(-0.2, 0.2), draw.random.uniform(0.2, 0.9)]
    return table


def _body(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table.pop("inertia", None)
    table["position"] = [draw.random.uniform(-0.5, 0.5), draw.random.uniform(-0.4, 0.4), draw.random.uniform(0.0, 1.2)]
    return table


def _slide(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table = _body(draw, table)
    table["travel"] = [-0.3, 0.3]
    if "start" in table:
        table["start"] = 0.0
    return table


def _moves(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table["moves"] = [{"time": 0.0, "to": 0.001, "speed": 0.5, "acceleration": 20.0, "jerk": 5e3}]
    return table


def _table_profile(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if draw.random.random() < 0.3:
        return {"kind": "table", "file": "moves.csv"}
    return {"kind": "table", "times": [0.0, 0.01, 0.03], "positions": [0.0, draw.random.uniform(0, 1e-3), 0.0]}


def _isolator(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "flow_curve" in table:
        table["flow_curve"] = [[0.0, 0.0], [0.3, draw.random.uniform(0.1, 0.3)], [1.0, 1.0]]
    if "null_drift" in table:
        table["null_drift_limit"] = 1.0
    for name in ("overlap", "edge_leakage_share", "volume_share", "spool_stuck_at"):
        if name in table:
            table[name] = [draw.random.uniform(-0.2, 0.5)] * 4 if name == "overlap" else draw.random.uniform(0.2, 0.8)
    if draw.random.random() < 0.9:
        table.pop("passive", None)
        table.pop("spool_stuck", None)
        table.pop("air_fraction", None)
    return table


def _fault(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table["time"] = draw.random.uniform(0.0, 0.02)
    if table["kind"].startswith("sensor"):
        table["sensor"] = draw.random.choice(["inertial", "ground"])
        table["mount"] = draw.random.choice(draw.names["mount"])
    return table


def _record(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    kept = {key: table[key] for key in ("detrend", "highpass", "fade_in", "taper", "scale") if key in table}
    if isinstance(kept.get("scale"), dict):
        del kept["scale"]
    if draw.random.random() < 0.1:
        return {"kind": "record", "file": "example:BW.RJOB", **kept}
    return {"kind": "record", "file": "record.csv", **kept}


def _sum(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table["parts"] = [part for part in table["parts"] if part.get("kind") != "sum"][:2] or [{"kind": "rest"}]
    return table


def _control(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    """A law's own keys; it is held for another machine now and then, a machine on the same mounts."""
    if "designed_for" in table:
        table["designed_for"] = {"machine": {"mass": draw.random.uniform(3000.0, 5000.0)}}
    if "rate" in table:
        table["rate"] = draw.random.choice([2000.0, 5000.0, 8000.0, 10000.0])
    if "delay" in table:
        table["delay"] = draw.random.choice([0.0, 1e-4, 2e-4])
    if "bits" in table:
        table["bits"] = draw.random.randint(8, 24)
    for name in ("switch_on", "fade"):
        if name in table:
            table[name] = draw.random.choice([0.0, 0.005, 0.01])
    return table


def _resonant(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table["lines"] = sorted(draw.random.sample([13.0, 24.5, 29.0, 49.0], draw.random.randint(1, 2)))
    table.pop("motions", None)
    if "time" in table or "pace" in table:
        table.pop("time", None)
        table.pop("pace", None)
    return _control(draw, table)


def _combined(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "parts" in table:
        shared = {key: table[key] for key in ("rate", "delay", "bits") if key in table}
        kinds = ["feedforward", "modal"] if draw.random.random() < 0.5 else ["feedforward", "skyhook"]
        table["parts"] = [{"kind": kind, **shared} for kind in kinds]
    return _control(draw, table)


def _driven(component: str) -> Any:
    """A hook: a component of the file that drives."""

    def hook(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
        kept = {key: table[key] for key in ("mounts", "hold", "point", "direction", "fade_in") if key in table}
        return {"kind": "recorded", "file": "drive.csv", "component": component, **kept}

    return hook


def _file_target(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "file", "file": "floor.csv"}


def _upstream(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    return {
        "position": [-draw.random.uniform(3.0, 30.0), 0.0, 0.0],
        "wave": {"speed": draw.random.uniform(100.0, 400.0)},
    }


def _repeated(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table.pop("repeat", None)
    return _axes(draw, table)


def _drifting(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    table.pop("resolution", None)
    return rising("low", "high")(draw, table)


def _spool_feedback(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    return table | ({"delay": 5e-5} if "delay" in table else {})


def _learning(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "band" in table:
        table["band"] = [3.0, 60.0]
    return rising()(draw, table) if table else table


def _law(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "law", "file": "law.json"}


def _criteria(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    if "norms" in table:
        names = ["vc", "nist-a", "iso-2631-2", "din-4150-3", "din-4150-3-floors", "limits.csv"]
        table["norms"] = draw.random.sample(names, draw.random.randint(1, 3))
    table.pop("table", None)
    return table


def _relative(draw: Drawer, table: dict[str, Any]) -> dict[str, Any]:
    places = ["cg", *(f"foot {mount}" for mount in draw.names["mount"]), f"ground {draw.names['mount'][0]}"]
    return {"name": table["name"], **dict(zip(("from", "to"), draw.random.sample(places, 2), strict=True))}


HOOKS = {
    "SineGround": _waved, "MultisineGround": _waved, "SweepGround": _waved, "ShockGround": _repeated,
    "BroadbandGround": _axes, "BurstGround": _repeated, "ShapedGround": _axes, "FloorGround": _waved,
    "ThirdOctaveTarget": _third_octaves, "PsdTarget": _sines, "FileTarget": _file_target,
       "RecordGround": _record, "SumGround": _sum, "Machine": _machine, "Part": _body, "Slide": _slide, "Moves": _moves,
    "TableProfile": _table_profile, "Isolator": _isolator, "MultisineForce": _sines, "RandomForce": _one_or_all,
    "Upstream": _upstream,
    "RecordedCommand": _driven("U"), "RecordedForce": _driven("F"),
    "SpoolFeedback": _spool_feedback, "MultisineCommand": _sines, "ChirpCommand": rising("first", "last"),
    "CriteriaSettings": _criteria,
    "ResponseSpectrumSettings": _one_or_all, "Relative": _relative, "Law": _law, "Learning": _learning,
    "ResonantSettings": _resonant, "AdaptiveSettings": _resonant, "CombinedSettings": _combined,
    **dict.fromkeys(("ValveStuck", "SpoolDrift", "ChamberLeak", "SupplyLost", "SensorDead", "SensorGain"), _fault),
    **dict.fromkeys(("Geophone", "Accelerometer", "DisplacementSensor"), _drifting),
    **{
        f"{name}Settings": _control
        for name in ("Feedforward", "StrokeServo", "Skyhook", "Modal", "Levelling", "Lqg", "HInfinity")
    },
}  # fmt: skip
"""By class of the settings."""
