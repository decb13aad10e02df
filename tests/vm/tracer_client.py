#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""usage: tracer_client.py IFACE

A client of the AgileX Tracer's CAN protocol v2 that knows nothing but the vendor's manual: finds the
base, takes control, drives, reads everything that it tells, and falls silent. Exit code 0: the base
did as the manual says; 1: not, and what.
"""

import math
import struct
import sys
import time

import can

TRACK_M = 0.35
WHEEL_RADIUS_M = 0.0605
STANDBY, CAN_MODE = 0, 1
PERIOD_S = 0.02


class Wrong(Exception):
    pass


def expect(holds, what):
    if not holds:
        raise Wrong(what)


class Base:
    def __init__(self, interface):
        self.bus = can.Bus(interface="socketcan", channel=interface)
        self.last = {}
        self.seen = []

    def send(self, frame_id, data):
        self.bus.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=False))

    def listen(self, seconds, until=None):
        """Frames for that long, or until one makes `until` true; returns that frame's time."""
        end = time.time() + seconds
        while (left := end - time.time()) > 0:
            frame = self.bus.recv(left)
            if frame is None or frame.is_error_frame:
                continue
            self.last[frame.arbitration_id] = bytes(frame.data)
            self.seen.append((frame.timestamp, frame.arbitration_id, bytes(frame.data)))
            if until and until():
                return frame.timestamp
        return None

    def drive(self, v_mps, omega_radps, seconds):
        """Commands at 50 Hz; returns when the last was sent."""
        sent = 0
        for _ in range(round(seconds / PERIOD_S)):
            command = struct.pack(">hhhh", round(1000 * v_mps), round(1000 * omega_radps), 0, 0)
            sent = time.time()
            self.send(0x111, command)
            self.listen(PERIOD_S)
        return sent

    def word(self, frame_id, at=0):
        return struct.unpack_from(">h", self.last[frame_id], at)[0]

    def mode(self):
        return self.last[0x211][1] if 0x211 in self.last else None

    def odometer_mm(self):
        return struct.unpack(">ii", self.last[0x311])


def find(base):
    at = base.listen(5, lambda: 0x221 in base.last or 0x241 in base.last)
    expect(at, "no 0x221 and no 0x241 within 5 s: not protocol v2")
    base.seen.clear()
    base.listen(1.2)
    expect(0x151 not in base.last, "0x151: that is protocol v1")
    expect(base.mode() == STANDBY, f"control mode {base.mode()} before anyone asked")
    for frame_id, per_second in {0x211: 50, 0x221: 50, 0x231: 50, 0x251: 50, 0x252: 50, 0x261: 10,
                                 0x262: 10, 0x311: 50}.items():
        count = sum(1 for _, seen, data in base.seen if seen == frame_id and len(data) == 8) / 1.2
        expect(0.85 * per_second < count < 1.15 * per_second,
               f"0x{frame_id:X} of 8 bytes {count:.1f} times a second, not {per_second}")
    counts = [data[7] for _, seen, data in base.seen if seen == 0x211]
    expect(all((b - a) % 256 == 1 for a, b in zip(counts, counts[1:])), "0x211's count jumps")
    volts = struct.unpack_from(">H", base.last[0x211], 2)[0] / 10
    expect(22.5 < volts < 30, f"battery {volts} V")


def take_control(base):
    """0x421 of one byte, as the manual has it, and of eight, as the SDK sends it."""
    for data, mode in ((b"\x01", CAN_MODE), (b"\x00", STANDBY), (bytes([1] + 7 * [0]), CAN_MODE)):
        base.send(0x421, data)
        expect(base.listen(0.2, lambda: base.mode() == mode), f"0x421 {data.hex()}: no mode {mode}")
    base.send(0x441, b"\x00")
    base.send(0x441, bytes(8))


def light(base):
    base.send(0x121, bytes([1, 3, 40, 0, 0, 0, 0, 0]))
    expect(base.listen(0.2, lambda: base.last[0x231][:3] == bytes([1, 3, 40])), "the light stays off")


def ahead(base):
    base.listen(0.05)
    left_mm, right_mm = base.odometer_mm()
    base.drive(0.3, 0, 0.4)
    base.seen.clear()
    base.drive(0.3, 0, 0.8)
    expect(base.word(0x221) == 300, f"0x221 says {base.word(0x221)} mm/s at 0.3 m/s")
    rpm = 0.3 / WHEEL_RADIUS_M * 60 / (2 * math.pi)
    for motor in (0x251, 0x252):
        expect(abs(base.word(motor) - rpm) <= 1, f"motor {motor:X}: {base.word(motor)} rpm, not {rpm}")
    told = [(at, struct.unpack(">ii", data)) for at, seen, data in base.seen if seen == 0x311]
    (first_s, first_mm), (last_s, last_mm) = told[0], told[-1]
    speed = (last_mm[0] - first_mm[0]) / (last_s - first_s)
    expect(abs(speed / 300 - 1) < 0.02, f"the odometer goes at {speed:.0f} mm/s, not 300")
    expect(last_mm[0] - left_mm == last_mm[1] - right_mm, "it did not drive straight")


def turn(base):
    base.drive(0.0, 0.5, 0.6)
    expect(base.word(0x221, 2) == 500, f"0x221 says {base.word(0x221, 2)} mrad/s at 0.5 rad/s")
    rpm = 0.5 * TRACK_M / 2 / WHEEL_RADIUS_M * 60 / (2 * math.pi)
    expect(abs(abs(base.word(0x251)) - rpm) <= 1 and base.word(0x251) == -base.word(0x252),
           f"on the spot: {base.word(0x251)} and {base.word(0x252)} rpm, not {rpm:.1f} either way")


def fall_silent(base):
    """Without commands for 0.5 s the base stops."""
    last_command = base.drive(0.3, 0, 0.5)
    slower = base.listen(2, lambda: base.word(0x221) < 300)
    expect(slower, "it goes on without commands")
    after = slower - last_command
    expect(0.49 < after < 0.56, f"it begins to stop {after:.3f} s after the last command, not 0.5 s")
    expect(base.listen(1, lambda: base.word(0x221) == 0), "it does not come to rest")
    expect(base.mode() == CAN_MODE, "it has left CAN mode")
    return after


def main():
    base = Base(sys.argv[1])
    find(base)
    take_control(base)
    light(base)
    ahead(base)
    turn(base)
    after = fall_silent(base)
    base.send(0x421, b"\x00")
    expect(base.listen(0.2, lambda: base.mode() == STANDBY), "it stays in CAN mode")
    print(f"tracer: as the manual says; braked {after:.3f} s after the last command")


if __name__ == "__main__":
    try:
        main()
    except Wrong as wrong:
        sys.exit(f"tracer_client: {wrong}")
