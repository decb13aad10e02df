// SPDX-License-Identifier: MIT
#include "hil/world/conditions.h"

#include <filesystem>
#include <set>

#include "embedded/RoughToml.h"
#include "platform/toml/toml_table.h"

namespace pipewright::hil {
namespace {

void ReadCamera(TomlTable& table, CameraSpec& c) {
  c.width = table.Integer("width", 16, 848, c.width);
  c.height = table.Integer("height", 16, 480, c.height);
  c.hfov_deg = table.Number("hfov_deg", 10, 150, c.hfov_deg);
  c.rate_hz = table.Number("rate_hz", 0.1, 100, c.rate_hz);
  c.z_min_m = table.Number("z_min_m", 0, 10, c.z_min_m);
  c.z_max_m = table.Number("z_max_m", 0.1, 65, c.z_max_m);
  c.noise_sigma_at_1m = table.Number("noise_sigma_at_1m", 0, 0.1, c.noise_sigma_at_1m);
  c.invalid_fraction = table.Number("invalid_fraction", 0, 1, c.invalid_fraction);
  c.below_min_wrong_fraction =
      table.Number("below_min_wrong_fraction", 0, 1, c.below_min_wrong_fraction);
  c.lost_fraction = table.Number("lost_fraction", 0, 0.95, c.lost_fraction);
  if (c.z_max_m <= c.z_min_m) {
    table.Error("z_max_m", "must be greater than z_min_m");
  }
  table.Finish();
}

void ReadBase(TomlTable& table, BaseSpec& b) {
  b.yaw_scale_slow = table.Number("yaw_scale_slow", 0.5, 2, b.yaw_scale_slow);
  b.yaw_scale_fast = table.Number("yaw_scale_fast", 0.5, 2, b.yaw_scale_fast);
  b.slip = table.Number("slip", 0, 1, b.slip);
  b.slip_sigma = table.Number("slip_sigma", 0, 1, b.slip_sigma);
  table.Finish();
}

FaultKind ReadFaultKind(TomlTable& table, const std::string& device) {
  const std::string kind = table.Text("kind");
  if (kind == "slip" && device != "tracer") {
    table.Error("kind", "only the tracer can slip");
  } else if (kind != "absent" && kind != "silent" && kind != "slip") {
    table.Error("kind", "must be absent, silent or slip");
  }
  return kind == "silent" ? FaultKind::kSilent
         : kind == "slip" ? FaultKind::kSlip
                          : FaultKind::kAbsent;
}

void ReadFaults(TomlTable& root, std::vector<ScheduledFault>& faults) {
  static const std::set<std::string> kDevices = {"tracer", "arm1", "arm2", "arm3",  "arm4",
                                                 "arm5",   "arm6", "arm7", "camera"};
  for (TomlTable& table : root.Tables("fault")) {
    ScheduledFault fault;
    fault.device = table.Text("device");
    if (!kDevices.contains(fault.device)) {
      table.Error("device", "must be tracer, arm1 ... arm7 or camera");
    }
    fault.kind = ReadFaultKind(table, fault.device);
    fault.at_s = table.Number("at_s", 0, 1e6, 0.0);
    if (fault.kind == FaultKind::kAbsent && fault.at_s != 0) {
      table.Error("at_s", "an absent device was never there: at_s is for silent ones");
    }
    if (fault.kind == FaultKind::kSlip) {
      fault.for_s = table.Number("for_s", 0, 1e6);
      fault.left = table.Number("left", 0, 1, 0.0);
      fault.right = table.Number("right", 0, 1, 0.0);
    }
    table.Finish();
    faults.push_back(fault);
  }
}

}  // namespace

void ReadConditions(TomlTable& root, Conditions& conditions) {
  if (auto table = root.Table("camera", false)) {
    ReadCamera(*table, conditions.camera);
  }
  if (auto table = root.Table("base", false)) {
    ReadBase(*table, conditions.base);
  }
  ReadFaults(root, conditions.faults);
}

std::vector<std::string> LayOver(std::string_view toml, const std::string& origin,
                                 Conditions& conditions) {
  std::vector<std::string> errors;
  ReadToml(toml, origin, errors, [&](TomlTable& root) {
    Conditions changed = conditions;
    ReadConditions(root, changed);
    root.Finish();
    if (errors.empty()) {
      conditions = std::move(changed);
    }
  });
  return errors;
}

std::vector<std::string> LayOver(const std::string& name_or_file, Conditions& conditions) {
  std::vector<std::string> errors;
  const auto source = FindToml(name_or_file, ShippedConditions(), "shipped faults", errors);
  return source ? LayOver(source->text, name_or_file, conditions) : errors;
}

std::string NameOfConditions(const std::string& name_or_file) {
  return std::filesystem::path(name_or_file).stem().string();
}

const std::vector<ShippedToml>& ShippedConditions() {
  static const std::vector<ShippedToml> kShipped = {{"rough", embedded::RoughToml()}};
  return kShipped;
}

}  // namespace pipewright::hil
