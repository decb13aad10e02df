# SPDX-License-Identifier: MIT
"""`pipewright canlog export --mcap` of a drive that is known, read by mcap_file.py: the file is whole
by the specification, and its messages say what the frames say and where the base really was.

usage: mcap_by_spec.py PIPEWRIGHT FOLDER
"""
import json
import math
import pathlib
import random
import struct
import subprocess
import sys

from mcap_file import McapFile, require

TRACK_M = 0.35
START_S = 1_700_000_000
SILENT_JOINT, SILENT_FROM_S, SILENT_TO_S = 4, 5.0, 6.0
DRIVE_S = 30
STEP_S = 0.001


def drive():
    """Frames (time in us, channel, id, payload) of a base on an arc that changes and of seven joints;
    and where the base was at each odometer frame: {us: (x, y, yaw)}."""
    frames, truth, told = [], {}, {}
    x = y = yaw = left = right = 0.0
    for ms in range(1000 * DRIVE_S):
        t = ms * STEP_S
        v, omega = 0.5 * math.sin(0.4 * t), 0.6 * math.cos(0.23 * t)
        # exact along the arc of one step
        half = omega * STEP_S / 2
        x, y, yaw = x + v * STEP_S * math.cos(yaw + half), y + v * STEP_S * math.sin(yaw + half), yaw + 2 * half
        left += (v - omega * TRACK_M / 2) * STEP_S
        right += (v + omega * TRACK_M / 2) * STEP_S
        us = (START_S * 1000 + ms) * 1000
        if ms % 20 == 0:
            code = 0 if t < 10 else 1 if t < 11 else 0  # a second of emergency stop
            frames.append((us, "can0", 0x111, struct.pack(">hh4x", round(1000 * v), round(1000 * omega))))
            frames.append((us + 100, "can0", 0x211, struct.pack(">BBHHxB", code, 1, 259, 0x8000 * code, ms // 20 % 256)))
            frames.append((us + 200, "can0", 0x221, struct.pack(">hhhh", round(1000 * v), round(1000 * omega), 0, 0)))
            frames.append((us + 300, "can0", 0x311, struct.pack(">ii", round(1000 * left), round(1000 * right))))
            truth[us + 300] = (x, y, yaw)
        if ms % 10 == 0:
            for joint in range(1, 8):
                if joint == SILENT_JOINT and SILENT_FROM_S <= t < SILENT_TO_S:
                    continue
                q, qdot = round(1e6 * math.sin(t + joint)), round(1e6 * math.cos(t + joint))
                frames.append((us + 10 * joint, "can1", 0x180 + joint, struct.pack("<ii", q, qdot)))
                frames.append((us + 500 + joint, "can1", 0x200 + joint, struct.pack("<Hi", 15, qdot)))
        if ms % 250 == 0:
            status = 0x0227 if ms % 500 == 0 else 0x0208
            frames.append((us + 700, "can1", 0x281, struct.pack("<HB", status, 9)))
    frames.append((START_S * 1_000_000 + 1_234_567, "can1", None, bytes(8)))  # bus off
    frames.sort(key=lambda frame: frame[0])
    return frames, truth


def line(frame):
    us, channel, id, payload = frame
    id = "20000040" if id is None else f"{id:03X}"
    return f"({us // 1_000_000}.{us % 1_000_000:06}) {channel} {id}#{payload.hex().upper()}\n"


def stamp_ns(message):
    return message["header"]["stamp"]["sec"] * 10**9 + message["header"]["stamp"]["nanosec"]


def joint_sets(frames, base_id, unpack):
    """What a topic of joints must hold: frames until all seven have come, or one comes again."""
    sets, joints, last = [], {}, 0
    for us, _, id, payload in frames:
        if id is None or not base_id < id <= base_id + 7:
            continue
        joint = id - base_id
        if joint in joints:
            sets.append((last, joints))
            joints = {}
        joints[joint], last = unpack(payload), us
        if len(joints) == 7:
            sets.append((last, joints))
            joints = {}
    return sets + ([(last, joints)] if joints else [])


def check_joints(mcap, topic, sets):
    messages = mcap.topic(topic)
    require(len(messages) == len(sets) and len({len(joints) for _, joints in sets}) == 2, topic, len(messages))
    for (log_ns, message), (us, joints) in zip(messages, sets):
        require(log_ns == stamp_ns(message) == 1000 * us, topic, "time", log_ns, us)
        require(message["name"] == [f"joint{joint}" for joint in sorted(joints)], topic, message["name"])
        for field, place in (("position", 0), ("velocity", 1)):
            expected = [joints[joint][place] for joint in sorted(joints) if joints[joint][place] is not None]
            require(len(message[field]) == len(expected) and
                    all(abs(a - b) < 1e-12 for a, b in zip(message[field], expected)), topic, field)
        require(message["effort"] == [], "effort")


def check_odometry(mcap, frames, truth):
    twists = {us: struct.unpack(">hhhh", payload) for us, _, id, payload in frames if id == 0x221}
    odometry, transforms = mcap.topic("/odom"), mcap.topic("/tf")
    require(len(odometry) == len(truth) == len(transforms), "/odom", len(odometry))
    worst_m = worst_rad = 0
    for (log_ns, message), (_, tf) in zip(odometry, transforms):
        us = log_ns // 1000
        require(stamp_ns(message) == log_ns and message["header"]["frame_id"] == "odom" and
                message["child_frame_id"] == "base_link", "/odom's frames")
        pose = message["pose"]["pose"]
        yaw = 2 * math.atan2(pose["orientation"]["z"], pose["orientation"]["w"])
        require(abs(sum(c * c for c in pose["orientation"].values()) - 1) < 1e-12, "a unit quaternion")
        x, y, true_yaw = truth[us]
        worst_m = max(worst_m, math.hypot(pose["position"]["x"] - x, pose["position"]["y"] - y))
        worst_rad = max(worst_rad, abs(math.remainder(yaw - true_yaw, math.tau)))
        v, omega, _, _ = twists[us - 100]
        linear, angular = (message["twist"]["twist"][part] for part in ("linear", "angular"))
        require(abs(linear["x"] - v / 1000) < 1e-12 and abs(angular["z"] - omega / 1000) < 1e-12, "twist")
        covariance = message["pose"]["covariance"]
        require(all(abs(covariance[6 * r + c] - covariance[6 * c + r]) < 1e-15 for r in range(6) for c in range(6)) and
                all(covariance[i] >= 0 for i in (0, 7, 35)) and covariance[14] == 0, "covariance")
        moved, = tf["transforms"]
        require(moved["header"] == message["header"] and moved["child_frame_id"] == "base_link" and
                moved["transform"] == {"translation": pose["position"], "rotation": pose["orientation"]}, "/tf")
    # Wheel distances are told to 1 mm: up to 3 mm / 0.35 m of yaw.
    require(worst_m < 0.005 and worst_rad < 0.009, "/odom is off the true drive", worst_m, worst_rad)
    last = odometry[-1][1]["pose"]["covariance"]
    require(last[0] > 0 and last[35] > 0, "a covariance that grows")
    return worst_m, worst_rad


def check_commands(mcap, frames):
    expected = [(us, *struct.unpack(">hh4x", payload)) for us, _, id, payload in frames if id == 0x111]
    commands = mcap.topic("/cmd_vel")
    require([(log // 1000, round(1000 * m["twist"]["linear"]["x"]), round(1000 * m["twist"]["angular"]["z"]))
             for log, m in commands] == expected, "/cmd_vel")


def check_diagnostics(mcap):
    told = {}
    for log_ns, message in mcap.topic("/diagnostics"):
        status, = message["status"]
        require(stamp_ns(message) == log_ns, "time")
        told.setdefault(status["name"], []).append((log_ns / 1e9 - START_S, status))
    base = told["base_state"]
    require(all(s["hardware_id"] == "tracer on can0" for _, s in base), "hardware")
    require({"key": "battery [V]", "value": "25.9"} in base[0][1]["values"], base[0][1]["values"])
    levels = [(t, s["level"]) for t, s in base]
    require([level for t, level in levels if 10 <= t < 11] == [2], "an emergency stop is an error", levels)
    require(all(level == 0 for t, level in levels if not 10 <= t < 11), "else all is well")
    # Once a second, and when it changes: the stop puts the seconds anew.
    require(DRIVE_S <= len(base) <= DRIVE_S + 2, "how often", len(base))
    drive = told["tpdo2_joint_status 1"]
    require(len(drive) == 4 * DRIVE_S, "each change", len(drive))
    require(all((s["level"] == 0) == ("operation enabled" in s["message"]) for _, s in drive) and
            {s["level"] for _, s in drive} == {0, 2}, "a drive's fault is an error")
    (at, controller), = told["CAN controller"]
    require(abs(at - 1.234567) < 1e-6 and controller["message"] == "bus off" and controller["level"] == 2 and
            controller["hardware_id"] == "can1", controller)


def check_empty(pipewright, folder):
    """Without a frame, and without a time: a whole file of nothing."""
    for name, text in (("nothing.log", ""), ("timeless.log", "  can0  111   [8]  00 64 00 00 00 00 00 00\n")):
        (folder / name).write_text(text)
        out = folder / (name + ".mcap")
        done = subprocess.run([pipewright, "canlog", str(folder / name), "export", "--mcap", str(out)],
                              capture_output=True, text=True)
        require(done.returncode == 0 and ("no time" in done.stderr) == (text != ""), done.stderr)
        mcap = McapFile(out.read_bytes())
        require(mcap.messages == [] and mcap.channels == {}, name)


def main():
    pipewright, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    frames, truth = drive()
    log, out = folder / "drive.log", folder / "drive.mcap"
    rng = random.Random(2)
    # As candump of two channels writes it: a frame may stand some lines too late.
    late = sorted(range(len(frames)), key=lambda i: i + rng.choice([0, 0, 0, 3.5]))
    log.write_text("".join(line(frames[i]) for i in late))
    done = subprocess.run([pipewright, "canlog", str(log), "export", "--mcap", str(out), "--json"],
                          capture_output=True, text=True)
    require(done.returncode == 0 and done.stderr == "", done.returncode, done.stderr)
    figures = json.loads(done.stdout)
    mcap = McapFile(out.read_bytes())
    require(mcap.profile == "ros2", mcap.profile)
    require(len(mcap.chunks) > 2, "several chunks", len(mcap.chunks))
    require(figures["bytes"] == out.stat().st_size and figures["frames"] == len(frames), figures)
    require({t["topic"]: (t["type"], t["messages"]) for t in figures["topics"]} ==
            {topic: (mcap.schemas[schema][0], sum(m[0] == number for m in mcap.messages))
             for number, (schema, topic, _) in mcap.channels.items()}, figures["topics"])
    check_joints(mcap, "/joint_states", joint_sets(
        frames, 0x180, lambda p: [value * 1e-6 for value in struct.unpack("<ii", p)]))
    check_joints(mcap, "/joint_commands", joint_sets(
        frames, 0x200, lambda p: [None, struct.unpack("<Hi", p)[1] * 1e-6]))
    worst_m, worst_rad = check_odometry(mcap, frames, truth)
    check_commands(mcap, frames)
    check_diagnostics(mcap)
    check_empty(pipewright, folder)
    print(f"mcap_by_spec: {len(frames)} frames, {len(mcap.messages)} messages in {len(mcap.chunks)} chunks; "
          f"/odom at most {1e3 * worst_m:.1f} mm and {1e3 * worst_rad:.1f} mrad off the true drive")


main()
