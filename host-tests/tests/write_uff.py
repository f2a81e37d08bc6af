"""Writes the two channels of a WAV file of 32 bit floats with pyuff: text.uff and binary.uff."""
import sys

import numpy as np
import pyuff

FS = 44100.0
HEADER = 44

x = np.fromfile(sys.argv[1], dtype="<f4", offset=HEADER).astype(float).reshape(-1, 2)
for name, binary in (("text", 0), ("binary", 1)):
    for channel in range(2):
        record = pyuff.prepare_58(
            binary=binary,
            func_type=1,
            rsp_node=channel + 1,
            rsp_dir=3,
            ref_node=0,
            ref_dir=0,
            data=x[:, channel],
            x=np.arange(len(x)) / FS,
            id1="two channels",
            ver_num=1,
            load_case_id=0,
            abscissa_spacing=1,
            abscissa_min=0.0,
            abscissa_inc=1 / FS,
            z_axis_value=0.0,
            abscissa_spec_data_type=17,
            ordinate_spec_data_type=12,
            ordinate_axis_units_lab="m/s^2",
            return_full_dict=True,
        )
        for key, value in list(record.items()):
            if value is None:
                words = key.endswith(("name", "lab")) or key.startswith("id")
                record[key] = "NONE" if words else 0
        pyuff.UFF(f"{sys.argv[2]}/{name}.uff").write_sets(record, "add")
