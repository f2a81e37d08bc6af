"""Reads a universal file with pyuff, or a MATLAB file with scipy, and says what is in it, as JSON."""
import json
import sys

import numpy as np

path = sys.argv[1]
if path.endswith(".mat"):
    from scipy.io import loadmat

    out = {}
    for name, value in loadmat(path).items():
        if not name.startswith("__"):
            text = value.dtype.kind == "U"
            out[name] = str(value[0]) if text else np.asarray(value).T.tolist()
else:
    import pyuff

    out = []
    sets = pyuff.UFF(path).read_sets()
    # One alone comes as itself.
    for entry in [sets] if isinstance(sets, dict) else sets:
        out.append(
            {
                "func_type": int(entry["func_type"]),
                "abscissa": int(entry["abscissa_spec_data_type"]),
                "unit": entry["ordinate_axis_units_lab"].strip(),
                "x": [float(x) for x in entry["x"]],
                "data": [float(y) for y in np.real(entry["data"])],
            }
        )
print(json.dumps(out))
