# SPDX-License-Identifier: MIT
"""`pipewright canlog export --mcap --depth` of depth frames that are known, read by mcap_file.py: each
point is where a pinhole camera has it, and the camera where the arm's vendor has the flange.

usage: mcap_points_by_spec.py PIPEWRIGHT FOLDER
"""
import json
import math
import pathlib
import random
import struct
import subprocess
import sys

import zstandard

from mcap_file import McapFile, require

WIDTH, HEIGHT, FX, FY, CX, CY, NEAR_M, FAR_M = 317, 241, 210.5, 209.25, 160.3, 118.9, 0.2, 6.0
FRAMES, PERIOD_NS, FIRST_NS = 20, 100_000_000, 4_000_000
LOG_FROM_S, LOG_TO_S = 0.25, 1.75
JOINTS_FROM_S, SILENT_FROM_S, SILENT_TO_S = 0.5, 1.0, 1.3
HOLD_S = 0.030  # for so long the robot moves its own state on
POINT = [{"name": name, "offset": offset, "datatype": 7, "count": 1} for name, offset in (("x", 0), ("y", 4), ("z", 8))]


def item(content):
    return zstandard.ZstdCompressor(write_checksum=True).compress(content)


def depth_file(frames):
    """[(stamp in ns, depths in mm)] by hil/replay/depth_recording.h."""
    items = [item(struct.pack("<4sII6d", b"PWZ1", WIDTH, HEIGHT, FX, FY, CX, CY, NEAR_M, FAR_M))]
    for number, (stamp, depths) in enumerate(frames):
        folded, before = [], 0
        for depth in depths:
            step = (depth - before + 0x8000) % 0x10000 - 0x8000
            folded.append(2 * step if step >= 0 else -2 * step - 1)
            before = depth
        items.append(item(struct.pack("<4sIqq", b"PWZF", number, stamp + 1_000_000, stamp) +
                          bytes(f & 0xFF for f in folded) + bytes(f >> 8 for f in folded)))
    return items + [item(struct.pack("<4sI", b"PWZE", len(frames)))]


def depth_frames(rng):
    """Slopes, holes, and readings at and beyond both ends of the camera's range."""
    frames = []
    for number in range(FRAMES):
        depths = [900 + 5 * number + i // 40 + rng.randrange(5) for i in range(WIDTH * HEIGHT)]
        for _ in range(9000):
            depths[rng.randrange(len(depths))] = rng.choice([0, 1, 199, 200, 6000, 6001, 65535, rng.randrange(65536)])
        frames.append((FIRST_NS + number * PERIOD_NS, depths))
    return frames


def can_log():
    lines = []
    for ms in range(round(1000 * LOG_FROM_S), round(1000 * LOG_TO_S) + 1):
        t = ms / 1000
        if ms % 20 == 10:
            lines.append((1000 * ms, 0x221, bytes(8)))
            lines.append((1000 * ms + 1, 0x311, bytes(8)))
        if ms % 10 == 0 and t >= JOINTS_FROM_S:
            for joint in range(1, 8):
                if joint != 3 or not SILENT_FROM_S <= t < SILENT_TO_S:
                    lines.append((1000 * ms + joint, 0x180 + joint, bytes(8)))
    return "".join(f"({us // 10**6}.{us % 10**6:06}) can0 {id:03X}#{data.hex().upper()}\n" for us, id, data in lines)


def as_float32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def check_points(message, stamp, depths, every):
    require(message["header"] == {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "camera"},
            message["header"])
    width, height = WIDTH // every, HEIGHT // every
    require((message["width"], message["height"]) == (width, height), "size")
    require(message["fields"] == POINT and message["is_bigendian"] == 0 and message["is_dense"] == 0, "layout")
    require(message["point_step"] == 12 and message["row_step"] == 12 * width, "steps")
    points = list(struct.iter_unpack("<fff", message["data"]))
    require(len(points) == width * height, "points", len(points))
    missing = 0
    for i, point in enumerate(points):
        u, v = i % width * every + every // 2, i // width * every + every // 2
        z = depths[v * WIDTH + u] / 1000
        if NEAR_M <= z <= FAR_M:
            expected = (u - CX) * z / FX, (v - CY) * z / FY, z
            require(all(abs(a - b) <= 1e-6 * abs(b) for a, b in zip(point, expected)), (u, v), point, expected)
        else:
            require(all(math.isnan(a) for a in point), (u, v), point)
            missing += 1
    require(0.02 < missing / len(points) < 0.2, "readings that are none", missing)


def check_camera(transforms):
    """All joints at zero: the vendor has the flange at (0.206, 0, 0.1205) from the arm's foot, upside
    down; the foot is at (0.10, 0, 0.28) on the base, the camera 0.045 before the flange."""
    for _, message in transforms:
        moved, = message["transforms"]
        require(moved["header"]["frame_id"] == "base_link" and moved["child_frame_id"] == "camera", moved)
        at, turned = moved["transform"]["translation"], moved["transform"]["rotation"]
        require(all(abs(at[axis] - value) < 1e-12
                    for axis, value in (("x", 0.306), ("y", 0), ("z", 0.28 + 0.1205 - 0.045))), at)
        require(abs(abs(turned["x"]) - 1) < 1e-12 and all(abs(turned[axis]) < 1e-12 for axis in "yzw"), turned)


def joints_known(stamp):
    """The joints came 1 to 7 us behind every 10 ms, the third one with a silence."""
    t = stamp / 1e9
    return t >= JOINTS_FROM_S + 7e-6 and not SILENT_FROM_S - 0.010 + 3e-6 + HOLD_S < t < SILENT_TO_S + 3e-6


def check(pipewright, folder, frames, every):
    out = folder / f"every{every}.mcap"
    options = [] if every == 2 else ["--points-every", str(every)]
    done = subprocess.run([pipewright, "canlog", str(folder / "can.log"), "export", "--mcap", str(out), "--depth",
                           str(folder / "depth.z16.zst"), "--json", *options], capture_output=True, text=True)
    require(done.returncode == 0 and done.stderr == "", done.returncode, done.stderr)
    figures = json.loads(done.stdout)
    mcap = McapFile(out.read_bytes())
    require({t["topic"]: (t["type"], t["messages"]) for t in figures["topics"]} ==
            {topic: (mcap.schemas[schema][0], sum(m[0] == number for m in mcap.messages))
             for number, (schema, topic, _) in mcap.channels.items()}, figures["topics"])
    require({t["topic"]: t["type"] for t in figures["topics"]}["/camera/points"] == "sensor_msgs/msg/PointCloud2", "type")

    last_ns = LOG_TO_S * 1e9 if LOG_TO_S * 100 % 1 else LOG_TO_S * 1e9 + 7000
    inside = [(stamp, depths) for stamp, depths in frames if LOG_FROM_S * 1e9 <= stamp <= last_ns]
    clouds = mcap.topic("/camera/points")
    require([time for time, _ in clouds] == [stamp for stamp, _ in inside] and 3 < len(clouds) < FRAMES - 3, len(clouds))
    for (_, message), (stamp, depths) in zip(clouds, inside):
        check_points(message, stamp, depths, every)

    transforms = [t for t in mcap.topic("/tf") if t[1]["transforms"][0]["child_frame_id"] == "camera"]
    placed = [stamp for stamp, _ in inside if joints_known(stamp)]
    require([time for time, _ in transforms] == placed and 3 < len(placed) < len(clouds) - 3, len(transforms))
    check_camera(transforms)
    require(figures["depth"] == {"path": str(folder / "depth.z16.zst"), "frames": FRAMES,
                                 "outside_log": FRAMES - len(inside), "without_joints": len(inside) - len(placed),
                                 "ends_early": None}, figures["depth"])
    # In the order of time, but for the joints' message that waits for a silent one.
    late = {number for number, channel in mcap.channels.items() if channel[1] == "/joint_states"}
    times = [m[2] for m in mcap.messages if m[0] not in late]
    require(times == sorted(times), "order")
    return len(clouds), len(transforms), out.stat().st_size


def main():
    pipewright, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    frames = depth_frames(random.Random(7))
    (folder / "depth.z16.zst").write_bytes(b"".join(depth_file(frames)))
    (folder / "can.log").write_text(can_log())
    for every in (1, 2, 5):
        clouds, transforms, size = check(pipewright, folder, frames, every)
        print(f"mcap_points_by_spec: every {every}: {clouds} clouds, {transforms} transforms, {size} bytes")


main()
