"""Reads a universal file with pyuff and says what is in it, as JSON."""
import json
import sys

import pyuff

sets = []
for entry in pyuff.UFF(sys.argv[1]).read_sets():
    if entry["type"] != 58:
        continue
    sets.append(
        {
            "func_type": int(entry["func_type"]),
            "rsp_node": int(entry["rsp_node"]),
            "rsp_dir": int(entry["rsp_dir"]),
            "ref_node": int(entry["ref_node"]),
            "ref_dir": int(entry["ref_dir"]),
            "numerator": entry["ordinate_spec_data_type"],
            "denominator": entry["orddenom_spec_data_type"],
            "f": [float(x) for x in entry["x"]],
            "re": [float(z.real) for z in entry["data"]],
            "im": [float(z.imag) for z in entry["data"]],
        }
    )
print(json.dumps(sets))
