// SPDX-License-Identifier: MIT
#include "hil/devices/cia402_objects.h"

#include <cmath>

#include "platform/can/sdo.h"

namespace pipewright::hil {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kUnit = can::kRadPerUnit;
constexpr auto kRo = Access::kReadOnly;
constexpr auto kRw = Access::kReadWrite;
constexpr std::uint32_t kPdoOff = 1U << 31;
constexpr std::int64_t kDeadlineMax_ms = 1000;

std::uint32_t Units(double value) {
  return static_cast<std::uint32_t>(std::llround(value / kUnit));
}

/// CiA 301: what every node has.
void AddCommunication(ObjectDictionary& od, const Cia402Config& config) {
  const auto node = static_cast<std::uint32_t>(config.node_id);
  od.Add(0x1000, 0, Unsigned(4, kRo, 0x00020192));  // servo drive, CiA 402
  od.Add(0x1001, 0, Unsigned(1, kRo, 0, Mappable::kTransmit));
  od.Add(0x1003, 0, Unsigned(1, kRw, 0)).max = 0;  // writing 0 clears the history
  for (std::uint8_t sub = 1; sub <= 4; ++sub) {
    od.Add(0x1003, sub, Unsigned(4, kRo, 0));
  }
  od.Add(0x1005, 0, Unsigned(4, kRo, can::kSync.head.id));
  od.Add(0x1014, 0, Unsigned(4, kRo, can::kEmergency.head.id + node));
  od.Add(0x1016, 0, Unsigned(1, kRo, 1));
  od.Add(0x1016, 1, Unsigned(4, kRw, 0)).max = 0x7FFFFF;  // node << 16 | ms
  od.Add(0x1017, 0, Unsigned(2, kRw, 100));
  od.Add(0x1018, 0, Unsigned(1, kRo, 4));
  od.Add(0x1018, 1, Unsigned(4, kRo, 0));  // no vendor id: an emulated device
  od.Add(0x1018, 2, Unsigned(4, kRo, 0x55463700));
  od.Add(0x1018, 3, Unsigned(4, kRo, 1));
  od.Add(0x1018, 4, Unsigned(4, kRo, node));
  od.Add(0x1029, 0, Unsigned(1, kRo, 1));
  od.Add(0x1029, 1, Unsigned(1, kRw, 1)).max = 2;  // communication lost: stay operational
  od.Add(0x1200, 0, Unsigned(1, kRo, 2));
  od.Add(0x1200, 1, Unsigned(4, kRo, can::kSdoRequest.head.id + node));
  od.Add(0x1200, 2, Unsigned(4, kRo, can::kSdoResponse.head.id + node));
}

/// CiA 402: the state machine and its options.
void AddControl(ObjectDictionary& od) {
  Object& abort_option = od.Add(0x6007, 0, Signed(2, kRw, 1));
  abort_option.min = 0;
  abort_option.max = 3;
  od.Add(0x603F, 0, Unsigned(2, kRo, 0, Mappable::kTransmit));
  od.Add(0x6040, 0, Unsigned(2, kRw, 0, Mappable::kReceive));
  od.Add(0x6041, 0, Unsigned(2, kRo, 0, Mappable::kTransmit));
  od.Add(0x605A, 0, Signed(2, kRw, 2));
  Object& fault_option = od.Add(0x605E, 0, Signed(2, kRw, 2));
  fault_option.min = fault_option.max = 2;
  od.Add(0x6060, 0, Signed(1, kRw, 0, Mappable::kReceive));
  od.Add(0x6061, 0, Signed(1, kRo, 0, Mappable::kTransmit));
  od.Add(0x6502, 0, Unsigned(4, kRo, can::kSupportsCyclicVelocity));
}

/// CiA 402: motion, in user units of 1e-6 rad.
void AddMotion(ObjectDictionary& od, const Cia402Config& config) {
  od.Add(0x6064, 0, Signed(4, kRo, 0, Mappable::kTransmit));
  od.Add(0x606C, 0, Signed(4, kRo, 0, Mappable::kTransmit));
  od.Add(0x6077, 0, Signed(2, kRo, 0, Mappable::kTransmit));
  od.Add(0x607D, 0, Unsigned(1, kRo, 2));
  // Rounded towards the middle, so that the limit in user units is never beyond the given one.
  od.Add(0x607D, 1, Signed(4, kRw, static_cast<std::int32_t>(std::ceil(config.lower_rad / kUnit))));
  od.Add(0x607D, 2,
         Signed(4, kRw, static_cast<std::int32_t>(std::floor(config.upper_rad / kUnit))));
  const double rpm = config.velocity_max_radps * 60 / (2 * kPi);
  od.Add(0x6080, 0, Unsigned(4, kRw, static_cast<std::uint32_t>(std::lround(rpm))));
  od.Add(0x6085, 0, Unsigned(4, kRw, Units(config.quick_stop_radps2))).min = 1;
  od.Add(0x608F, 0, Unsigned(1, kRo, 2));
  od.Add(0x608F, 1, Unsigned(4, kRo, 6283185));  // increments
  od.Add(0x608F, 2, Unsigned(4, kRo, 1));        // a revolution
  od.Add(0x60A8, 0, Unsigned(4, kRo, can::kUnitMicroRad));
  od.Add(0x60A9, 0, Unsigned(4, kRo, can::kUnitMicroRadPerSecond));
  od.Add(0x60C2, 0, Unsigned(1, kRo, 2));
  od.Add(0x60C2, 1, Unsigned(1, kRw, 10)).min = 1;
  od.Add(0x60C2, 2, Signed(1, kRw, -3));
  od.Add(0x60C5, 0, Unsigned(4, kRw, Units(config.accel_radps2))).min = 1;
  od.Add(0x60FF, 0, Signed(4, kRw, 0, Mappable::kReceive));
}

/// What stops the joint can from here on be made stricter only.
void HoldGuards(ObjectDictionary& od) {
  Object& deadline = *od.Find(0x1400, 5);
  deadline.min = 1;
  deadline.max = kDeadlineMax_ms;
  od.Find(0x6007, 0)->min = 1;
  od.Find(0x607D, 1)->min = od.Find(0x607D, 1)->Signed();
  od.Find(0x607D, 2)->max = od.Find(0x607D, 2)->Signed();
  od.Find(0x6080, 0)->max = od.Value(0x6080, 0);
  od.Find(0x6085, 0)->min = od.Value(0x6085, 0);
}

}  // namespace

bool Cia402Config::Valid() const {
  return 1 <= node_id && node_id <= 127 && lower_rad < upper_rad && lower_rad > -2000 &&
         upper_rad < 2000 && velocity_max_radps > 0 && accel_radps2 > 0 && accel_radps2 < 4000 &&
         quick_stop_radps2 > 0 && quick_stop_radps2 < 4000 && boot_time >= Duration::zero();
}

ObjectDictionary FactoryDictionary(const Cia402Config& config,
                                   const std::vector<ReceivePdo>& receive,
                                   const std::vector<TransmitPdo>& transmit) {
  ObjectDictionary od;
  AddCommunication(od, config);
  AddControl(od);
  AddMotion(od, config);
  const auto node = static_cast<std::uint32_t>(config.node_id);
  const std::uint32_t rpdo = can::kJointCommand.head.id + node;
  const std::uint32_t tpdo = can::kJointFeedback.head.id + node;
  receive[0].pdo.AddTo(od, kPdoOff | rpdo, 255, {0x60400010}, 0, 100);
  receive[1].pdo.AddTo(od, kPdoOff | (rpdo + 0x100), 255, {0x60600008}, 0, 0);
  transmit[0].pdo.AddTo(od, kPdoOff | tpdo, 1, {0x60410010}, 0, 0);
  transmit[1].pdo.AddTo(od, tpdo + 0x100, 255, {0x60410010, 0x60610008}, 100, 250);
  if (!config.host_may_loosen) {
    HoldGuards(od);
  }
  return od;
}

DriveLimits LimitsOf(const ObjectDictionary& od) {
  return {
      .velocity_max_radps = od.Value(0x6080, 0) * 2 * kPi / 60,
      .accel_radps2 = od.Value(0x60C5, 0) * kUnit,
      .quick_stop_radps2 = od.Value(0x6085, 0) * kUnit,
      .lower_rad = static_cast<double>(od.Find(0x607D, 1)->Signed()) * kUnit,
      .upper_rad = static_cast<double>(od.Find(0x607D, 2)->Signed()) * kUnit,
  };
}

}  // namespace pipewright::hil
