"""Writes the samples beside it, with other people's writers:

    pip install asammdf mcap mcap-ros2-support pyarrow
    python3 host-tests/formats/samples/make.py

Each is the same motion at 1 kHz: 200 samples of a position in degrees (30 sin 2πt), a duty in per cent (a triangle
of -50 to 50) and a current in mA (whole numbers).
"""

import json
import math
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asammdf import MDF, Signal
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as RosWriter

HERE = Path(__file__).parent
COUNT = 200
# A calendar's nanoseconds: too large for a double.
BEGIN = 1_700_000_000_123_456_789

row = np.arange(COUNT)
stamp = BEGIN + row * 1_000_000
position = 30.0 * np.sin(2.0 * math.pi * row / 1000.0)
duty = np.abs((row % 100) - 50) * 2.0 - 50.0
current = (row * 7) % 1000 - 500

table = pa.table(
    {
        "stamp": pa.array(stamp, pa.timestamp("ns")),
        "pos": pa.array(position, pa.float64()),
        "duty": pa.array(duty, pa.float32()),
        "i": pa.array([None if k == 3 else int(c) for k, c in enumerate(current)], pa.int16()),
        "count": pa.array((row + 4_294_967_000) % 2**32, pa.uint32()),
        "note": pa.array(["text"] * COUNT),
    }
)
for codec in ("snappy", "zstd"):
    pq.write_table(table, HERE / f"run-{codec}.parquet", compression=codec, row_group_size=77)

time = row / 1000.0
with MDF(version="4.10") as mdf:
    mdf.append(
        [
            Signal(position, time, name="pos", unit="deg"),
            Signal(duty.astype(np.float32), time, name="duty", unit="%"),
            # Stored as a count of 2 mA, with a linear conversion.
            Signal(
                ((current + 500) // 1).astype(np.uint16),
                time,
                name="i",
                unit="mA",
                conversion={"a": 1.0, "b": -500.0},
            ),
        ]
    )
    mdf.append([Signal(np.arange(20.0), np.arange(20) / 100.0, name="oil", unit="K")])
    mdf.save(HERE / "run.mf4", overwrite=True, compression=2)

with open(HERE / "run-json.mcap", "wb") as file:
    writer = Writer(file, compression=CompressionType.LZ4)
    writer.start()
    schema = writer.register_schema("motor", "jsonschema", b"{}")
    motor = writer.register_channel("/motor", "json", schema)
    for k in range(COUNT):
        message = {"pos": position[k], "drive": {"duty": duty[k], "i": [int(current[k]), 0]}, "on": True}
        writer.add_message(motor, int(stamp[k]), json.dumps(message).encode(), int(stamp[k]) - 5000)
    writer.finish()

DEFINITION = """std_msgs/Header header
string<=8 frame "a#b"
uint8 MODE_FREE=0
uint8 MODE_HELD = 1
uint8 mode
float64[] position
int32[2] current
float32 duty
Point[<=2] tips
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: motor_msgs/Point
int16 x
float64 y
"""

with open(HERE / "run-ros2.mcap", "wb") as file:
    writer = RosWriter(file, compression=CompressionType.ZSTD)
    schema = writer.register_msgdef("motor_msgs/msg/Motor", DEFINITION)
    for k in range(COUNT):
        seconds, nanoseconds = divmod(int(stamp[k]), 1_000_000_000)
        message = {
            "header": {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": "abc"},
            "frame": "ab" if k % 2 else "abcde",
            "mode": 1,
            "position": [position[k], 0.0],
            "current": [int(current[k]), -1],
            "duty": float(duty[k]),
            "tips": [{"x": -k, "y": position[k]}],
        }
        writer.write_message("/motor", schema, message, int(stamp[k]), int(stamp[k]), k)
        # Another topic, that nothing here reads.
    writer.finish()
