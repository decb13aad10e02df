// SPDX-License-Identifier: MIT
#include "hil/canlog/error_message.h"

#include <iterator>
#include <string_view>

#include "hil/canlog/code_names.h"

namespace pipewright::hil {
namespace {

struct Bit {
  std::uint32_t mask;
  std::string_view name;
};

// Classes, in the id; then what bytes 1 and 2 add to those of the controller and the protocol.
constexpr Bit kClasses[] = {
    {0x001, "transmit timeout"},
    {0x002, "arbitration lost"},
    {0x004, "controller problem"},
    {0x008, "protocol violation"},
    {0x010, "transceiver"},
    {0x020, "no acknowledge"},
    {0x040, "bus off"},
    {0x080, "bus error"},
    {0x100, "controller restarted"},
    {0x200, "error counters"},
};
constexpr std::uint32_t kController = 0x004;
constexpr std::uint32_t kProtocol = 0x008;
constexpr Bit kControllerBits[] = {
    {0x01, "receive overflow"}, {0x02, "transmit overflow"}, {0x04, "receive warning"},
    {0x08, "transmit warning"}, {0x10, "receive passive"},   {0x20, "transmit passive"},
    {0x40, "active again"},
};
constexpr Bit kProtocolBits[] = {
    {0x01, "single bit"}, {0x02, "form"},     {0x04, "stuff"},        {0x08, "bit 0"},
    {0x10, "bit 1"},      {0x20, "overload"}, {0x40, "active error"}, {0x80, "on transmission"},
};

template <std::size_t n>
void AppendBits(fmt::memory_buffer& to, std::uint32_t bits, const Bit (&names)[n],
                std::string_view before) {
  for (const Bit& bit : names) {
    if ((bits & bit.mask) != 0) {
      AppendText(to, before);
      AppendText(to, bit.name);
      before = ", ";
    }
  }
}

}  // namespace

void AppendErrorMessage(fmt::memory_buffer& to, const LogFrame& frame) {
  const std::size_t begin = to.size();
  for (const Bit& bit : kClasses) {
    if ((frame.id & bit.mask) == 0) {
      continue;
    }
    AppendText(to, to.size() > begin ? "; " : "");
    AppendText(to, bit.name);
    if (bit.mask == kController) {
      AppendBits(to, frame.data[1], kControllerBits, ": ");
    } else if (bit.mask == kProtocol) {
      AppendBits(to, frame.data[2], kProtocolBits, ": ");
    }
  }
  if (to.size() == begin) {
    fmt::format_to(std::back_inserter(to), "unknown class 0x{:X}", frame.id);
  }
}

}  // namespace pipewright::hil
