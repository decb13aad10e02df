// SPDX-License-Identifier: MIT
#include "hil/devices/object_dictionary.h"

#include <cassert>

namespace pipewright::hil {
namespace {

std::uint32_t Key(std::uint16_t index, std::uint8_t sub) {
  return static_cast<std::uint32_t>(index) << 8 | sub;
}

std::int64_t Read(const Object& object, std::uint32_t value) {
  const std::int64_t span = std::int64_t{1} << (8 * object.bytes);
  const std::int64_t raw = value & (span - 1);
  return object.is_signed && raw >= span / 2 ? raw - span : raw;
}

}  // namespace

std::int64_t Object::Signed() const { return Read(*this, value); }

Object Unsigned(int bytes, Access access, std::uint32_t value, Mappable mappable) {
  const std::int64_t span = std::int64_t{1} << (8 * bytes);
  return {bytes, false, access, mappable, value, 0, span - 1};
}

Object Signed(int bytes, Access access, std::int32_t value, Mappable mappable) {
  const std::int64_t span = std::int64_t{1} << (8 * bytes);
  const auto raw = static_cast<std::uint32_t>(static_cast<std::int64_t>(value) & (span - 1));
  return {bytes, true, access, mappable, raw, -span / 2, span / 2 - 1};
}

Object& ObjectDictionary::Add(std::uint16_t index, std::uint8_t sub, const Object& object) {
  return entries_.insert_or_assign(Key(index, sub), object).first->second;
}

Object* ObjectDictionary::Find(std::uint16_t index, std::uint8_t sub) {
  const auto found = entries_.find(Key(index, sub));
  return found == entries_.end() ? nullptr : &found->second;
}

const Object* ObjectDictionary::Find(std::uint16_t index, std::uint8_t sub) const {
  const auto found = entries_.find(Key(index, sub));
  return found == entries_.end() ? nullptr : &found->second;
}

std::uint32_t ObjectDictionary::Value(std::uint16_t index, std::uint8_t sub) const {
  const Object* object = Find(index, sub);
  return object == nullptr ? 0 : object->value;
}

void ObjectDictionary::Set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
  Object* object = Find(index, sub);
  assert(object != nullptr);
  const std::int64_t span = std::int64_t{1} << (8 * object->bytes);
  object->value = static_cast<std::uint32_t>(value & (span - 1));
}

void ObjectDictionary::TakeValues(const ObjectDictionary& other, std::uint16_t first_index) {
  for (auto entry = entries_.lower_bound(Key(first_index, 0)); entry != entries_.end(); ++entry) {
    entry->second.value = other.entries_.at(entry->first).value;
  }
}

AbortCode ObjectDictionary::CheckExists(std::uint16_t index, std::uint8_t sub) const {
  if (Find(index, sub) != nullptr) {
    return AbortCode::kNone;
  }
  const auto next = entries_.lower_bound(Key(index, 0));
  const bool has_index = next != entries_.end() && next->first >> 8 == index;
  return has_index ? AbortCode::kNoSubindex : AbortCode::kNoObject;
}

AbortCode ObjectDictionary::CheckRead(std::uint16_t index, std::uint8_t sub) const {
  const AbortCode exists = CheckExists(index, sub);
  if (exists != AbortCode::kNone) {
    return exists;
  }
  return Find(index, sub)->access == Access::kWriteOnly ? AbortCode::kWriteOnly : AbortCode::kNone;
}

AbortCode ObjectDictionary::CheckWrite(std::uint16_t index, std::uint8_t sub, int bytes,
                                       std::uint32_t value) const {
  const AbortCode exists = CheckExists(index, sub);
  if (exists != AbortCode::kNone) {
    return exists;
  }
  const Object& object = *Find(index, sub);
  if (object.access == Access::kReadOnly) {
    return AbortCode::kReadOnly;
  }
  if (bytes > object.bytes) {
    return AbortCode::kLengthTooHigh;
  }
  if (bytes != 0 && bytes < object.bytes) {
    return AbortCode::kLengthTooLow;
  }
  const std::int64_t typed = Read(object, value);
  if (typed > object.max) {
    return AbortCode::kValueTooHigh;
  }
  return typed < object.min ? AbortCode::kValueTooLow : AbortCode::kNone;
}

}  // namespace pipewright::hil
