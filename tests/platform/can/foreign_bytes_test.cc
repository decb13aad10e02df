// SPDX-License-Identifier: MIT
// A round trip cannot see a wrong row, so each row meets bytes that others made: captured frames,
// the vendor's client, another CANopen library, the manuals' layouts.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "platform/can/arm_startup.h"
#include "platform/can/candump.h"
#include "platform/can/cia402_state.h"
#include "platform/can/tracer.h"

namespace pipewright::can {
namespace {

std::vector<Frame> Log(const std::string& name) {
  std::ifstream file(std::string(PIPEWRIGHT_TEST_DATA "/can/") + name);
  std::stringstream text;
  text << file.rdbuf();
  const std::string content = text.str();
  std::vector<Frame> frames;
  CandumpReader reader(content);
  for (Result<CandumpLine> r = reader.Next(); r.status() != Status::kUnavailable;
       r = reader.Next()) {
    EXPECT_TRUE(r.ok()) << name << " line " << reader.line();
    if (r.ok()) {
      frames.push_back(r->frame);
    }
  }
  return frames;
}

Frame Bytes(std::uint32_t id, std::vector<int> bytes) {
  Frame frame{.id = id, .dlc = static_cast<std::uint8_t>(bytes.size())};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    frame.data[i] = static_cast<std::uint8_t>(bytes[i]);
  }
  return frame;
}

TEST(RealBase, FramesSayWhatTheirOwnersReadFromThem) {
  const std::vector<Frame> log = Log("agilex_real_fragments.log");
  ASSERT_EQ(log.size(), 9U);

  const Result<BaseMotorFast> motor1 = Decode(kBaseMotorFast, log[0]);
  ASSERT_TRUE(motor1.ok());
  EXPECT_EQ(motor1->speed_rpm, 0);
  EXPECT_NEAR(motor1->current_A, 1.5, 1e-12);
  EXPECT_EQ(motor1->pulses, 0x54);

  const Result<BaseMotorFast> motor2 = Decode(kBaseMotorFast, log[2]);
  ASSERT_TRUE(motor2.ok());
  EXPECT_NEAR(motor2->current_A, 0.7, 1e-12);
  EXPECT_EQ(motor2->pulses, 0x00FFFB77);

  const Result<BaseTwist> twist = Decode(kBaseTwist, log[3]);
  ASSERT_TRUE(twist.ok());
  EXPECT_EQ(twist->v_mps, 0);
  EXPECT_NEAR(twist->steering_rad, -0.001, 1e-12);

  const Result<BaseOdometer> odometer = Decode(kBaseOdometer, log[4]);
  ASSERT_TRUE(odometer.ok());
  EXPECT_NEAR(odometer->left_m, -0.063, 1e-12);
  EXPECT_NEAR(odometer->right_m, 0.018, 1e-12);

  const Result<BaseState> normal = Decode(kBaseState, log[5]);
  ASSERT_TRUE(normal.ok());
  EXPECT_NEAR(normal->battery_V, 25.9, 1e-12);
  EXPECT_EQ(normal->count, 0xB1U);

  Frame slow = log[6];  // motor 3, which a Tracer has not: the same layout at motor 1's id
  EXPECT_EQ(Decode(kBaseMotorSlow, slow).status(), Status::kMalformed);
  slow.id = 0x261;
  const Result<BaseMotorSlow> motor = Decode(kBaseMotorSlow, slow);
  ASSERT_TRUE(motor.ok());
  EXPECT_NEAR(motor->driver_V, 26.3, 1e-12);
  EXPECT_EQ(motor->driver_degC, 39);
  EXPECT_EQ(motor->motor_degC, -40);
  EXPECT_EQ(motor->driver_state, 0x40U);

  const Result<BaseState> stopped = Decode(kBaseState, log[7]);
  ASSERT_TRUE(stopped.ok());
  EXPECT_EQ(stopped->vehicle_state, static_cast<std::uint32_t>(VehicleState::kEmergencyStop));
  EXPECT_EQ(kModesSdk.Meaning(stopped->control_mode), ControlMode::kStandby);
  EXPECT_NEAR(stopped->battery_V, 25.6, 1e-12);
  EXPECT_EQ(stopped->errors, 0x0080U);

  const Result<BaseRemote> remote = Decode(kBaseRemote, log[8]);
  ASSERT_TRUE(remote.ok());
  EXPECT_EQ(remote->swa, 2U);  // 2: up
  EXPECT_EQ(remote->swb, 2U);
  EXPECT_EQ(remote->swc, 2U);
  EXPECT_EQ(remote->swd, 2U);
  EXPECT_EQ(remote->count, 0x61U);
}

TEST(RealBase, EveryFrameOfTheTableComesBackByteForByte) {
  int seen = 0;
  for (const Frame& frame : Log("agilex_real_fragments.log")) {
    RxCounters counters;
    const Status status = Dispatch(
        kTracerTable, frame, counters,
        [&]<typename Msg>(const FrameHead& head, const Msg& msg, int node) {
          ForEachRow(kTracerTable, [&](const auto& row) {
            if constexpr (std::is_same_v<typename std::decay_t<decltype(row)>::Message, Msg>) {
              if (row.head.id == head.id) {
                EXPECT_EQ(*Encode(row, msg, node), frame);
                ++seen;
              }
            }
          });
        });
    EXPECT_EQ(status == Status::kOk, frame.id != 0x253 && frame.id != 0x263);
  }
  EXPECT_EQ(seen, 7);
}

TEST(VendorsClient, SendsWhatOurEncoderSends) {
  const std::vector<Frame> log = Log("tracer_sdk_client.log");
  ASSERT_EQ(log.size(), 4U);
  EXPECT_EQ(*Encode(kBaseModeRequest, {.mode = 1}), log[0]);
  EXPECT_EQ(*Encode(kBaseTwistCommand, {.v_mps = 0.5}), log[1]);
  EXPECT_EQ(*Encode(kBaseTwistCommand, {.v_mps = 0.5, .omega_radps = -0.3}), log[2]);
  EXPECT_EQ(*Encode(kBaseLightCommand, {.enabled = 1, .front_mode = 3, .front_percent = 40}),
            log[3]);
}

// Rows of which nobody published a capture: the manual's layout, byte by byte.
TEST(Manual, LayoutsOfTheRemainingBaseFrames) {
  EXPECT_EQ(*Encode(kBaseLightState, {.enabled = 1,
                                      .front_mode = 2,
                                      .front_percent = 100,
                                      .rear_mode = 1,
                                      .rear_percent = 7,
                                      .count = 0xFE}),
            Bytes(0x231, {1, 2, 100, 1, 7, 0, 0, 0xFE}));
  const Result<BaseBattery> battery =
      Decode(kBaseBattery, Bytes(0x361, {87, 99, 0x01, 0x03, 0xFF, 0xEC, 0x00, 0xFA}));
  ASSERT_TRUE(battery.ok());
  EXPECT_EQ(battery->charge_percent, 87);
  EXPECT_EQ(battery->health_percent, 99);
  EXPECT_NEAR(battery->voltage_V, 25.9, 1e-12);
  EXPECT_NEAR(battery->current_A, -2.0, 1e-12);
  EXPECT_NEAR(battery->temperature_degC, 25.0, 1e-12);
  EXPECT_EQ(Decode(kBaseModeRequest, Bytes(0x421, {1}))->mode, 1U);
  EXPECT_EQ(Decode(kBaseErrorReset, Bytes(0x441, {2}))->what, 2U);
  EXPECT_EQ(Decode(kBaseErrorReset, Bytes(0x441, {2, 0, 0, 0, 0, 0, 0, 0}))->what, 2U);
}

// ugv_sdk's RequestVersion: it sends the one byte 1, and puts what comes together as characters.
TEST(VendorsClient, AsksForAVersionAndIsToldEightCharactersAFrame) {
  const Result<BaseVersion> told =
      Decode(kBaseVersion, Bytes(0x4A1, {'T', 'R', 'A', 'C', 'E', 'R', ' ', '2'}));
  ASSERT_TRUE(told.ok());
  EXPECT_EQ(told->text_1, U'T');
  EXPECT_EQ(told->text_7, U' ');
  EXPECT_EQ(told->text_8, U'2');
  const Result<BaseVersion> asked = Decode(kBaseVersion, Bytes(0x4A1, {1}));
  ASSERT_TRUE(asked.ok());
  EXPECT_EQ(asked->text_1, 1U);
  EXPECT_EQ(asked->text_2, 0U);
  EXPECT_EQ(asked->text_8, 0U);
}

TEST(CanopenLibrary, ItsStartUpIsUnderstoodAndSaidTheSameWay) {
  RxCounters counters;
  int downloads = 0;
  int uploads = 0;
  for (const Frame& frame : Log("canopen_csv_startup.log")) {
    const auto same = [&]<typename Msg>(const FrameHead& head, const Msg& msg, int node) {
      if constexpr (std::is_same_v<Msg, Sdo>) {
        const bool from_server = head.id == kSdoResponse.head.id;
        const SdoMeaning m = Meaning(msg, from_server);
        EXPECT_EQ(node, 1);
        switch (m.kind) {
          case SdoKind::kUploadRequest:
            EXPECT_EQ(*Encode(kSdoRequest, UploadRequest(m.object), 1), frame);
            break;
          case SdoKind::kDownloadRequest:
            EXPECT_EQ(*Encode(kSdoRequest, DownloadRequest(m.object, m.bytes, m.value), 1), frame);
            ++downloads;
            break;
          case SdoKind::kUploadResponse:
            EXPECT_EQ(*Encode(kSdoResponse, UploadResponse(m.object, m.bytes, m.value), 1), frame);
            ++uploads;
            break;
          case SdoKind::kDownloadResponse:
            EXPECT_EQ(*Encode(kSdoResponse, DownloadResponse(m.object), 1), frame);
            break;
          case SdoKind::kAbort:
          case SdoKind::kOther:
            ADD_FAILURE() << "not expedited: " << frame.id;
        }
      }
    };
    EXPECT_EQ(Dispatch(kArmTable, frame, counters, same), Status::kOk) << frame.id;
  }
  EXPECT_EQ(counters.accepted, 147U);
  EXPECT_EQ(downloads, 21);  // lines with 601#2...
  EXPECT_EQ(uploads, 11);    // lines with 581#4...
}

TEST(CanopenLibrary, ItsFramesCarryTheMeaningThatTheStandardGivesThem) {
  const std::vector<Frame> log = Log("canopen_csv_startup.log");
  EXPECT_EQ(log[0], *Encode(kHeartbeat, {.state = 0x00}, 1));
  EXPECT_EQ(log[10],
            *Encode(kNmt, {.command = static_cast<std::uint32_t>(NmtCommand::kPreOperational),
                           .node = 1}));
  const auto holds = [&](const Frame& frame) {
    return std::find(log.begin(), log.end(), frame) != log.end();
  };
  EXPECT_TRUE(holds(*Encode(kSync, {})));
  EXPECT_TRUE(holds(*Encode(kJointCommand, {.controlword = 0x0F, .velocity_radps = -0.005}, 1)));
  EXPECT_TRUE(holds(*Encode(kJointCommand, {.controlword = 0x0F, .velocity_radps = 0.007}, 1)));
  EXPECT_TRUE(
      holds(*Encode(kNmt, {.command = static_cast<std::uint32_t>(NmtCommand::kStart), .node = 1})));
}

// What our own start-up shares with the recorded one must be the recorded bytes.
TEST(CanopenLibrary, RecordedItsRemappingAsOursGoes) {
  const std::vector<Frame> log = Log("canopen_csv_startup.log");
  int shared = 0;
  for (const StartupStep& step : kArmStartup) {
    if (step.kind != StepKind::kWrite) {
      continue;
    }
    const Frame ours =
        *Encode(kSdoRequest, DownloadRequest(step.object, step.bytes, step.ValueFor(1)), 1);
    shared += std::find(log.begin(), log.end(), ours) != log.end() ? 1 : 0;
  }
  // 1400:1 off and on, 1600:0 = 0, both entries, 1600:0 = 2; the mode and both halves of 60C2.
  // TPDO1: its recorded mapping has the same entries; its COB-ID is another (0x101).
  EXPECT_GE(shared, 11);
}

TEST(CanopenLibrary, RealDriveStatuswordsGiveTheirStates) {
  // A maxon EPOS being enabled, as its owner logged it, and a cyclic-velocity drive following.
  EXPECT_EQ(StateOf(0x0740), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(StateOf(0x0721), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(StateOf(0x0737), DriveState::kOperationEnabled);
  EXPECT_EQ(StateOf(0x0231), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(StateOf(0x0233), DriveState::kSwitchedOn);
  EXPECT_EQ(StateOf(0x1237), DriveState::kOperationEnabled);
  const Result<Emergency> overrun =
      Decode(kEmergency, Bytes(0x082, {0x10, 0x81, 0x11, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(overrun.ok());
  EXPECT_EQ(overrun->code, 0x8110U);  // CAN overrun, from an ingenia drive
  EXPECT_EQ(overrun->error_register, 0x11U);
  const Result<JointStatus> status = Decode(kJointStatus, Bytes(0x283, {0x37, 0x12, 0x09}));
  ASSERT_TRUE(status.ok());
  EXPECT_EQ(status->statusword, 0x1237U);
  EXPECT_EQ(status->mode, kModeCyclicVelocity);
  const Result<JointFeedback> feedback =
      Decode(kJointFeedback, Bytes(0x187, {0x40, 0x42, 0x0F, 0x00, 0xC0, 0xBD, 0xF0, 0xFF}));
  ASSERT_TRUE(feedback.ok());
  EXPECT_NEAR(feedback->position_rad, 1.0, 1e-12);
  EXPECT_NEAR(feedback->velocity_radps, -1.0, 1e-12);
}

}  // namespace
}  // namespace pipewright::can
