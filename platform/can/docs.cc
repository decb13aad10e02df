// SPDX-License-Identifier: MIT
#include "platform/can/docs.h"

#include <cstdio>

#include "platform/can/cia402.h"
#include "platform/can/tracer.h"

namespace pipewright::can {
namespace {

/// snprintf into what is left of a buffer.
class Page {
 public:
  explicit Page(std::span<char> out) : out_(out) {}

  template <typename... Args>
  void Print(const char* format, Args... args) {
    const std::size_t left = out_.size() - used_;
    const int length = std::snprintf(out_.data() + used_, left, format, args...);
    full_ = full_ || length < 0 || static_cast<std::size_t>(length) >= left;
    used_ += full_ ? 0 : static_cast<std::size_t>(length);
  }
  Result<int> Length() const {
    if (full_) {
      return Status::kFull;
    }
    return static_cast<int>(used_);
  }

 private:
  std::span<char> out_;
  std::size_t used_ = 0;
  bool full_ = false;
};

void PrintHead(Page& page, const FrameHead& head) {
  const bool by_node = head.max_node > 0;
  const unsigned first = head.id + (by_node ? 1U : 0U);
  const unsigned last = head.id + static_cast<unsigned>(head.max_node);
  page.Print("\n0x%03X", first);
  if (by_node) {
    page.Print("..0x%03X", last);
  }
  page.Print("  %.*s  %s, %d bytes", static_cast<int>(head.name.size()), head.name.data(),
             head.direction == Direction::kToDevice ? "host to device" : "device to host",
             head.dlc);
  if (head.also_dlc != head.dlc) {
    page.Print(" (%d taken too)", head.also_dlc);
  }
  if (head.period > Duration::zero()) {
    page.Print(", every %g ms", 1e3 * ToSeconds(head.period));
  }
  page.Print("%s",
             head.order == ByteOrder::kBigEndian ? ", high byte first\n" : ", low byte first\n");
}

template <typename Table>
void PrintTable(Page& page, const char* title, const Table& table) {
  page.Print("%s\n", title);
  ForEachRow(table, [&](const auto& row) {
    PrintHead(page, row.head);
    for (const auto& s : row.signals) {
      page.Print("    %-16.*s byte %d bit %d, %2d bits %s  x %-5g %-5.*s  %.10g to %.10g\n",
                 static_cast<int>(s.name.size()), s.name.data(), s.start / 8, s.start % 8, s.bits,
                 s.sign == Sign::kSigned ? "signed  " : "unsigned", s.scale,
                 static_cast<int>(s.unit.size()), s.unit.data(), s.min, s.max);
    }
  });
}

}  // namespace

Result<int> DescribeTables(std::span<char> out) {
  Page page(out);
  PrintTable(page, "AgileX Tracer, CAN protocol v2, 500 kbit/s", kTracerTable);
  PrintTable(
      page,
      "\nArm: seven CiA 402 drives, cyclic synchronous velocity, 1 Mbit/s (an adaptation: the "
      "arm has no public CAN interface)",
      kArmTable);
  return page.Length();
}

}  // namespace pipewright::can
