"""Compute the reference of this folder with the real imucal.

usage: python make.py DATA_FOLDER > example_ferraris_session.json

DATA_FOLDER holds `imucal-ferraris/` (see README.md). Needs imucal 2.6.
"""

import importlib.metadata
import json
import sys
from pathlib import Path

import pandas as pd
from imucal import FerrarisCalibration, ferraris_regions_from_section_list

folder = Path(sys.argv[1]) / "imucal-ferraris"
data = pd.read_csv(folder / "example_ferraris_session.csv", index_col=0)
limits = json.loads((folder / "example_ferraris_session_list.json").read_text())
sections = pd.DataFrame(limits).T
regions = ferraris_regions_from_section_list(data.reset_index(drop=True), sections)
info = FerrarisCalibration(grav=9.81, expected_angle=-360).compute(
    regions, sampling_rate_hz=102.4, from_acc_unit="m/s^2", from_gyr_unit="deg/s"
)
out = {
    "made_with": "imucal " + importlib.metadata.version("imucal"),
    "recording": "imucal-ferraris/example_ferraris_session.csv",
    "gravity_mps2": 9.81,
    "turn_angle_deg": -360.0,
    "rate_hz": 102.4,
}
for key in ("K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g"):
    out[key] = getattr(info, key).tolist()
json.dump(out, sys.stdout, indent=2)
print()
