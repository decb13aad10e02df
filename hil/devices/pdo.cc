// SPDX-License-Identifier: MIT
#include "hil/devices/pdo.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kOff = 1U << 31;
constexpr std::uint32_t kExtended = 1U << 29;
constexpr int kMaxEntries = 8;
constexpr int kMaxBytes = 8;

constexpr std::uint32_t Id(std::uint32_t cob_id) { return cob_id & 0x1FFFFFFF; }

/// Identifiers that CiA 301, table 46 keeps for other services.
constexpr bool Restricted(std::uint32_t id) {
  return id <= 0x080 || (0x101 <= id && id <= 0x180) || (0x581 <= id && id <= 0x5FF) ||
         (0x601 <= id && id <= 0x67F) || (0x6E0 <= id && id <= 0x6FF) || 0x701 <= id;
}

constexpr std::uint16_t IndexOf(std::uint32_t entry) {
  return static_cast<std::uint16_t>(entry >> 16);
}
constexpr std::uint8_t SubOf(std::uint32_t entry) {
  return static_cast<std::uint8_t>((entry >> 8) & 0xFF);
}
constexpr int BitsOf(std::uint32_t entry) { return static_cast<int>(entry & 0xFF); }

}  // namespace

void Pdo::AddTo(ObjectDictionary& dictionary, std::uint32_t cob_id, std::uint8_t type,
                const std::vector<std::uint32_t>& entries, std::uint16_t inhibit,
                std::uint16_t timer_ms) const {
  constexpr Access kRw = Access::kReadWrite;
  dictionary.Add(communication_, 0, Unsigned(1, Access::kReadOnly, 5));
  dictionary.Add(communication_, 1, Unsigned(4, kRw, cob_id));
  dictionary.Add(communication_, 2, Unsigned(1, kRw, type));
  dictionary.Add(communication_, 3, Unsigned(2, kRw, inhibit));
  dictionary.Add(communication_, 5, Unsigned(2, kRw, timer_ms));
  dictionary.Add(mapping_, 0, Unsigned(1, kRw, static_cast<std::uint32_t>(entries.size())));
  for (std::size_t i = 0; i < kMaxEntries; ++i) {
    const std::uint32_t entry = i < entries.size() ? entries[i] : 0;
    dictionary.Add(mapping_, static_cast<std::uint8_t>(i + 1), Unsigned(4, kRw, entry));
  }
}

AbortCode Pdo::CheckWrite(const ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t sub,
                          std::uint32_t value) const {
  const std::uint32_t now = dictionary.Value(communication_, 1);
  const bool on = (now & kOff) == 0;
  if (index == mapping_) {
    return on ? AbortCode::kUnsupportedAccess : CheckMapping(dictionary, sub, value);
  }
  switch (sub) {
    case 1:
      if ((value & kExtended) != 0 || Id(value) > 0x7FF || Restricted(Id(value))) {
        return AbortCode::kValueRange;
      }
      return on && (value & kOff) == 0 && Id(value) != Id(now) ? AbortCode::kUnsupportedAccess
                                                               : AbortCode::kNone;
    case 2: {
      const bool known = value <= 240 || value >= 254;  // 252, 253 answer remote frames: not here
      return known ? AbortCode::kNone : AbortCode::kValueRange;
    }
    case 3:
      return on ? AbortCode::kUnsupportedAccess : AbortCode::kNone;
    default:
      return AbortCode::kNone;
  }
}

AbortCode Pdo::CheckMapping(const ObjectDictionary& dictionary, std::uint8_t sub,
                            std::uint32_t value) const {
  if (sub == 0) {
    if (value > kMaxEntries) {
      return AbortCode::kPdoTooLong;
    }
    int bits = 0;
    for (std::uint32_t i = 1; i <= value; ++i) {
      const std::uint32_t entry = dictionary.Value(mapping_, static_cast<std::uint8_t>(i));
      if (dictionary.Find(IndexOf(entry), SubOf(entry)) == nullptr) {
        return AbortCode::kNotMappable;
      }
      bits += BitsOf(entry);
    }
    return bits > 8 * kMaxBytes ? AbortCode::kPdoTooLong : AbortCode::kNone;
  }
  if (dictionary.Value(mapping_, 0) != 0) {
    return AbortCode::kUnsupportedAccess;
  }
  const Object* object = dictionary.Find(IndexOf(value), SubOf(value));
  if (object == nullptr) {
    return AbortCode::kNoObject;
  }
  const Mappable wanted = transmit_ ? Mappable::kTransmit : Mappable::kReceive;
  const bool fits = object->mappable == Mappable::kBoth || object->mappable == wanted;
  return fits && BitsOf(value) == 8 * object->bytes ? AbortCode::kNone : AbortCode::kNotMappable;
}

void Pdo::Configure(ObjectDictionary& dictionary) {
  const std::uint32_t cob_id = dictionary.Value(communication_, 1);
  enabled_ = (cob_id & kOff) == 0;
  cob_id_ = Id(cob_id);
  type_ = static_cast<int>(dictionary.Value(communication_, 2));
  inhibit_ = std::chrono::microseconds(100) * dictionary.Value(communication_, 3);
  timer_ = std::chrono::milliseconds(dictionary.Value(communication_, 5));
  entries_.clear();
  objects_.clear();
  bytes_ = 0;
  for (std::uint32_t i = 1; i <= dictionary.Value(mapping_, 0); ++i) {
    entries_.push_back(dictionary.Value(mapping_, static_cast<std::uint8_t>(i)));
    objects_.push_back(dictionary.Find(IndexOf(entries_.back()), SubOf(entries_.back())));
    bytes_ += objects_.back()->bytes;
  }
}

std::uint64_t Pdo::Pack() const {
  std::uint64_t payload = 0;
  int shift = 0;
  for (const Object* object : objects_) {
    payload |= static_cast<std::uint64_t>(object->value) << shift;
    shift += 8 * object->bytes;
  }
  return payload;
}

void Pdo::Unpack(std::uint64_t payload) const {
  for (Object* object : objects_) {
    const std::uint64_t mask = (std::uint64_t{1} << (8 * object->bytes)) - 1;
    object->value = static_cast<std::uint32_t>(payload & mask);
    payload >>= 8 * object->bytes;
  }
}

}  // namespace pipewright::hil
