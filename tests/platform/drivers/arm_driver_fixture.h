// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "platform/drivers/arm_driver.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright::test {

/// The driver and seven drives by their bytes, in cycles of 10 ms.
class ArmDriverTest : public testing::Test {
 protected:
  ArmDriverTest() { Renew(); }

  void Renew() {
    for (int i = 0; i < 7; ++i) {
      drives_[i] = {};
      drives_[i].node = i + 1;
      drives_[i].position = 0.1 * i;
    }
  }
  void Cycle(const ArmVector& velocity = ArmVector::Zero()) {
    now_ += std::chrono::milliseconds(10);
    std::vector<can::Frame> heard;
    for (FakeDrive& drive : drives_) {
      drive.Step(now_, heard);
    }
    for (can::Frame& frame : heard) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    if (driver_.ready()) {
      ASSERT_EQ(driver_.Command(velocity), Status::kOk);
    }
    last_.clear();
    driver_.Step(now_, last_);
    for (const can::Frame& frame : last_) {
      for (FakeDrive& drive : drives_) {
        drive.OnFrame(frame);
      }
    }
  }
  void Cycles(int count, const ArmVector& velocity = ArmVector::Zero()) {
    for (int i = 0; i < count; ++i) {
      Cycle(velocity);
    }
  }
  bool RunUntil(DriverPhase phase, int cycles) {
    for (int i = 0; i < cycles && driver_.phase() != phase; ++i) {
      Cycle();
    }
    return driver_.phase() == phase;
  }

  Time now_{};
  std::array<FakeDrive, 7> drives_;
  ArmDriver driver_;
  TxBatch last_;
};

}  // namespace pipewright::test
