# SPDX-License-Identifier: MIT
"""`pipewright canlog dbc` read by canmatrix, a library that is not ours: every signal of random
frames is the same number, unit and name by the DBC file as by `pipewright canlog decode`.

usage: dbc_by_canmatrix.py PIPEWRIGHT FOLDER
"""
import csv
import io
import logging
import pathlib
import random
import subprocess
import sys
from decimal import Decimal

logging.disable(logging.CRITICAL)  # canmatrix tells of the formats that it has no library for
import canmatrix.formats  # noqa: E402

FRAMES_OF_EACH = 200
# A DBC file has value tables for codes and none for sets of bits, whose names are in comments.
SETS_OF_BITS = {"errors", "driver_state", "error_register", "statusword"}
# Hex by ours, a number in a DBC file; and codes without a name, likewise.
HEX = {"index"}
HEARTBEATS_LEFT_OUT = {0x700 + node for node in range(8, 127)}


def run(pipewright, *arguments, **more):
    done = subprocess.run([pipewright, "canlog", *arguments], capture_output=True, text=True, **more)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def check(holds, *what):
    if not holds:
        sys.exit(f"dbc_by_canmatrix: {what}")


def raw_limits(signal):
    """The range of what is on the wire, by the limits of the file."""
    return int(signal.min / signal.factor), int(signal.max / signal.factor)


def payloads(message, rng):
    """Anything, and what the file says can be sent, packed by canmatrix; and each named code."""
    for _ in range(FRAMES_OF_EACH):
        yield rng.randbytes(message.size)
        values = {}
        for signal in message.signals:
            low, high = raw_limits(signal)
            values[signal.name] = rng.choice([low, high, rng.randint(low, high)]) * signal.factor
        yield bytes(message.encode(values))
    for signal in message.signals:
        for code in signal.values:
            yield bytes(message.encode({other.name: 0 for other in message.signals} | {signal.name: code}))


def decoded_by_ours(pipewright, folder, frames):
    """[(id, {signal: (value, unit, name)})] of frames that were decoded, by their number as time."""
    log = folder / "frames.log"
    log.write_text("".join(f"({number}.000000) can0 {id:03X}#{data.hex()}\n"
                           for number, (id, data) in enumerate(frames)))
    decoded = {}
    for row in csv.DictReader(io.StringIO(run(pipewright, str(log), "decode", "--csv"))):
        signals = decoded.setdefault(int(float(row["t_s"])), {})
        signals[row["signal"]] = (row["value"], row["unit"], row["name"])
    return decoded


def same_name(signal, raw, ours):
    if signal.name in SETS_OF_BITS:
        return not signal.values and ours != ""
    if signal.name in HEX:
        return not signal.values and ours == f"{raw:04X}h"
    if raw in signal.values:
        return ours == signal.values[raw]
    number = {"", str(raw), f"0x{raw:04X}"} if signal.values else {""}
    return ours in number


def compare(pipewright, folder, options):
    dbc = folder / "bus.dbc"
    dbc.write_text(run(pipewright, "dbc", *options))
    bus = canmatrix.formats.loadp_flat(str(dbc))
    rng = random.Random(1)
    frames = [(message.arbitration_id.id, data) for message in bus.frames if message.signals
              for data in payloads(message, rng)]
    ours = decoded_by_ours(pipewright, folder, frames)
    within = signals_compared = names_compared = 0
    for number, (id, data) in enumerate(frames):
        message = bus.frame_by_id(canmatrix.ArbitrationId(id))
        theirs = message.decode(data)
        in_range = all(raw_limits(value.signal)[0] <= value.raw_value <= raw_limits(value.signal)[1]
                       for value in theirs.values())
        check(in_range == (number in ours), "in its limits by one and not by the other",
              message.name, data.hex())
        if not in_range:
            continue
        within += 1
        check(theirs.keys() == ours[number].keys(), "other signals", message.name)
        for name, value in theirs.items():
            number_by_ours, unit, name_by_ours = ours[number][name]
            # As Decimal both are exact: the file's factor, and the ten digits that are printed.
            check(Decimal(number_by_ours) == value.raw_value * value.signal.factor, message.name,
                  name, data.hex(), number_by_ours, value.phys_value)
            check(unit == (value.signal.unit or ""), "unit", message.name, name, unit)
            check(same_name(value.signal, value.raw_value, name_by_ours), "name", message.name, name,
                  value.raw_value, name_by_ours)
            signals_compared += 1
            names_compared += name_by_ours != ""
    check(within > len(frames) // 2, "too few frames within their limits", within, len(frames))
    print(f"dbc_by_canmatrix {' '.join(options)}: {len(bus.frames)} messages, {len(frames)} frames, "
          f"{within} within their limits, {signals_compared} signals, {names_compared} names")
    return bus


def ids_of_ours(pipewright, folder):
    """The ids that have a row: those whose frames are not passed over."""
    log = folder / "ids.log"
    log.write_text("".join(f"(1.000000) can0 {id:03X}#{'00' * length}\n"
                           for id in range(0x800) for length in range(9)))
    return {int(line.split()[2], 16)
            for line in run(pipewright, str(log), "decode").splitlines() if line}


def main():
    pipewright, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    both = compare(pipewright, folder, [])
    ids = {message.arbitration_id.id for message in both.frames}
    check(ids | HEARTBEATS_LEFT_OUT == ids_of_ours(pipewright, folder), "other ids")
    check(not ids & HEARTBEATS_LEFT_OUT, "heartbeats of nodes that there are not")
    parts = [compare(pipewright, folder, ["--device", device]) for device in ("tracer", "uf7")]
    check(ids == {message.arbitration_id.id for part in parts for message in part.frames},
          "the two files are not the one")
    compare(pipewright, folder, ["--device", "tracer", "--modes", "sdk"])
    tracer1 = subprocess.run([pipewright, "canlog", "dbc", "--modes", "tracer1"], capture_output=True,
                             text=True, check=True).stdout
    check('control_mode 0 "remote control" 1 "CAN" 2 "serial" ;' in tracer1, "modes")
    # Who sends what and how often, by the protocols' own documents.
    by_name = {message.name: message for message in both.frames}
    for name, sender, period_ms in (("base_twist_command", "Host", 20), ("base_state", "Tracer", 20),
                                    ("base_battery", "Tracer", 500), ("sync", "Host", 10),
                                    ("tpdo1_joint_feedback_7", "UF7_7", 10), ("heartbeat_127", "Host", 100),
                                    ("heartbeat_3", "UF7_3", 100), ("sdo_request_2", "Host", 0)):
        check(by_name[name].transmitters == [sender], name, by_name[name].transmitters)
        check(by_name[name].effective_cycle_time == period_ms, name, by_name[name].effective_cycle_time)


main()
