// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "platform/can/frame.h"
#include "platform/core/time.h"

/// Devices by their bytes alone: nothing of the tables under test is used here.
namespace pipewright::test {

inline can::Frame Bytes(std::uint32_t id, std::vector<int> bytes) {
  can::Frame frame{.id = id, .dlc = static_cast<std::uint8_t>(bytes.size())};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    frame.data[i] = static_cast<std::uint8_t>(bytes[i]);
  }
  return frame;
}

/// A Tracer that says what its fields hold, 0x211 and 0x221 every 20 ms.
struct FakeBase {
  bool silent = false;
  bool obeys_mode = true;
  int vehicle_state = 0;
  int mode = 0;
  int errors = 0;
  int v_mmps = 0;
  int omega_mradps = 0;
  int commands = 0;

  void OnFrame(const can::Frame& f) {
    if (f.id == 0x421 && obeys_mode) {
      mode = f.data[0];
    } else if (f.id == 0x111 && mode == 1) {
      v_mmps = static_cast<std::int16_t>(f.data[0] << 8 | f.data[1]);
      omega_mradps = static_cast<std::int16_t>(f.data[2] << 8 | f.data[3]);
      ++commands;
    }
  }
  void Step(Time now, std::vector<can::Frame>& out) const {
    if (silent || now.time_since_epoch() % std::chrono::milliseconds(20) != Duration::zero()) {
      return;
    }
    out.push_back(
        Bytes(0x211, {vehicle_state, mode, 0x01, 0x03, errors >> 8, errors & 0xFF, 0, 1}));
    out.push_back(Bytes(0x221, {(v_mmps >> 8) & 0xFF, v_mmps & 0xFF, (omega_mradps >> 8) & 0xFF,
                                omega_mradps & 0xFF, 0, 0, 0, 0}));
    out.push_back(Bytes(0x311, {0xFF, 0xFF, 0xFF, 0xC1, 0, 0, 0, 0x12}));
  }
};

/// A CiA 402 drive that follows at once.
struct FakeDrive {
  int node = 1;
  bool silent = false;
  int abort_index = 0;  ///< SDO requests for this object are refused
  int mute_index = 0;   ///< SDO requests for this object are not answered
  std::uint32_t unit = 0xFA100000;
  int nmt = 0x7F;
  int status = 0x0240;
  int pending_word = 0;
  int word = 0;
  std::int32_t pending_velocity = 0;
  std::int32_t velocity = 0;
  double position = 0;
  bool refuses_enable = false;
  int resets = 0;
  bool has_status_to_tell = false;
  std::map<std::uint32_t, std::uint32_t> written;  ///< index << 8 | subindex
  std::vector<can::Frame> outbox;

  void OnFrame(const can::Frame& f) {
    if (silent) {
      return;
    }
    if (f.id == 0x000 && (f.data[1] == 0 || f.data[1] == node)) {
      nmt = f.data[0] == 0x01 ? 0x05 : f.data[0] == 0x80 ? 0x7F : nmt;
      Say(Bytes(0x700 + node, {nmt}));
      has_status_to_tell = nmt == 0x05;
    } else if (f.id == 0x600U + node) {
      OnSdo(f);
    } else if (f.id == 0x200U + node && nmt == 0x05) {
      pending_word = f.data[0] | f.data[1] << 8;
      pending_velocity = static_cast<std::int32_t>(f.data[2] | f.data[3] << 8 | f.data[4] << 16 |
                                                   static_cast<std::uint32_t>(f.data[5]) << 24);
    } else if (f.id == 0x080 && nmt == 0x05) {
      OnSync();
    }
  }

  void Step(Time now, std::vector<can::Frame>& out) {
    if (!silent && now.time_since_epoch() % std::chrono::milliseconds(100) == Duration::zero()) {
      Say(Bytes(0x700 + node, {nmt}));
    }
    if (has_status_to_tell) {
      Say(Bytes(0x280 + node, {status & 0xFF, status >> 8, 9}));
      has_status_to_tell = false;
    }
    out.insert(out.end(), outbox.begin(), outbox.end());
    outbox.clear();
  }

  void SetStatus(int value) {
    has_status_to_tell = has_status_to_tell || value != status;
    status = value;
  }
  void Say(const can::Frame& f) {
    if (!silent) {
      outbox.push_back(f);
    }
  }

 private:
  void OnSdo(const can::Frame& f) {
    const int index = f.data[1] | f.data[2] << 8;
    const auto answer = [&](int command, std::uint32_t v) {
      Say(Bytes(0x580 + node, {command, f.data[1], f.data[2], f.data[3], static_cast<int>(v & 0xFF),
                               static_cast<int>(v >> 8 & 0xFF), static_cast<int>(v >> 16 & 0xFF),
                               static_cast<int>(v >> 24)}));
    };
    if (index == mute_index) {
      return;
    }
    if (index == abort_index) {
      answer(0x80, 0x06020000);
    } else if (f.data[0] == 0x40) {
      const std::map<int, std::uint32_t> kValues = {
          {0x1000, 0x00020192}, {0x6502, 0x00000180}, {0x60A8, unit}, {0x60A9, 0xFA100300}};
      answer(0x43, kValues.at(index));
    } else {
      const std::uint32_t v = f.data[4] | f.data[5] << 8 | f.data[6] << 16 |
                              static_cast<std::uint32_t>(f.data[7]) << 24;
      written[static_cast<std::uint32_t>(index) << 8 | f.data[3]] = v;
      answer(0x60, 0);
    }
  }
  void OnSync() {
    const int before = word;
    word = pending_word;
    const int state = status & 0x6F;
    if (state == 0x08 && (word & 0x80) != 0 && (before & 0x80) == 0) {
      SetStatus(0x0240);
      ++resets;
    } else if ((state & 0x4F) == 0x40 && word == 0x06) {
      SetStatus(0x0231);
    } else if (state == 0x21 && word == 0x07) {
      SetStatus(0x0233);
    } else if (state == 0x23 && word == 0x0F && !refuses_enable) {
      SetStatus(0x1237);
    } else if (state == 0x27 && (word == 0x02 || word == 0x00)) {
      SetStatus(0x0240);
    }
    velocity = (status & 0x6F) == 0x27 ? pending_velocity : 0;
    position += velocity * 1e-6 * 0.01;
    const auto p = static_cast<std::uint32_t>(static_cast<std::int32_t>(position * 1e6));
    const auto v = static_cast<std::uint32_t>(velocity);
    const auto b = [](std::uint32_t x, int i) { return static_cast<int>(x >> (8 * i) & 0xFF); };
    Say(Bytes(0x180 + node,
              {b(p, 0), b(p, 1), b(p, 2), b(p, 3), b(v, 0), b(v, 1), b(v, 2), b(v, 3)}));
  }
};

}  // namespace pipewright::test
