// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hil/world/shipped_toml.h"

namespace pipewright::hil {

/// The depth camera's data. Defaults: RealSense D455, 424x240, decimated by 2 on the device.
struct CameraSpec {
  int width = 212;
  int height = 120;
  double hfov_deg = 87;
  double rate_hz = 15;
  double z_min_m = 0.168;  ///< f B / 126: f = 223 px at 424x240, B = 95 mm
  double z_max_m = 6;
  /// sigma(z) = this times z^2 [m, z in m]: s / (f B) with 0.08 px subpixel noise, f = 223 px, B =
  /// 95 mm. Decimation does not lower it: neighbours share most of their matching window.
  double noise_sigma_at_1m = 3.8e-3;
  double invalid_fraction = 0.01;          ///< pixels without reading, anywhere
  double below_min_wrong_fraction = 0.02;  ///< of those nearer than z_min: wrong value, not none
  double lost_fraction = 0;                ///< of the frames: they never come
};

/// What the base's wheels do not tell; see hil/devices/wheel_slip.h.
struct BaseSpec {
  double yaw_scale_slow = 1;
  double yaw_scale_fast = 1;
  double slip = 0;
  double slip_sigma = 0;
};

enum class FaultKind : unsigned char {
  kAbsent,  ///< was never there
  kSilent,  ///< stops answering at at_s
  kSlip,    ///< the base's wheels lose grip at at_s, for for_s
};

struct ScheduledFault {
  std::string device;  ///< "tracer", "arm1" ... "arm7", "camera"
  FaultKind kind = FaultKind::kAbsent;
  double at_s = 0;
  double for_s = 0;  ///< kSlip's, as what follows: the share of its travel that each wheel loses
  double left = 0;
  double right = 0;
};

/// How well the devices do their work in a world, and when they fail.
struct Conditions {
  CameraSpec camera;
  BaseSpec base;
  std::vector<ScheduledFault> faults;
};

/// [camera], [base] and [[fault]], any of them. Keys given replace what `conditions` says, faults
/// are added to its own.
void ReadConditions(TomlTable& root, Conditions& conditions);

/// Lays a text that holds nothing but conditions over those of a scenario.
/// @param origin  the name in error messages
/// @returns everything that is wrong with it, as ParseScenario does; then `conditions` stays as is
std::vector<std::string> LayOver(std::string_view toml, const std::string& origin,
                                 Conditions& conditions);

/// The same with shipped conditions by their name, else a file's.
std::vector<std::string> LayOver(const std::string& name_or_file, Conditions& conditions);

/// What a run under these conditions is called: the shipped name, or the file's without folder and
/// extension.
std::string NameOfConditions(const std::string& name_or_file);

const std::vector<ShippedToml>& ShippedConditions();

}  // namespace pipewright::hil
