// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>

namespace pipewright::hil {

/// The SDO abort codes of CiA 301, table 22, that this server sends.
enum class AbortCode : std::uint32_t {
  kNone = 0,
  kCommand = 0x05040001,
  kUnsupportedAccess = 0x06010000,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kNotMappable = 0x06040041,
  kPdoTooLong = 0x06040042,
  kLengthTooHigh = 0x06070012,
  kLengthTooLow = 0x06070013,
  kNoSubindex = 0x06090011,
  kValueRange = 0x06090030,
  kValueTooHigh = 0x06090031,
  kValueTooLow = 0x06090032,
  kDeviceState = 0x08000022,
};

enum class Access : std::uint8_t { kReadOnly, kReadWrite, kWriteOnly };
/// Which PDOs may carry an object.
enum class Mappable : std::uint8_t { kNo, kReceive, kTransmit, kBoth };

/// One entry of up to 4 bytes (the emulated drive has no longer ones).
struct Object {
  int bytes = 4;
  bool is_signed = false;
  Access access = Access::kReadOnly;
  Mappable mappable = Mappable::kNo;
  std::uint32_t value = 0;  ///< the low `bytes` bytes; the rest zero
  std::int64_t min = 0;     ///< of the value as the type reads it
  std::int64_t max = 0xFFFFFFFF;

  std::int64_t Signed() const;  ///< the value as the type reads it
};

/// An entry of this size, sign and starting value, whose limits are the type's.
Object Unsigned(int bytes, Access access, std::uint32_t value, Mappable mappable = Mappable::kNo);
Object Signed(int bytes, Access access, std::int32_t value, Mappable mappable = Mappable::kNo);

/// The object dictionary of one CANopen node: entries by (index, subindex). Pointers to entries
/// stay valid.
class ObjectDictionary {
 public:
  Object& Add(std::uint16_t index, std::uint8_t sub, const Object& object);
  Object* Find(std::uint16_t index, std::uint8_t sub);
  const Object* Find(std::uint16_t index, std::uint8_t sub) const;
  std::uint32_t Value(std::uint16_t index, std::uint8_t sub) const;  ///< 0 when there is none
  void Set(std::uint16_t index, std::uint8_t sub, std::uint32_t value);

  /// Takes over the values of `other` in [first_index, 0xFFFF]; both must have the same entries.
  void TakeValues(const ObjectDictionary& other, std::uint16_t first_index);

  /// Why an access is refused, or kNone. `bytes` 0: the client did not state a size.
  AbortCode CheckRead(std::uint16_t index, std::uint8_t sub) const;
  AbortCode CheckWrite(std::uint16_t index, std::uint8_t sub, int bytes, std::uint32_t value) const;

 private:
  AbortCode CheckExists(std::uint16_t index, std::uint8_t sub) const;

  std::map<std::uint32_t, Object> entries_;  // index << 8 | sub
};

}  // namespace pipewright::hil
