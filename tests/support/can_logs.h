// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <string>
#include <vector>

#include "hil/canlog/log_frame.h"
#include "platform/core/rng.h"

/// CAN logs in every format, written after the formats' own descriptions by other code than reads
/// them.
namespace pipewright::test {

using hil::LogFrame;

inline LogFrame DataFrame(std::uint32_t id, const std::vector<int>& payload,
                          std::int64_t stamp_ns = 0) {
  LogFrame frame;
  frame.data.fill(0);
  frame.id = id;
  frame.stamp_ns = stamp_ns;
  frame.stamped = true;
  frame.length = static_cast<std::uint8_t>(payload.size());
  for (std::size_t i = 0; i < payload.size(); ++i) {
    frame.data[i] = static_cast<std::uint8_t>(payload[i]);
  }
  return frame;
}

/// One of each kind, 1 ms and a bit apart.
inline std::vector<LogFrame> OneOfEach() {
  std::vector<LogFrame> all;
  all.push_back(DataFrame(0x123, {0xDE, 0xAD, 0xBE, 0xEF}));
  all.push_back(DataFrame(0x7FF, {}));
  all.push_back(DataFrame(0x000, {1, 2, 3, 4, 5, 6, 7, 8}));
  all.push_back(DataFrame(0x1ABCDEF0, {0x80}));
  all.back().extended = true;
  all.push_back(DataFrame(0x001, {9}));
  all.back().extended = true;
  all.push_back(DataFrame(0x321, {0, 0, 0}));
  all.back().remote = true;
  all.push_back(DataFrame(0x80, {0, 0, 0, 0, 0, 0, 0, 0}));
  all.back().error = true;
  std::vector<int> most(64);
  for (int i = 0; i < 64; ++i) {
    most[static_cast<std::size_t>(i)] = 255 - i;
  }
  all.push_back(DataFrame(0x456, most));
  all.back().fd = all.back().bitrate_switch = true;
  all.push_back(DataFrame(0x12345678, {7, 6, 5, 4, 3, 2, 1, 0, 15, 14, 13, 12}));
  all.back().fd = all.back().extended = all.back().error_passive = true;
  all.push_back(DataFrame(0x100, {}));
  all.back().fd = true;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].stamp_ns = 1'699'000'000'000'000'000 + static_cast<std::int64_t>(i) * 1'002'003'000;
  }
  return all;
}

/// Classic frames of a few ids at odd times, as a bus gives them.
inline std::vector<LogFrame> RandomFrames(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<LogFrame> all;
  std::int64_t ns = 1'700'000'000'000'000'000;
  for (int i = 0; i < count; ++i) {
    ns += 1000 * rng.Index(3000);
    std::vector<int> payload(static_cast<std::size_t>(rng.Index(9)));
    for (int& byte : payload) {
      byte = rng.Index(256);
    }
    all.push_back(DataFrame(static_cast<std::uint32_t>(0x100 + rng.Index(12)), payload, ns));
    all.back().extended = rng.Index(4) == 0;
  }
  return all;
}

inline std::string HexBytes(const LogFrame& f, const char* between, const char* format = "{:02X}") {
  std::string text;
  for (int i = 0; i < f.payload_bytes(); ++i) {
    text += i == 0 ? "" : between;
    text += fmt::format(fmt::runtime(format), f.data[static_cast<std::size_t>(i)]);
  }
  return text;
}

inline std::string CanUtilsId(const LogFrame& f) {
  return f.error      ? fmt::format("{:08X}", f.id | 0x20000000)
         : f.extended ? fmt::format("{:08X}", f.id)
                      : fmt::format("{:03X}", f.id);
}

inline std::string Decimals(std::int64_t ns, int places) {
  const std::string nine = fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
  return nine.substr(0, nine.size() - static_cast<std::size_t>(9 - places));
}

inline std::string CandumpLog(const std::vector<LogFrame>& frames, int places = 6) {
  std::string text;
  for (const LogFrame& f : frames) {
    const int flags = (f.bitrate_switch ? 1 : 0) + (f.error_passive ? 2 : 0);
    text += fmt::format("({}) can0 {}#{}{}{}\n", Decimals(f.stamp_ns, places), CanUtilsId(f),
                        f.remote ? fmt::format("R{}", f.length) : "",
                        f.fd ? fmt::format("#{}", flags) : "", HexBytes(f, ""));
  }
  return text;
}

/// `stamp`: a, z, d as candump -t has them; '\0': no times.
inline std::string CandumpText(const std::vector<LogFrame>& frames, char stamp = 'a') {
  std::string text;
  std::int64_t before = frames.empty() ? 0 : frames[0].stamp_ns;
  for (const LogFrame& f : frames) {
    const std::int64_t ns = stamp == 'a' ? f.stamp_ns : f.stamp_ns - before;
    before = stamp == 'd' ? f.stamp_ns : before;
    text += stamp == '\0' ? "" : fmt::format(" ({})", Decimals(ns, 6));
    // -x, which alone tells the flags of CAN FD
    text += fmt::format("  can0  RX {} {}  {}  ", f.bitrate_switch ? 'B' : '-',
                        f.error_passive ? 'E' : '-', CanUtilsId(f));
    text += fmt::format(fmt::runtime(f.fd ? "[{:02}]  " : " [{}]  "), f.length);
    text += f.remote ? "remote request" : HexBytes(f, " ");
    text += f.error ? "   ERRORFRAME\n\tbus-error\n" : "\n";
  }
  return text;
}

inline std::string AscText(const std::vector<LogFrame>& frames, bool hex = true,
                           bool relative = false) {
  const char* const byte = hex ? "{:02X}" : "{}";
  std::string text = fmt::format(
      "date Fri Nov 3 09:26:40.000 am 2023\nbase {}  timestamps {}\ninternal events logged\n"
      "// version 9.0.0\nBegin Triggerblock Fri Nov 3 09:26:40.000 am 2023\n"
      "   0.000000 Start of measurement\n",
      hex ? "hex" : "dec", relative ? "relative" : "absolute");
  std::int64_t before = 0;
  for (const LogFrame& f : frames) {
    const std::string stamp = Decimals(relative ? f.stamp_ns - before : f.stamp_ns, 6);
    before = f.stamp_ns;
    const std::string id =
        fmt::format(fmt::runtime(hex ? "{:X}{}" : "{}{}"), f.id, f.extended ? "x" : "");
    if (f.error) {
      text += fmt::format("   {} 1  ErrorFrame     ECC: 10100010\n", stamp);
    } else if (f.fd) {
      text += fmt::format(
          "   {} CANFD   1 Rx        {}  {:31}  {} {} {:x} {} {}   102203  133 {:8x} e0006659\n",
          stamp, id, f.extended ? "A_Name" : "", f.bitrate_switch ? 1 : 0, f.error_passive ? 1 : 0,
          f.length <= 8    ? f.length
          : f.length == 64 ? 15
                           : 9,
          f.length, HexBytes(f, " ", byte), 0x1000 | (f.bitrate_switch ? 0x2000 : 0));
    } else if (f.remote) {
      text += fmt::format("   {} 1  {}             Rx   r {}\n", stamp, id, f.length);
    } else {
      text += fmt::format("   {} 1  {:15} Rx   d {} {}  Length = 240015 BitCount = 124 ID = {}\n",
                          stamp, id, f.length, HexBytes(f, " ", byte), f.id);
    }
  }
  return text + "End TriggerBlock\n";
}

/// Numbers of either byte order, behind each other.
class CaptureBytes {
 public:
  explicit CaptureBytes(bool big) : big_(big) {}

  CaptureBytes& Put(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      text += static_cast<char>(value >> 8 * (big_ ? bytes - 1 - i : i) & 0xFF);
    }
    return *this;
  }
  CaptureBytes& Text(const std::string& bytes) {
    text += bytes;
    text.resize((text.size() + 3) / 4 * 4, '\0');
    return *this;
  }
  std::string text;

 private:
  bool big_;
};

inline std::string SocketCanPacket(const LogFrame& f) {
  CaptureBytes packet(/*big=*/true);
  packet.Put(f.id | (f.error ? 0x20000000U : 0) | (f.extended ? 0x80000000U : 0) |
                 (f.remote ? 0x40000000U : 0),
             4);
  packet.Put(f.length, 1);
  packet.Put((f.fd ? 4U : 0) | (f.bitrate_switch ? 1U : 0) | (f.error_passive ? 2U : 0), 1);
  packet.Put(0, 2);
  for (int i = 0; i < (f.fd ? 64 : 8); ++i) {
    packet.Put(i < f.payload_bytes() ? f.data[static_cast<std::size_t>(i)] : 0, 1);
  }
  return packet.text;
}

inline std::string Pcap(const std::vector<LogFrame>& frames, bool big, bool ns) {
  CaptureBytes file(big);
  file.Put(ns ? 0xA1B23C4D : 0xA1B2C3D4, 4).Put(2, 2).Put(4, 2).Put(0, 8).Put(65535, 4).Put(227, 4);
  for (const LogFrame& f : frames) {
    const std::string packet = SocketCanPacket(f);
    file.Put(static_cast<std::uint64_t>(f.stamp_ns / 1'000'000'000), 4);
    file.Put(static_cast<std::uint64_t>(f.stamp_ns % 1'000'000'000 / (ns ? 1 : 1000)), 4);
    file.Put(packet.size(), 4).Put(packet.size(), 4).text += packet;
  }
  return file.text;
}

inline std::string PcapngBlock(bool big, std::uint32_t type, const std::string& content) {
  CaptureBytes block(big);
  block.Put(type, 4).Put(content.size() + 12, 4).Text(content).Put(content.size() + 12, 4);
  return block.text;
}

/// A section with one interface, "can0"; times in ns or µs.
inline std::string Pcapng(const std::vector<LogFrame>& frames, bool big, bool ns) {
  CaptureBytes section(big);
  section.Put(0x1A2B3C4D, 4).Put(1, 2).Put(0, 2).Put(~std::uint64_t{0}, 8);
  CaptureBytes interface(big);
  interface.Put(227, 2).Put(0, 2).Put(0, 4).Put(2, 2).Put(4, 2).Text("can0");
  if (ns) {
    interface.Put(9, 2).Put(1, 2).Text(std::string(1, '\x09'));
  }
  interface.Put(0, 4);
  std::string file = PcapngBlock(big, 0x0A0D0D0A, section.text) +  //
                     PcapngBlock(big, 1, interface.text);
  for (const LogFrame& f : frames) {
    const std::string bytes = SocketCanPacket(f);
    const auto time = static_cast<std::uint64_t>(f.stamp_ns / (ns ? 1 : 1000));
    CaptureBytes packet(big);
    packet.Put(0, 4).Put(time >> 32, 4).Put(time & 0xFFFFFFFF, 4);
    packet.Put(bytes.size(), 4).Put(bytes.size(), 4).Text(bytes);
    packet.Put(2, 2).Put(4, 2).Put(1, 4).Put(0, 4);  // flags: inbound; end of options
    file += PcapngBlock(big, 6, packet.text);
  }
  return file;
}

inline std::string Gz(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

inline std::string Zstd(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3));
  return packed;
}

struct NamedLog {
  std::string name;
  std::string bytes;
};

/// The same frames in every format and byte order.
inline std::vector<NamedLog> InEveryFormat(const std::vector<LogFrame>& frames) {
  return {
      {"candump -L", CandumpLog(frames)},
      {"candump -L, ns", CandumpLog(frames, 9)},
      {"candump -t a", CandumpText(frames)},
      {"ASC hex", AscText(frames)},
      {"ASC dec", AscText(frames, false)},
      {"ASC relative", AscText(frames, true, true)},
      {"pcap little us", Pcap(frames, false, false)},
      {"pcap big us", Pcap(frames, true, false)},
      {"pcap little ns", Pcap(frames, false, true)},
      {"pcap big ns", Pcap(frames, true, true)},
      {"pcapng little us", Pcapng(frames, false, false)},
      {"pcapng big us", Pcapng(frames, true, false)},
      {"pcapng little ns", Pcapng(frames, false, true)},
      {"pcapng big ns", Pcapng(frames, true, true)},
  };
}

}  // namespace pipewright::test
