# SPDX-License-Identifier: MIT
"""Reads MCAP files of ROS 2 messages after the specifications (mcap.dev/spec, version 0; OMG
DDS-XTYPES for CDR; ROS 2's interface definitions), by none of the code that writes ours. Strict:
what a file says of itself must all be so."""
import re
import struct
import zlib

import zstandard

MAGIC = b"\x89MCAP0\r\n"
RULE = "=" * 80


def require(holds, *what):
    if not holds:
        raise AssertionError(what)


class Fields:
    """Takes a record's content from its front."""

    def __init__(self, content):
        self.rest = memoryview(content)

    def take(self, form):
        values = struct.unpack_from("<" + form, self.rest)
        self.rest = self.rest[struct.calcsize("<" + form):]
        return values if len(values) > 1 else values[0]

    def bytes(self, count):
        require(count <= len(self.rest), "a field that ends behind its record")
        taken, self.rest = bytes(self.rest[:count]), self.rest[count:]
        return taken

    def text(self):
        return self.bytes(self.take("I")).decode()

    def pairs(self, form):
        inner = Fields(self.bytes(self.take("I")))
        pairs = []
        while inner.rest:
            pairs.append(inner.take(form))
        return pairs

    def end(self):
        require(not self.rest, "a record that is longer than its fields")


def records(data, begin, end):
    """(place, place behind it, opcode, content) of each record in data[begin:end]."""
    while begin < end:
        op, length = struct.unpack_from("<BQ", data, begin)
        require(begin + 9 + length <= end, "a record that ends behind its section", begin)
        yield begin, begin + 9 + length, op, data[begin + 9:begin + 9 + length]
        begin += 9 + length


class McapFile:
    """profile, schemas {id: (name, encoding, text)}, channels {id: (schema, topic, encoding)},
    messages [(channel, sequence, log time, publish time, data)] in the order of the file, chunks."""

    def __init__(self, data):
        self.schemas, self.channels, self.messages, self.chunks = {}, {}, [], []
        require(data[:8] == MAGIC and data[-8:] == MAGIC, "magic")
        op, length = struct.unpack_from("<BQ", data, len(data) - 8 - 29)
        require((op, length) == (0x02, 20), "footer")
        summary, offsets, summary_crc = struct.unpack_from("<QQI", data, len(data) - 8 - 20)
        require(zlib.crc32(data[summary:len(data) - 8 - 4]) == summary_crc, "summary's checksum")
        self.read_data(data, summary)
        self.read_summary(data, summary, offsets)

    def read_data(self, data, end):
        found = list(records(data, 8, end))
        require(found[0][2] == 0x01, "header first")
        header = Fields(found[0][3])
        self.profile, self.library = header.text(), header.text()
        header.end()
        require(found[-1][2] == 0x0F, "data end last")
        require(zlib.crc32(data[:found[-1][0]]) == struct.unpack("<I", found[-1][3])[0], "data's checksum")
        for begin, behind, op, content in found[1:-1]:
            require(op in (0x06, 0x07), "chunks and their indexes alone", op)
            if op == 0x06:
                self.read_chunk(begin, behind, content)
            else:
                self.read_message_index(begin, behind, content)
        for chunk in self.chunks:
            require(not chunk["not indexed"], "messages without an index")

    def read_chunk(self, begin, behind, content):
        f = Fields(content)
        first, last, plain_bytes, crc, packing = *f.take("QQQI"), f.text()
        packed = f.bytes(f.take("Q"))
        f.end()
        require(packing == "zstd", packing)
        plain = zstandard.ZstdDecompressor().decompress(packed, max_output_size=plain_bytes)
        require(len(plain) == plain_bytes and zlib.crc32(plain) == crc, "chunk's checksum")
        times, places = [], {}
        for at, _, op, inner in records(plain, 0, len(plain)):
            if op == 0x03:
                self.add_schema(inner, self.schemas)
            elif op == 0x04:
                self.add_channel(inner, self.channels)
            else:
                require(op == 0x05, "schemas, channels and messages in a chunk", op)
                g = Fields(inner)
                channel, sequence, log, publish = g.take("HIQQ")
                require(channel in self.channels, "a channel before its messages")
                times.append(log)
                places.setdefault(channel, []).append((log, at))
                self.messages.append((channel, sequence, log, publish, bytes(g.rest)))
        require((first, last) == ((min(times), max(times)) if times else (0, 0)), "chunk's times")
        self.chunks.append({"begin": begin, "bytes": behind - begin, "times": (first, last),
                            "sizes": (len(packed), plain_bytes), "not indexed": places, "indexes": [],
                            "index bytes": 0})

    def read_message_index(self, begin, behind, content):
        f = Fields(content)
        channel, pairs = f.take("H"), f.pairs("QQ")
        f.end()
        chunk = self.chunks[-1]
        require(sorted(chunk["not indexed"].pop(channel)) == pairs, "index of messages")
        chunk["indexes"].append((channel, begin))
        chunk["index bytes"] += behind - begin

    def add_schema(self, content, to):
        f = Fields(content)
        number = f.take("H")
        require(number != 0 and number not in to, "schema's number", number)
        to[number] = f.text(), f.text(), f.text()
        f.end()

    def add_channel(self, content, to):
        f = Fields(content)
        number, schema, topic, encoding = *f.take("HH"), f.text(), f.text()
        require(f.pairs("II") == [] and number not in to, "channel", topic)
        require(schema in self.schemas, "a schema before its channels")
        to[number] = schema, topic, encoding
        f.end()

    def read_summary(self, data, begin, offsets):
        schemas, channels, chunks, groups, statistics = {}, {}, [], {}, []
        for at, behind, op, content in records(data, begin, offsets):
            groups[op] = (groups.get(op, (at, 0))[0], behind)
            f = Fields(content)
            if op == 0x03:
                self.add_schema(content, schemas)
            elif op == 0x04:
                self.add_channel(content, channels)
            elif op == 0x0B:
                statistics.append((*f.take("QHIIIIQQ"), dict(f.pairs("HQ"))))
                f.end()
            else:
                require(op == 0x08, "summary", op)
                first, last, place, length = f.take("QQQQ")
                indexes, index_bytes, packing = f.pairs("HQ"), f.take("Q"), f.text()
                chunks.append((first, last, place, length, indexes, index_bytes, packing, *f.take("QQ")))
                f.end()
        require(schemas == self.schemas and channels == self.channels, "the summary's schemas, channels")
        require(chunks == [(*c["times"], c["begin"], c["bytes"], c["indexes"], c["index bytes"], "zstd",
                            *c["sizes"]) for c in self.chunks], "index of chunks")
        of_channel = {number: 0 for number in channels}
        for message in self.messages:
            require(message[1] == of_channel[message[0]], "sequence")
            of_channel[message[0]] += 1
        times = [message[2] for message in self.messages] or [0]
        require(statistics == [(len(self.messages), len(schemas), len(channels), 0, 0, len(chunks),
                                min(times), max(times), of_channel)], "statistics", statistics)
        told = [Fields(content).take("BQQ")
                for _, _, op, content in records(data, offsets, len(data) - 8 - 29) if op == 0x0E]
        require(told == [(op, at, behind - at) for op, (at, behind) in sorted(groups.items(), key=lambda g: g[1])],
                "offsets of the summary", told)

    def topic(self, topic):
        """[(log time, decoded message)] of a topic."""
        numbers = [n for n, channel in self.channels.items() if channel[1] == topic]
        require(len(numbers) == 1, "topics of the name", topic, len(numbers))
        schema, _, encoding = self.channels[numbers[0]]
        require(encoding == "cdr" and self.schemas[schema][1] == "ros2msg", "encodings")
        kind = RosType(*self.schemas[schema][::2])
        return [(m[2], kind.decode(m[4])) for m in self.messages if m[0] == numbers[0]]


class RosType:
    """A message type by its definition in text; what it decodes are dicts."""

    SIZES = {"bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H",
             "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}

    def __init__(self, name, text):
        parts = text.split(RULE + "\n")
        self.types = {"": self.fields(parts[0])}
        for part in parts[1:]:
            head, body = part.split("\n", 1)
            require(head.startswith("MSG: "), "a part's head", head)
            self.types[head[5:]] = self.fields(body)
        self.name = name

    @staticmethod
    def fields(text):
        fields = []
        for line in text.splitlines():
            if line and "=" not in line:
                kind, name = line.split()
                base, array = re.fullmatch(r"([\w/]+)(\[\d*\])?", kind).groups()
                fields.append((name, base, array))
        return fields

    def decode(self, data):
        require(data[:4] == b"\0\1\0\0", "CDR's encapsulation")
        self.data, self.at = data[4:], 0
        message = self.take("")
        require(self.at == len(self.data), "a message that is longer than its type", self.name)
        return message

    def number(self, form):
        size = struct.calcsize(form)
        self.at += -self.at % size
        value, = struct.unpack_from("<" + form, self.data, self.at)
        self.at += size
        return value

    def bytes(self, count):
        taken = self.data[self.at:self.at + count]
        require(len(taken) == count, "an array's end")
        self.at += count
        return taken

    def take(self, kind):
        if kind in self.SIZES:
            return self.number(self.SIZES[kind])
        if kind == "string":
            length = self.number("I")
            text = self.data[self.at:self.at + length]
            require(len(text) == length and text[-1:] == b"\0", "a string's end")
            self.at += length
            return text[:-1].decode()
        message = {}
        for name, base, array in self.types[kind]:
            if array is None:
                message[name] = self.take(base)
            else:
                count = int(array[1:-1]) if array != "[]" else self.number("I")
                message[name] = self.bytes(count) if base == "uint8" else [self.take(base) for _ in range(count)]
        return message
