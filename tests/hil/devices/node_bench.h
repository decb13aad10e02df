// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "hil/devices/cia402_node.h"

namespace pipewright::hil {

/// A frame from its id and bytes, as a log line gives them.
inline can::Frame Bytes(std::uint32_t id, std::initializer_list<int> data) {
  can::Frame frame{.id = id, .dlc = static_cast<std::uint8_t>(data.size())};
  std::size_t i = 0;
  for (const int byte : data) {
    frame.data[i++] = static_cast<std::uint8_t>(byte);
  }
  return frame;
}

/// One node on a desk: a joint that turns as the drive says, a clock in steps of 1 ms, and a record
/// of everything the node says.
class NodeBench {
 public:
  static constexpr Duration kStep = std::chrono::milliseconds(1);

  explicit NodeBench(const Cia402Config& config = {}) : node(config) {}

  void Tick() {
    now += kStep;
    node.Measure(position_rad);
    for (const can::Frame& frame : inbox) {
      node.OnFrame(frame, now);
    }
    inbox.clear();
    const std::size_t before = said.size();
    node.Step(now, said);
    for (std::size_t i = before; i < said.size(); ++i) {
      said[i].stamp = now;
    }
    position_rad += node.velocity_radps() * ToSeconds(kStep);
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      Tick();
    }
  }
  void Hear(const can::Frame& frame) { inbox.push_back(frame); }

  /// Sends an SDO request and returns the 8 answering bytes.
  std::array<std::uint8_t, 8> Ask(std::initializer_list<int> request) {
    Hear(Bytes(0x601, request));
    const std::size_t before = said.size();
    Tick();
    for (std::size_t i = before; i < said.size(); ++i) {
      if (said[i].id == 0x581) {
        return said[i].data;
      }
    }
    return {};
  }
  /// Writes an entry; true when the node agreed.
  bool Write(int index, int sub, int bytes, std::uint32_t value) {
    const int command = 0x23 | (4 - bytes) << 2;
    const auto b = [value](int i) { return static_cast<int>((value >> (8 * i)) & 0xFF); };
    return Ask({command, index & 0xFF, index >> 8, sub, b(0), b(1), b(2), b(3)})[0] == 0x60;
  }
  std::vector<can::Frame> Said(std::uint32_t id) const {
    std::vector<can::Frame> frames;
    for (const can::Frame& frame : said) {
      if (frame.id == id) {
        frames.push_back(frame);
      }
    }
    return frames;
  }

  /// Boots, maps both PDOs to SYNC, starts the node and enables the drive.
  void Enable() {
    Run(60);
    ASSERT_TRUE(Write(0x1600, 0, 1, 0) && Write(0x1600, 1, 4, 0x60400010) &&
                Write(0x1600, 2, 4, 0x60FF0020) && Write(0x1600, 0, 1, 2) &&
                Write(0x1400, 2, 1, 1) && Write(0x1400, 1, 4, 0x201));
    ASSERT_TRUE(Write(0x1A00, 0, 1, 0) && Write(0x1A00, 1, 4, 0x60640020) &&
                Write(0x1A00, 2, 4, 0x606C0020) && Write(0x1A00, 0, 1, 2) &&
                Write(0x1800, 2, 1, 1) && Write(0x1800, 1, 4, 0x181));
    ASSERT_TRUE(Write(0x6060, 0, 1, 9));
    Hear(Bytes(0x000, {0x01, 0x01}));
    for (const int word : {0x06, 0x07, 0x0F}) {
      Cycle(word, 0);
    }
    ASSERT_EQ(node.drive_state(), DriveState::kOperationEnabled);
  }
  /// One control cycle of 10 ms: RPDO1, SYNC, then time.
  void Cycle(int controlword, std::int32_t velocity) {
    const auto v = static_cast<std::uint32_t>(velocity);
    const auto b = [v](int i) { return static_cast<int>((v >> (8 * i)) & 0xFF); };
    Hear(Bytes(0x201, {controlword & 0xFF, controlword >> 8, b(0), b(1), b(2), b(3)}));
    Hear(Bytes(0x080, {}));
    Run(10);
  }

  Cia402Node node;
  Time now{};
  double position_rad = 0;
  std::vector<can::Frame> inbox;
  std::vector<can::Frame> said;
};

}  // namespace pipewright::hil
