// SPDX-License-Identifier: MIT
// Frames that others sent, in words. That rows and bytes agree is tested in tests/platform/can.
#include "hil/canlog/frame_decoder.h"

#include <gtest/gtest.h>

#include <set>

#include "hil/canlog/candump_lines.h"
#include "hil/canlog/error_message.h"
#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

LogFrame FrameOf(const std::string& text) {
  ChannelNames channels;
  LogFrame frame;
  EXPECT_EQ(ReadCandumpLogLine("(1.000000) can0 " + text, channels, frame).kind,
            LineMeaning::Kind::kFrame)
      << text;
  return frame;
}

std::string Words(const std::string& text, const ControlModes& modes = can::kModesSdk) {
  DecodedFrame decoded;
  const Status status = DecodeFrame(FrameOf(text), decoded);
  if (status != Status::kOk) {
    return Name(status);
  }
  std::string words(decoded.head->name);
  words += decoded.node > 0 ? fmt::format(" {}", decoded.node) : "";
  for (const SignalValue& signal : decoded.signals) {
    fmt::memory_buffer value;
    if (signal.has_name()) {
      signal.append_name(value, static_cast<std::uint32_t>(signal.value), modes);
    } else {
      fmt::format_to(std::back_inserter(value), "{:.10g}", signal.value);
    }
    words += fmt::format(" | {} {}", signal.name, fmt::to_string(value));
    words += signal.unit == "1" ? "" : fmt::format(" {}", signal.unit);
  }
  return words;
}

TEST(DecodeFrame, NamesWhatOthersSent) {
  const struct {
    const char* frame;
    const char* words;
  } cases[] = {
      // captured on real AgileX bases
      {"211#0100010000800000",
       "base_state | vehicle_state emergency stop | control_mode standby | battery 25.6 V | "
       "errors 0x80 | count 0"},
      {"211#00000103000000B1",
       "base_state | vehicle_state normal | control_mode standby | battery 25.9 V | errors none | "
       "count 177"},
      {"311#FFFFFFC100000012", "base_odometer | left -0.063 m | right 0.018 m"},
      // the vendor's SDK
      {"421#0100000000000000", "base_mode_request | mode CAN"},
      {"111#01F4FED400000000", "base_twist_command | v 0.5 m/s | omega -0.3 rad/s"},
      {"4A1#01",
       "base_version | text_1 1 | text_2 0 | text_3 0 | text_4 0 | text_5 0 | text_6 0 | text_7 0 "
       "| "
       "text_8 0"},
      {"4A1#56322E3031202020",
       "base_version | text_1 86 | text_2 50 | text_3 46 | text_4 48 | text_5 49 | text_6 32 | "
       "text_7 32 | text_8 32"},
      // CANopen drives
      {"702#00", "heartbeat 2 | state boot-up"},
      {"77F#05", "heartbeat 127 | state operational"},
      {"082#1081110000000000",
       "emergency 2 | code CAN overrun | error_register generic, communication | vendor 0"},
      {"000#8001", "nmt | command enter pre-operational | node 1"},
      {"000#0100", "nmt | command start | node all"},
      {"080#", "sync"},
      {"601#4041600000000000", "sdo_request 1 | command read | index 6041h | subindex 0 | data 0"},
      {"581#8041600000000206",
       "sdo_response 1 | command abort | index 6041h | subindex 0 | data 100794368"},
      {"207#0F00181FFFFF",
       "rpdo1_joint_command 7 | controlword enable operation | velocity "
       "-0.057576 rad/s"},
      {"207#1F0000000000", "rpdo1_joint_command 7 | controlword 0x001F | velocity 0 rad/s"},
      {"281#370609",
       "tpdo2_joint_status 1 | statusword operation enabled, voltage, remote | mode "
       "cyclic synchronous velocity"},
      {"281#081000", "tpdo2_joint_status 1 | statusword fault, follows command | mode none"},
      // what no row has, or has otherwise
      {"253#0000000700FFFEAA", "unavailable"},
      {"00000211#00000103000000B1", "unavailable"},
      {"211#0000", "malformed"},
      {"211#R", "malformed"},
      {"211#0300010000800000", "out of range"},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(Words(c.frame), c.words) << c.frame;
  }
}

TEST(DecodeFrame, NamesControlModesByTheManualThatIsChosen) {
  const std::string frame = "211#0003010300000000";
  EXPECT_NE(Words(frame).find("control_mode remote control"), std::string::npos);
  EXPECT_NE(Words(frame, can::kModesTracer20).find("control_mode 3"), std::string::npos);
}

TEST(DecodeFrame, HasANameForEveryCodeThatIsAState) {
  // Codes without names must be numbers by nature; a new row's states are to be named.
  std::set<std::string_view> numbers;
  can::ForEachRow(kLogTable, [&](const auto& row) {
    for (const auto& signal : row.signals) {
      if (signal.field.is_code && NamesOf(row.head.name, signal.name) == nullptr) {
        numbers.insert(signal.name);
      }
    }
  });
  EXPECT_EQ(numbers, (std::set<std::string_view>{"count", "data", "subindex", "vendor", "text_1",
                                                 "text_2", "text_3", "text_4", "text_5", "text_6",
                                                 "text_7", "text_8"}));
}

TEST(SignalPath, IsFoundByFrameSignalOrPath) {
  const can::FrameHead& head = can::kJointFeedback.head;
  EXPECT_EQ(SignalPath(head, 3, "position"), "tpdo1_joint_feedback/3/position");
  for (const char* pattern :
       {"position", "tpdo1_joint_feedback", "tpdo1_joint_feedback/3/position", "*", "pos*", "*/3/*",
        "tpdo1*/*/position", "tpdo1_joint_feedback/*"}) {
    EXPECT_TRUE(MeansSignal(pattern, head, 3, "position")) << pattern;
  }
  for (const char* pattern : {"", "velocity", "pos", "position*x",
                              "tpdo1_joint_feedback/2/position", "*/velocity", "/"}) {
    EXPECT_FALSE(MeansSignal(pattern, head, 3, "position")) << pattern;
  }
}

TEST(ErrorMessage, SaysItsClassesAndDetails) {
  const struct {
    const char* frame;
    const char* words;
  } cases[] = {
      {"20000040#0000000000000000", "bus off"},
      {"20000020#0000000000000000", "no acknowledge"},
      {"20000004#000C000000000000", "controller problem: receive warning, transmit warning"},
      {"20000088#0000040000000000", "protocol violation: stuff; bus error"},
      {"20000100#0000000000000000", "controller restarted"},
      {"20010000#0000000000000000", "unknown class 0x10000"},
  };
  for (const auto& c : cases) {
    fmt::memory_buffer words;
    AppendErrorMessage(words, FrameOf(c.frame));
    EXPECT_EQ(fmt::to_string(words), c.words);
  }
}

}  // namespace
}  // namespace pipewright::hil
