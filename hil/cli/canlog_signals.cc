// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_signals.h"

#include <iterator>

namespace pipewright::hil {

SignalChoice::SignalChoice(const CanlogOptions& options) : chosen_(!options.signals.empty()) {
  for (const std::string& pattern : options.signals) {
    Want(pattern);
  }
  if (!chosen_) {
    Want("*");
  }
}

void SignalChoice::Want(const std::string& pattern) {
  bool meant = false;
  ForEachSignal([&](const SignalPlace& place) {
    if (MeansSignal(pattern, *place.head, place.node, place.name)) {
      wanted_[place.id()].set(place.index);
      meant = true;
    }
  });
  if (!meant && error_.empty()) {
    error_ = fmt::format(
        "--signal {}: means no signal; there are frames such as base_state, signals such as "
        "battery, and paths such as tpdo1_joint_feedback/3/position, with * for any characters",
        pattern);
  }
}

void SignalChoice::Keep(std::uint32_t id, DecodedFrame& frame) const {
  if (!chosen_) {
    return;
  }
  FixedVector<SignalValue, kMostSignals> kept;
  for (int i = 0; i < frame.signals.size(); ++i) {
    if (Wants(id, static_cast<std::size_t>(i))) {
      static_cast<void>(kept.push_back(frame.signals[i]));
    }
  }
  frame.signals = kept;
}

const ControlModes& ControlModesNamed(std::string_view name) {
  return name == "tracer1"   ? can::kModesTracer12
         : name == "tracer2" ? can::kModesTracer20
         : name == "mini"    ? can::kModesMini
                             : can::kModesSdk;
}

void AppendValue(fmt::memory_buffer& to, double value) {
  fmt::format_to(std::back_inserter(to), "{:.10g}", value);
}

std::string CsvCell(std::string_view text) {
  if (text.find_first_of(",\"") == std::string_view::npos) {
    return std::string(text);
  }
  std::string cell = "\"";
  for (const char c : text) {
    cell.append(c == '"' ? 2 : 1, c);
  }
  return cell + "\"";
}

std::string JsonText(std::string_view text) {
  return nlohmann::ordered_json(text).dump(-1, ' ', false,
                                           nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace pipewright::hil
