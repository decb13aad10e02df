// SPDX-License-Identifier: MIT
#pragma once

#include "platform/can/table.h"
#include "platform/can/tracer_messages.h"

/// AgileX Tracer, CAN protocol v2: 500 kbit/s, 11-bit ids, high byte first, no checksum.
/// Source: TRACER user manual v1.2 (tables 3.1 to 3.12) and the layouts that the vendor's SDK
/// reads.
namespace pipewright::can {

inline constexpr int kTracerBitrate = 500'000;
/// The base stops when 0x111 stays away this long (manual, table 3.4).
inline constexpr Duration kTracerCommandTimeout = std::chrono::milliseconds(500);

namespace tracer_internal {
using std::chrono_literals::operator""ms;
inline constexpr auto kBig = ByteOrder::kBigEndian;
inline constexpr auto kTo = Direction::kToDevice;
inline constexpr auto kFrom = Direction::kFromDevice;
inline constexpr auto kS = Sign::kSigned;
inline constexpr auto kU = Sign::kUnsigned;
// clang-format off

/// Limits: TRACER 2.0's clamps. Bytes 4 to 7 (lateral, steering) stay 0 on a Tracer.
inline constexpr FrameSpec<BaseTwistCommand, 2> kTwistCommand{
  {"base_twist_command", 0x111, 0, 8, 8, 20ms, kBig, kTo}, {{
  //  name             unit     field                                  start bits sign scale           min          max
    {"v",               "m/s",   kField<&BaseTwistCommand::v_mps>,         0, 16, kS, 1e-3,           -1.8,          1.8},
    {"omega",           "rad/s", kField<&BaseTwistCommand::omega_radps>,  16, 16, kS, 1e-3,           -1.0,          1.0},
}}};

constexpr FrameSpec<BaseLight, 6> Light(const FrameHead& head) {
  return {head, {{
    {"enabled",         "1",     kField<&BaseLight::enabled>,              0,  8, kU, 1.0,               0,            1},
    {"front_mode",      "1",     kField<&BaseLight::front_mode>,           8,  8, kU, 1.0,               0,            3},
    {"front_percent",   "%",     kField<&BaseLight::front_percent>,       16,  8, kU, 1.0,               0,          100},
    {"rear_mode",       "1",     kField<&BaseLight::rear_mode>,           24,  8, kU, 1.0,               0,            3},
    {"rear_percent",    "%",     kField<&BaseLight::rear_percent>,        32,  8, kU, 1.0,               0,          100},
    {"count",           "1",     kField<&BaseLight::count>,               56,  8, kU, 1.0,               0,          255},
  }}};
}

inline constexpr FrameSpec<BaseState, 5> kState{
  {"base_state", 0x211, 0, 8, 8, 20ms, kBig, kFrom}, {{
    {"vehicle_state",   "1",     kField<&BaseState::vehicle_state>,        0,  8, kU, 1.0,               0,            2},
    {"control_mode",    "1",     kField<&BaseState::control_mode>,         8,  8, kU, 1.0,               0,            3},
    {"battery",         "V",     kField<&BaseState::battery_V>,           16, 16, kU, 0.1,               0,       6553.5},
    {"errors",          "1",     kField<&BaseState::errors>,              32, 16, kU, 1.0,               0,        65535},
    {"count",           "1",     kField<&BaseState::count>,               56,  8, kU, 1.0,               0,          255},
}}};

inline constexpr FrameSpec<BaseTwist, 4> kTwist{
  {"base_twist", 0x221, 0, 8, 8, 20ms, kBig, kFrom}, {{
    {"v",               "m/s",   kField<&BaseTwist::v_mps>,                0, 16, kS, 1e-3,        -32.768,       32.767},
    {"omega",           "rad/s", kField<&BaseTwist::omega_radps>,         16, 16, kS, 1e-3,        -32.768,       32.767},
    {"lateral",         "m/s",   kField<&BaseTwist::lateral_mps>,         32, 16, kS, 1e-3,        -32.768,       32.767},
    {"steering",        "rad",   kField<&BaseTwist::steering_rad>,        48, 16, kS, 1e-3,        -32.768,       32.767},
}}};

inline constexpr FrameSpec<BaseRemote, 10> kRemote{
  {"base_remote", 0x241, 0, 8, 8, 20ms, kBig, kFrom}, {{
    {"swa",             "1",     kField<&BaseRemote::swa>,                 0,  2, kU, 1.0,               0,            3},
    {"swb",             "1",     kField<&BaseRemote::swb>,                 2,  2, kU, 1.0,               0,            3},
    {"swc",             "1",     kField<&BaseRemote::swc>,                 4,  2, kU, 1.0,               0,            3},
    {"swd",             "1",     kField<&BaseRemote::swd>,                 6,  2, kU, 1.0,               0,            3},
    {"right_horizontal", "%",     kField<&BaseRemote::right_horizontal>,    8,  8, kS, 1.0,            -100,          100},
    {"right_vertical",  "%",     kField<&BaseRemote::right_vertical>,     16,  8, kS, 1.0,            -100,          100},
    {"left_vertical",   "%",     kField<&BaseRemote::left_vertical>,      24,  8, kS, 1.0,            -100,          100},
    {"left_horizontal", "%",     kField<&BaseRemote::left_horizontal>,    32,  8, kS, 1.0,            -100,          100},
    {"variable_a",      "%",     kField<&BaseRemote::variable_a>,         40,  8, kS, 1.0,            -100,          100},
    {"count",           "1",     kField<&BaseRemote::count>,              56,  8, kU, 1.0,               0,          255},
}}};

inline constexpr FrameSpec<BaseMotorFast, 3> kMotorFast{
  {"base_motor_fast", 0x250, 2, 8, 8, 20ms, kBig, kFrom}, {{
    {"speed",           "rpm",   kField<&BaseMotorFast::speed_rpm>,        0, 16, kS, 1.0,         -0x1p15,   0x1p15 - 1},
    {"current",         "A",     kField<&BaseMotorFast::current_A>,       16, 16, kS, 0.1,         -3276.8,       3276.7},
    {"pulses",          "1",     kField<&BaseMotorFast::pulses>,          32, 32, kS, 1.0,         -0x1p31,   0x1p31 - 1},
}}};

inline constexpr FrameSpec<BaseMotorSlow, 4> kMotorSlow{
  {"base_motor_slow", 0x260, 2, 8, 8, 100ms, kBig, kFrom}, {{
    {"driver_voltage",  "V",     kField<&BaseMotorSlow::driver_V>,         0, 16, kU, 0.1,               0,       6553.5},
    {"driver_temp",     "degC",  kField<&BaseMotorSlow::driver_degC>,     16, 16, kS, 1.0,         -0x1p15,   0x1p15 - 1},
    {"motor_temp",      "degC",  kField<&BaseMotorSlow::motor_degC>,      32,  8, kS, 1.0,            -128,          127},
    {"driver_state",    "1",     kField<&BaseMotorSlow::driver_state>,    40,  8, kU, 1.0,               0,          255},
}}};

inline constexpr FrameSpec<BaseOdometer, 2> kOdometer{
  {"base_odometer", 0x311, 0, 8, 8, 20ms, kBig, kFrom}, {{
    {"left",            "m",     kField<&BaseOdometer::left_m>,            0, 32, kS, 1e-3,   -2147483.648,  2147483.647},
    {"right",           "m",     kField<&BaseOdometer::right_m>,          32, 32, kS, 1e-3,   -2147483.648,  2147483.647},
}}};

inline constexpr FrameSpec<BaseBattery, 5> kBattery{
  {"base_battery", 0x361, 0, 8, 8, 500ms, kBig, kFrom}, {{
    {"charge",          "%",     kField<&BaseBattery::charge_percent>,     0,  8, kU, 1.0,               0,          100},
    {"health",          "%",     kField<&BaseBattery::health_percent>,     8,  8, kU, 1.0,               0,          100},
    {"voltage",         "V",     kField<&BaseBattery::voltage_V>,         16, 16, kU, 0.1,               0,       6553.5},
    {"current",         "A",     kField<&BaseBattery::current_A>,         32, 16, kS, 0.1,         -3276.8,       3276.7},
    {"temperature",     "degC",  kField<&BaseBattery::temperature_degC>,  48, 16, kS, 0.1,         -3276.8,       3276.7},
}}};

inline constexpr FrameSpec<BaseModeRequest, 1> kModeRequest{
  {"base_mode_request", 0x421, 0, 8, 1, {}, kBig, kTo}, {{
    {"mode",            "1",     kField<&BaseModeRequest::mode>,           0,  8, kU, 1.0,               0,            2},
}}};

inline constexpr FrameSpec<BaseErrorReset, 1> kErrorReset{
  {"base_error_reset", 0x441, 0, 8, 1, {}, kBig, kTo}, {{
    {"what",            "1",     kField<&BaseErrorReset::what>,            0,  8, kU, 1.0,               0,            2},
}}};

inline constexpr FrameSpec<BaseVersion, 8> kVersion{
  {"base_version", 0x4A1, 0, 8, 1, {}, kBig, kFrom}, {{
    {"text_1",          "1",     kField<&BaseVersion::text_1>,            0,  8, kU, 1.0,               0,          255},
    {"text_2",          "1",     kField<&BaseVersion::text_2>,            8,  8, kU, 1.0,               0,          255},
    {"text_3",          "1",     kField<&BaseVersion::text_3>,           16,  8, kU, 1.0,               0,          255},
    {"text_4",          "1",     kField<&BaseVersion::text_4>,           24,  8, kU, 1.0,               0,          255},
    {"text_5",          "1",     kField<&BaseVersion::text_5>,           32,  8, kU, 1.0,               0,          255},
    {"text_6",          "1",     kField<&BaseVersion::text_6>,           40,  8, kU, 1.0,               0,          255},
    {"text_7",          "1",     kField<&BaseVersion::text_7>,           48,  8, kU, 1.0,               0,          255},
    {"text_8",          "1",     kField<&BaseVersion::text_8>,           56,  8, kU, 1.0,               0,          255},
}}};

// clang-format on
inline constexpr auto kLightCommand =
    Light({"base_light_command", 0x121, 0, 8, 8, 25ms, kBig, kTo});
inline constexpr auto kLightState = Light({"base_light_state", 0x231, 0, 8, 8, 20ms, kBig, kFrom});
}  // namespace tracer_internal

inline constexpr auto kBaseTwistCommand = tracer_internal::kTwistCommand;
inline constexpr auto kBaseLightCommand = tracer_internal::kLightCommand;
inline constexpr auto kBaseState = tracer_internal::kState;
inline constexpr auto kBaseTwist = tracer_internal::kTwist;
inline constexpr auto kBaseLightState = tracer_internal::kLightState;
inline constexpr auto kBaseRemote = tracer_internal::kRemote;
inline constexpr auto kBaseMotorFast = tracer_internal::kMotorFast;  ///< motors 1, 2: 0x251, 0x252
inline constexpr auto kBaseMotorSlow = tracer_internal::kMotorSlow;  ///< motors 1, 2: 0x261, 0x262
inline constexpr auto kBaseOdometer = tracer_internal::kOdometer;
inline constexpr auto kBaseBattery = tracer_internal::kBattery;
/// The manual gives 0x421 and 0x441 one byte, the vendor's SDK sends eight: both are taken.
inline constexpr auto kBaseModeRequest = tracer_internal::kModeRequest;
inline constexpr auto kBaseErrorReset = tracer_internal::kErrorReset;
/// The vendor's SDK asks for it by a frame of the same id with the one byte 1.
inline constexpr auto kBaseVersion = tracer_internal::kVersion;

/// The whole bus of the base. Driver, emulated base, docs and tests iterate over this.
inline constexpr std::tuple kTracerTable{
    kBaseTwistCommand, kBaseLightCommand, kBaseState,     kBaseTwist,    kBaseLightState,
    kBaseRemote,       kBaseMotorFast,    kBaseMotorSlow, kBaseOdometer, kBaseBattery,
    kBaseModeRequest,  kBaseErrorReset,   kBaseVersion};
static_assert(WellFormed(kTracerTable));

}  // namespace pipewright::can
