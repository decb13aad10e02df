// SPDX-License-Identifier: MIT
#include "hil/canlog/frame_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/canlog/line_scanner.h"

namespace pipewright::hil {
namespace {

constexpr std::uint32_t kMost11Bits = 0x7FF;
constexpr std::uint32_t kMost29Bits = 0x1FFFFFFF;
constexpr int kShortDigits = 3;
constexpr int kMostDigits = 8;
constexpr double kMostSeconds = 9e9;

}  // namespace

std::string FrameFilter::AddIds(std::string_view text) {
  std::string error;
  while (error.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    error = AddOne(text.substr(0, comma));
    if (comma == text.size()) {
      break;
    }
    text.remove_prefix(comma + 1);
  }
  return error;
}

std::string FrameFilter::AddOne(std::string_view text) {
  by_id_ = true;
  if (text == "error") {
    errors_ = true;
    return "";
  }
  LineScanner in(text);
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  const int digits = in.Hex(kMostDigits, first);
  const bool range = in.Take('-');
  const bool mask = !range && in.Take('/');
  const int more = range || mask ? in.Hex(kMostDigits, second) : digits;
  const bool extended = digits > kShortDigits || (range && more > kShortDigits);
  const std::uint32_t most = extended ? kMost29Bits : kMost11Bits;
  if (digits == 0 || more == 0 || !in.AtEnd() || first > most || (range && second > most) ||
      (range && second < first)) {
    return fmt::format(
        "--id {}: is neither a hex id (211), a range (180-1FF), an id and a mask (180/780), nor "
        "'error'",
        text);
  }
  const auto id = static_cast<std::uint32_t>(first);
  if (mask) {
    const auto ones = static_cast<std::uint32_t>(second);
    Add({0, most, ones, id & ones}, extended);
  } else {
    Add({id, range ? static_cast<std::uint32_t>(second) : id, 0, 0}, extended);
  }
  return "";
}

void FrameFilter::Add(const Rule& rule, bool extended) {
  if (extended) {
    long_ids_.push_back(rule);
    return;
  }
  for (std::uint32_t id = 0; id <= kMost11Bits; ++id) {
    if (rule.Wants(id)) {
      short_ids_.set(id);
    }
  }
}

std::string FrameFilter::SetTime(const std::string& text, const char* option, Bound& bound) {
  bound.absolute = text.starts_with('@');
  const char* const from = text.data() + (bound.absolute ? 1 : 0);
  const char* const end = text.data() + text.size();
  double seconds = 0;
  const auto [stop, error] = std::from_chars(from, end, seconds);
  if (from == end || error != std::errc() || stop != end || !(std::abs(seconds) <= kMostSeconds)) {
    return fmt::format(
        "{} {}: is neither seconds from the log's first frame (12.5) nor, behind an @, seconds of "
        "its clock (@1699000000.5)",
        option, text);
  }
  bound.set = true;
  // By parts: a double has no nanoseconds beside the seconds of a calendar.
  const double whole = std::floor(seconds);
  bound.ns =
      static_cast<std::int64_t>(whole) * 1'000'000'000 + std::llround((seconds - whole) * 1e9);
  return "";
}

bool FrameFilter::WantsId(const LogFrame& frame) const {
  if (frame.error) {
    return errors_;
  }
  if (!frame.extended) {
    return short_ids_[frame.id & kMost11Bits];
  }
  return std::any_of(long_ids_.begin(), long_ids_.end(),
                     [&frame](const Rule& rule) { return rule.Wants(frame.id); });
}

bool FrameFilter::WantsTime(const LogFrame& frame) const {
  const std::int64_t since_first = frame.stamp_ns - first_ns_;
  return frame.stamped &&
         (!from_.set || (from_.absolute ? frame.stamp_ns : since_first) >= from_.ns) &&
         (!to_.set || (to_.absolute ? frame.stamp_ns : since_first) <= to_.ns);
}

std::size_t FrameFilter::Keep(std::span<LogFrame> frames) {
  if (keeps_all()) {
    return frames.size();
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const LogFrame& frame = frames[i];
    if (!begun_ && frame.stamped) {
      begun_ = true;
      first_ns_ = frame.stamp_ns;
    }
    if ((!by_id_ || WantsId(frame)) && ((!from_.set && !to_.set) || WantsTime(frame))) {
      if (kept != i) {
        frames[kept] = frame;
      }
      ++kept;
    }
  }
  return kept;
}

}  // namespace pipewright::hil
