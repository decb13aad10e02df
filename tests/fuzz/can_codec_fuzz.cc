// SPDX-License-Identifier: MIT
// The codec: any frame, and any message. An input is 24 bytes a frame: its id, flags, length and
// payload, and a number that a signal is to be sent with.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "platform/can/bits.h"
#include "platform/can/cia402_state.h"
#include "platform/can/sdo.h"
#include "tests/fuzz/read_whole_log.h"

namespace pipewright::test {
namespace {

struct Input {
  std::uint32_t id = 0;
  std::uint8_t flags = 0;
  std::uint8_t length = 0;
  std::uint8_t signal = 0;
  std::uint8_t node = 0;
  std::array<std::uint8_t, 8> data{};
  double value = 0;
};
constexpr std::size_t kInputBytes = 24;
static_assert(sizeof(Input) == kInputBytes);

can::Frame FrameOf(const Input& input) {
  return {.id = (input.flags & 1) != 0 ? input.id : input.id & 0x7FF,
          .dlc = input.length,
          .extended = (input.flags & 2) != 0,
          .remote = (input.flags & 4) != 0,
          .error = (input.flags & 8) != 0,
          .data = input.data};
}

/// The payload's bits that signals of the row claim.
template <typename Row>
std::uint64_t Claimed(const Row& row) {
  std::uint64_t bits = 0;
  for (const auto& signal : row.signals) {
    bits |= can::codec_internal::Mask(signal.bits) << signal.start;
  }
  return bits;
}

/// The payload's bytes; those past the frame's length as 0, as a receiver reads them.
std::uint64_t Payload(const can::Frame& frame) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, frame.data.data(), std::min<std::size_t>(frame.dlc, sizeof bytes));
  return bytes;
}

/// What is decoded is encoded to the same bits again.
template <typename Row>
bool DecodeAndEncode(const Row& row, const can::Frame& frame) {
  const auto message = can::Decode(row, frame);
  if (!message.ok()) {
    return false;
  }
  const Result<can::Frame> again = can::Encode(row, *message, can::NodeOf(row.head, frame.id));
  Require(again.ok(), "what is decoded can be encoded");
  Require(again->id == frame.id && again->dlc == row.head.dlc, "it keeps id and length");
  Require(((Payload(*again) ^ Payload(frame)) & Claimed(row)) == 0, "it keeps its bits");
  Require((Payload(*again) & ~Claimed(row)) == 0, "bits that no signal claims are 0");
  return true;
}

/// A signal that is sent comes back to half a bit; one outside its limits is not sent.
template <typename Row>
void EncodeAndDecode(const Row& row, const Input& input) {
  if (row.signals.empty()) {
    return;
  }
  const auto& signal = row.signals[input.signal % row.signals.size()];
  if (signal.field.is_code && !(input.value >= 0 && input.value <= 0x1p32 - 1)) {
    return;  // no code
  }
  typename Row::Message message{};
  signal.field.Set(message, input.value);
  const int node = row.head.max_node > 0 ? 1 + input.node % row.head.max_node : 0;
  const Result<can::Frame> frame = can::Encode(row, message, node);
  const double value = signal.field.Get(message);
  const double half = signal.scale * (0.5 + 1e-6);
  if (!frame.ok()) {
    // Of a message of zeros and one value only that can be at fault.
    Require(!(value >= signal.min && value <= signal.max), "what is within its limits is sent");
    return;
  }
  Require(value >= signal.min - half && value <= signal.max + half, "what is not, is not");
  const auto back = can::Decode(row, *frame);
  Require(back.ok(), "what is sent can be read");
  Require(std::abs(signal.field.Get(*back) - value) <= half, "to half a bit");
}

void Try(const Input& input) {
  const can::Frame frame = FrameOf(input);
  int decoded = 0;
  can::ForEachRow(hil::kLogTable, [&](const auto& row) {
    decoded += DecodeAndEncode(row, frame) ? 1 : 0;
    EncodeAndDecode(row, input);
  });
  Require(decoded <= 1, "a frame has one meaning");
  can::RxCounters counters;
  const Status status =
      can::Dispatch(hil::kLogTable, frame, counters, [](const auto&, const auto&, int) {});
  Require((status == Status::kOk) == (decoded == 1) && counters.accepted == (decoded == 1 ? 1 : 0),
          "a table decodes as its rows do");
  if (frame.dlc <= 8) {
    const int payload = frame.remote ? 0 : 8 * frame.dlc;
    const int bits = can::FrameBits(frame) - payload - (frame.extended ? 67 : 47);
    Require(bits >= 0 && bits <= (payload + (frame.extended ? 54 : 34)) / 4, "stuff bits");
  }
  std::uint32_t words[2] = {};
  std::memcpy(words, input.data.data(), sizeof words);
  const can::Sdo sdo{words[0] & 0xFF, words[0] >> 8 & 0xFFFF, words[0] >> 24, words[1]};
  for (const bool from_server : {false, true}) {
    const can::SdoMeaning meaning = can::Meaning(sdo, from_server);
    Require(meaning.bytes >= 0 && meaning.bytes <= 4, "an SDO carries at most 4 bytes");
  }
  Require(can::Name(can::StateOf(words[0])) != nullptr, "a drive's state has a name");

  hil::LogFrame logged{.id = frame.id,
                       .length = frame.dlc,
                       .extended = frame.extended,
                       .remote = frame.remote,
                       .error = frame.error,
                       .data = {}};
  std::copy(frame.data.begin(), frame.data.end(), logged.data.begin());
  DecodeInWords(logged);
}

}  // namespace
}  // namespace pipewright::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright::test;
  for (; size >= kInputBytes; bytes += kInputBytes, size -= kInputBytes) {
    Input input;
    std::memcpy(&input, bytes, kInputBytes);
    Try(input);
  }
  return 0;
}
