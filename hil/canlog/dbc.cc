// SPDX-License-Identifier: MIT
#include "hil/canlog/dbc.h"

#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <vector>

#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

using can::Direction;
using can::FrameHead;

/// The nodes for which a row has messages; of a row without nodes: 0 alone.
std::vector<int> NodesOf(const FrameHead& head) {
  std::vector<int> nodes;
  if (head.max_node == 0) {
    return {0};
  }
  for (int node = 1; node <= std::min(head.max_node, can::kArmNodes); ++node) {
    nodes.push_back(node);
  }
  if (head.max_node >= can::kHostNode) {
    nodes.push_back(can::kHostNode);
  }
  return nodes;
}

std::string MessageName(const FrameHead& head, int node) {
  return node > 0 ? fmt::format("{}_{}", head.name, node) : std::string(head.name);
}

/// A DBC file counts a big-endian signal's bits from its highest one, within the byte from the
/// lowest: the bit that is the signal's start in both orders of counting.
template <typename Signal>
int StartBit(const Signal& signal, can::ByteOrder order) {
  if (order == can::ByteOrder::kLittleEndian) {
    return signal.start;
  }
  return signal.bits < 8 ? signal.start + signal.bits - 1 : signal.start + 7;
}

/// The sections of the file, each for all messages.
class DbcWriter {
 public:
  explicit DbcWriter(const ControlModes& modes) : modes_(modes) {}

  template <typename Table>
  void AddTable(const Table& table, const char* device, bool by_node) {
    can::ForEachRow(table, [&](const auto& row) {
      for (const int node : NodesOf(row.head)) {
        const std::string sender = by_node && node > 0 && node <= can::kArmNodes
                                       ? fmt::format("{}_{}", device, node)
                                       : device;
        const bool from_host = row.head.direction == Direction::kToDevice || node == can::kHostNode;
        AddMessage(row, node, from_host ? "Host" : sender, from_host ? sender : "Host");
      }
    });
  }

  std::string Text(const std::string& nodes, const std::string& about) const {
    return fmt::format(
        "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {}\n\n{}CM_ \"{}\";\n{}\n"
        "BA_DEF_ \"BusType\" STRING ;\nBA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n"
        "BA_DEF_DEF_ \"BusType\" \"CAN\";\nBA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n{}\n{}",
        nodes, fmt::to_string(messages_), about, fmt::to_string(comments_),
        fmt::to_string(attributes_), fmt::to_string(values_));
  }

 private:
  template <typename... Args>
  static void Print(fmt::memory_buffer& to, fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(to), format, std::forward<Args>(args)...);
  }

  template <typename Row>
  void AddMessage(const Row& row, int node, const std::string& sender,
                  const std::string& receiver) {
    const FrameHead& head = row.head;
    const std::uint32_t id = head.id + static_cast<std::uint32_t>(node);
    Print(messages_, "BO_ {} {}: {} {}\n", id, MessageName(head, node), head.dlc, sender);
    for (const auto& signal : row.signals) {
      Print(messages_, " SG_ {} : {}|{}@{}{} ({:.10g},0) [{:.10g}|{:.10g}] \"{}\" {}\n",
            signal.name, StartBit(signal, head.order), signal.bits,
            head.order == can::ByteOrder::kLittleEndian ? 1 : 0,
            signal.sign == can::Sign::kSigned ? '-' : '+', signal.scale, signal.min, signal.max,
            signal.unit == "1" ? "" : signal.unit, receiver);
      AddNames(id, head.name, signal.name);
    }
    Print(messages_, "\n");
    if (head.also_dlc != head.dlc) {
      Print(comments_, "CM_ BO_ {} \"{} bytes are taken, too.\";\n", id, head.also_dlc);
    }
    if (head.period > Duration::zero()) {
      Print(attributes_, "BA_ \"GenMsgCycleTime\" BO_ {} {};\n", id,
            std::chrono::duration_cast<std::chrono::milliseconds>(head.period).count());
    }
  }

  void AddNames(std::uint32_t id, std::string_view frame, std::string_view signal) {
    if (const auto codes = NamedCodes(frame, signal, modes_); !codes.empty()) {
      Print(values_, "VAL_ {} {}", id, signal);
      for (const CodeName& code : codes) {
        Print(values_, " {} \"{}\"", code.code, code.name);
      }
      Print(values_, " ;\n");
    }
    if (const auto bits = NamedBits(frame, signal); !bits.empty()) {
      Print(comments_, "CM_ SG_ {} {} \"", id, signal);
      for (const CodeName& bit : bits) {
        Print(comments_, "{}bit {}: {}", &bit == bits.data() ? "" : "; ",
              std::countr_zero(bit.code), bit.name);
      }
      Print(comments_, "\";\n");
    }
  }

  const ControlModes& modes_;
  fmt::memory_buffer messages_;
  fmt::memory_buffer comments_;
  fmt::memory_buffer attributes_;
  fmt::memory_buffer values_;
};

}  // namespace

std::string DbcText(DbcDevices devices, const ControlModes& modes) {
  DbcWriter writer(modes);
  std::string nodes = "Host";
  std::string about;
  if (devices != DbcDevices::kArm) {
    writer.AddTable(can::kTracerTable, "Tracer", /*by_node=*/false);
    nodes += " Tracer";
    about += fmt::format("AgileX Tracer, CAN protocol v2, {} bit/s. ", can::kTracerBitrate);
  }
  if (devices != DbcDevices::kTracer) {
    writer.AddTable(can::kArmTable, "UF7", /*by_node=*/true);
    nodes += " UF7";
    for (int node = 1; node <= can::kArmNodes; ++node) {
      nodes += fmt::format(" UF7_{}", node);
    }
    about += fmt::format(
        "UFACTORY 7-joint arm as seven CiA 402 drives, an adaptation of Pipewright's, {} bit/s. ",
        can::kArmBitrate);
  }
  about.pop_back();
  return writer.Text(nodes, about);
}

}  // namespace pipewright::hil
