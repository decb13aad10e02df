#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""usage: canopen_master.py IFACE

A CANopen master that knows nothing but CiA 301 and CiA 402: boots seven drives, maps their PDOs,
enables them, moves them in cyclic synchronous velocity mode, and lets its heartbeat stop. Exit code
0: they did as the standards say; 1: not, and what.
"""

import struct
import sys
import time

import can

NODES = range(1, 8)
MASTER = 0x7F
CYCLE_S = 0.01
MASK_STATE, OPERATION_ENABLED = 0x6F, 0x27
SWITCH_ON_DISABLED, FAULT = (0x4F, 0x40), (0x4F, 0x08)
HEARTBEAT_LOST, RPDO_LOST = 0x8130, 0x8250
UNITS_PER_RAD = 1_000_000


class Wrong(Exception):
    pass


def expect(holds, what):
    if not holds:
        raise Wrong(what)


class Master:
    def __init__(self, interface):
        self.bus = can.Bus(interface="socketcan", channel=interface)
        self.control = {node: 0 for node in NODES}
        self.velocity = {node: 0 for node in NODES}
        self.position, self.speed, self.status, self.mode = {}, {}, {}, {}
        self.sampled = {}
        self.heartbeat, self.answers, self.emergencies = {}, {}, []
        self.beats = True
        self.commands = True
        self.next_beat = 0

    def send(self, cob_id, data=b""):
        self.bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))

    def take(self, frame):
        function, node, data = frame.arbitration_id & 0x780, frame.arbitration_id & 0x7F, bytes(frame.data)
        if node not in NODES or frame.is_error_frame:
            return
        if function == 0x080:
            self.emergencies.append((node, struct.unpack_from("<H", data)[0]))
        elif function == 0x180:
            self.position[node], self.speed[node] = struct.unpack("<ii", data)
            self.sampled[node] = frame.timestamp
        elif function == 0x280:
            self.status[node], self.mode[node] = struct.unpack("<Hb", data)
        elif function == 0x580:
            self.answers[node] = data
        elif function == 0x700:
            self.heartbeat[node] = data[0]

    def listen(self, seconds, until=None):
        end = time.time() + seconds
        while True:
            if until and until():
                return True
            if self.beats and time.time() >= self.next_beat:
                self.next_beat = time.time() + 0.1
                self.send(0x700 + MASTER, b"\x05")
            left = end - time.time()
            if left <= 0:
                return False
            frame = self.bus.recv(min(left, 0.05))
            if frame:
                self.take(frame)

    def cycle(self, seconds, until=None):
        """RPDO1 to all, SYNC, and what comes back, every 10 ms."""
        for _ in range(round(seconds / CYCLE_S)):
            begin = time.time()
            for node in NODES if self.commands else ():
                self.send(0x200 + node, struct.pack("<Hi", self.control[node], self.velocity[node]))
            self.send(0x080)
            self.listen(begin + CYCLE_S - time.time())
            if until and until():
                return True
        return False

    def sdo(self, node, request):
        self.answers.pop(node, None)
        self.send(0x600 + node, request)
        expect(self.listen(0.5, lambda: node in self.answers), f"node {node}: no answer to {request.hex()}")
        answer = self.answers[node]
        expect(answer[1:4] == request[1:4], f"node {node}: {answer.hex()} is no answer to {request.hex()}")
        expect(answer[0] != 0x80, f"node {node}: {request.hex()} aborted, {answer[4:].hex()}")
        return answer

    def read(self, node, index, sub=0):
        answer = self.sdo(node, struct.pack("<BHBI", 0x40, index, sub, 0))
        size = 4 - (answer[0] >> 2 & 3)
        return int.from_bytes(answer[4:4 + size], "little")

    def write(self, node, index, sub, value, size):
        command = 0x23 | (4 - size) << 2
        answer = self.sdo(node, struct.pack("<BHBI", command, index, sub, value))
        expect(answer[0] == 0x60, f"node {node}: {index:04X}h:{sub} not taken: {answer.hex()}")

    def map_pdo(self, node, communication, mapping, cob_id, entries):
        self.write(node, communication, 1, 1 << 31 | cob_id, 4)
        self.write(node, communication, 2, 1, 1)
        self.write(node, mapping, 0, 0, 1)
        for sub, entry in enumerate(entries, 1):
            self.write(node, mapping, sub, entry, 4)
        self.write(node, mapping, 0, len(entries), 1)
        self.write(node, communication, 1, cob_id, 4)

    def in_state(self, state):
        mask, value = state
        return all(self.status.get(node, -1) & mask == value for node in NODES)

    def told(self, code):
        return {node for node, emergency in self.emergencies if emergency == code} == set(NODES)


def boot(master):
    master.send(0x000, bytes([0x81, 0]))
    expect(master.listen(2, lambda: all(master.heartbeat.get(n) == 0 for n in NODES)), "no boot-up from all")
    for node in NODES:
        kind = master.read(node, 0x1000)
        expect(kind & 0xFFFF == 402, f"node {node}: 1000h is {kind:#x}, not profile 402")
        expect(master.read(node, 0x6502) & 1 << 8, f"node {node}: 6502h knows no CSV")


def configure(master):
    for node in NODES:
        master.map_pdo(node, 0x1400, 0x1600, 0x200 + node, [0x60400010, 0x60FF0020])
        master.map_pdo(node, 0x1800, 0x1A00, 0x180 + node, [0x60640020, 0x606C0020])
        master.write(node, 0x1400, 5, 100, 2)
        master.write(node, 0x1017, 0, 100, 2)
        master.write(node, 0x1016, 1, MASTER << 16 | 250, 4)
        master.write(node, 0x6060, 0, 9, 1)
    master.listen(0.3)
    expect(all(master.heartbeat[n] == 0x7F for n in NODES), f"not pre-operational: {master.heartbeat}")
    master.send(0x000, bytes([0x01, 0]))
    expect(master.listen(0.5, lambda: all(master.heartbeat[n] == 5 for n in NODES)), "not operational")


def command(master, word):
    for node in NODES:
        master.control[node] = word


def enable(master):
    for word, value in ((0x06, 0x21), (0x07, 0x23), (0x0F, OPERATION_ENABLED)):
        command(master, word)
        expect(master.cycle(1, lambda: master.in_state((MASK_STATE, value))),
               f"controlword {word:02X}: {master.status}")
    expect(all(master.mode[n] == 9 for n in NODES), f"not in mode 9: {master.mode}")
    expect(master.cycle(0.5, lambda: all(s & 1 << 12 for s in master.status.values())),
           f"does not follow 60FFh: {master.status}")


def move(master):
    for node in NODES:
        master.velocity[node] = UNITS_PER_RAD // 10 * (-1 if node % 2 else 1)
    master.cycle(0.1)
    start, since = dict(master.position), dict(master.sampled)
    master.cycle(1)
    for node in NODES:
        expect(master.speed[node] == master.velocity[node], f"node {node} at {master.speed[node]}e-6 rad/s")
        way = (master.position[node] - start[node]) / (master.sampled[node] - since[node])
        expect(abs(way / master.velocity[node] - 1) < 0.02, f"node {node}: it says {master.speed[node]}e-6 rad/s, and moves at {way:.0f}")
    for node in NODES:
        master.velocity[node] = 0
    master.cycle(0.2)
    expect(all(master.speed[n] == 0 for n in NODES), f"still moving: {master.speed}")
    expect(not master.emergencies, f"EMCY: {master.emergencies}")


def recover(master):
    """From a fault, by a rising bit 7 of the controlword."""
    command(master, 0x00)
    master.cycle(0.05)
    command(master, 0x80)
    expect(master.cycle(1, lambda: master.in_state(SWITCH_ON_DISABLED)), f"fault stays: {master.status}")
    command(master, 0x00)
    master.cycle(0.05)
    master.emergencies.clear()


def lose_commands(master):
    """1400h:5 has passed without an RPDO: a fault and its EMCY."""
    master.commands = False
    expect(master.cycle(1, lambda: master.told(RPDO_LOST)), f"no EMCY 8250h: {master.emergencies}")
    expect(master.cycle(1, lambda: master.in_state(FAULT)), f"no fault: {master.status}")
    master.commands = True


def lose_heartbeat(master):
    master.beats = False
    expect(master.cycle(1, lambda: master.told(HEARTBEAT_LOST)), f"no EMCY 8130h: {master.emergencies}")
    expect(master.listen(1, lambda: master.in_state(FAULT)), f"no fault: {master.status}")
    master.beats = True


def main():
    master = Master(sys.argv[1])
    boot(master)
    configure(master)
    enable(master)
    move(master)
    lose_commands(master)
    print("arm: booted, mapped, enabled, moved; faulted as the standards say when commands")
    master.send(0x000, bytes([0x01, 0]))  # 1029h: the fault may have taken it out of operational
    recover(master)
    enable(master)
    lose_heartbeat(master)
    print("     and when the heartbeat stayed away")


if __name__ == "__main__":
    try:
        main()
    except Wrong as wrong:
        sys.exit(f"canopen_master: {wrong}")
