"""Print the data of the line in the new figure."""

import json
import sys

import xarray as xr

from sweeps.config.load import from_mapping
from sweeps.figures import draw

ds = xr.Dataset({"amplitude_error": ("temperature", [1e-7, 2e-7])}, {"temperature": [200.0, 250.0]})
line = draw(ds, from_mapping({"plot": {"figure": "errors"}}).plot.figure).axes[0].lines[0]
json.dump(line.get_ydata().tolist(), sys.stdout)
