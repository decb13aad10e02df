// SPDX-License-Identifier: MIT
#include "hil/cli/program_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "hil/cli/bus_choice.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kFar_m = 100;
constexpr double kMaxSide_m = 10;  ///< of a scenario's workspace and map, too
constexpr double kLongest_s = 1e6;

Json VectorJson(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json BoxJson(const BoxRegion& box) {
  return {{"min_m", VectorJson(box.min_m)}, {"max_m", VectorJson(box.max_m)}};
}

/// Takes values out of a run.json by their paths. The first that is missing or wrong is thrown.
class RunReader {
 public:
  explicit RunReader(const Json& run) : run_(run) {}

  double Number(const char* path, double lo, double hi) const {
    return InRange(At(path), path, lo, hi);
  }
  bool Flag(const char* path) const {
    const Json& value = At(path);
    return value.is_boolean() ? value.get<bool>() : throw Wrong(path, "is not true or false");
  }
  std::string Text(const char* path) const {
    const Json& value = At(path);
    return value.is_string() ? value.get<std::string>() : throw Wrong(path, "is no text");
  }
  std::uint64_t Whole(const char* path) const {
    const Json& value = At(path);
    return value.is_number_unsigned() ? value.get<std::uint64_t>()
                                      : throw Wrong(path, "is no whole number");
  }
  std::vector<double> Numbers(const char* path, std::size_t count, double lo, double hi) const {
    const Json& value = At(path);
    if (!value.is_array() || value.size() != count) {
      throw Wrong(path, fmt::format("is no list of {} numbers", count));
    }
    std::vector<double> numbers;
    for (const Json& one : value) {
      numbers.push_back(InRange(one, path, lo, hi));
    }
    return numbers;
  }
  /// The one of `all` that has this name.
  template <typename Enum, std::size_t n>
  Enum Named(const char* path, const Enum (&all)[n]) const {
    const std::string text = Text(path);
    const auto* const found = std::find_if(std::begin(all), std::end(all),
                                           [&text](Enum one) { return text == Name(one); });
    return found != std::end(all) ? *found : throw Wrong(path, fmt::format("is '{}'", text));
  }
  bool IsNull(const char* path) const { return At(path).is_null(); }
  bool Has(const char* path) const { return run_.contains(Json::json_pointer(path)); }

  static std::runtime_error Wrong(const std::string& path, const std::string& what) {
    std::string key = path.substr(1);
    std::replace(key.begin(), key.end(), '/', '.');
    return std::runtime_error(fmt::format("\"{}\" {}", key, what));
  }

 private:
  const Json& At(const char* path) const {
    return Has(path) ? run_.at(Json::json_pointer(path)) : throw Wrong(path, "is missing");
  }
  static double InRange(const Json& value, const char* path, double lo, double hi) {
    const double number =
        value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(lo <= number && number <= hi)) {
      throw Wrong(path, fmt::format("is not from {} to {}", lo, hi));
    }
    return number;
  }

  const Json& run_;
};

Vector3d VectorOf(const std::vector<double>& numbers) {
  return Eigen::Map<const Vector3d>(numbers.data());
}

BoxRegion Box(const RunReader& run, const std::string& path) {
  BoxRegion box{VectorOf(run.Numbers((path + "/min_m").c_str(), 3, -kFar_m, kFar_m)),
                VectorOf(run.Numbers((path + "/max_m").c_str(), 3, -kFar_m, kFar_m))};
  const Vector3d side_m = box.max_m - box.min_m;
  if (!(side_m.minCoeff() > 0 && side_m.maxCoeff() <= kMaxSide_m)) {
    throw RunReader::Wrong(path, fmt::format("is no box of at most {} m a side", kMaxSide_m));
  }
  return box;
}

StartPose Start(const RunReader& run) {
  StartPose start;
  start.x_m = run.Number("/program/start/x_m", -kFar_m, kFar_m);
  start.y_m = run.Number("/program/start/y_m", -kFar_m, kFar_m);
  start.yaw_rad = run.Number("/program/start/yaw_rad", -kFar_m, kFar_m);
  start.clearance_m = run.Number("/program/start/clearance_m", 0, kMaxSide_m);
  if (!run.IsNull("/program/start/joints_rad")) {
    start.joints_rad = run.Numbers("/program/start/joints_rad", kArmJoints, -kFar_m, kFar_m);
  }
  return start;
}

InspectionOptions Options(const RunReader& run) {
  constexpr PlannerKind kPlanners[] = {PlannerKind::kCfnbv, PlannerKind::kCfnbvPaper};
  InspectionOptions options;
  options.seed = run.Whole("/seed");
  options.planner = run.Named("/planner", kPlanners);
  options.svfi = run.Named("/program/svfi", kSvfiModes);
  options.alpha = run.Number("/program/alpha", 0.5, 0.999999);
  options.joint_risk = run.Flag("/program/joint_risk");
  options.scans_correct = run.Flag("/program/scans_correct");
  options.rate_hz = run.Number("/program/rate_hz", 50, 1000);
  options.bus = run.Text("/program/bus");
  options.time_limit_s = run.Number("/program/time_limit_s", 1, kLongest_s);
  std::string error;
  const BusChoice bus = ParseBus(options.bus, &error);
  if (error.empty()) {
    error = RateError(options.rate_hz, bus.shared);
  }
  return error.empty() ? options : throw std::runtime_error(error);
}

}  // namespace

Json ProgramJson(const Scenario& scenario, const InspectionOptions& options) {
  const StartPose& start = scenario.start;
  return {{"start",
           {{"x_m", start.x_m},
            {"y_m", start.y_m},
            {"yaw_rad", start.yaw_rad},
            {"joints_rad", start.joints_rad.empty() ? Json(nullptr) : Json(start.joints_rad)},
            {"clearance_m", start.clearance_m}}},
          {"workspace", BoxJson(scenario.workspace)},
          {"map", BoxJson(scenario.map)},
          {"svfi", Name(options.svfi)},
          {"alpha", options.alpha},
          {"joint_risk", options.joint_risk},
          {"scans_correct", options.scans_correct},
          {"rate_hz", options.rate_hz},
          {"bus", options.bus},
          {"time_limit_s", options.time_limit_s}};
}

RecordedProgramResult ReadProgram(const Json& json) {
  try {
    const RunReader run(json);
    RecordedProgram program;
    program.scenario.workspace = Box(run, "/program/workspace");
    program.scenario.map = Box(run, "/program/map");
    program.scenario.start = Start(run);
    program.options = Options(run);
    if (run.Has("/interrupted_s") && !run.IsNull("/interrupted_s")) {
      program.interrupted = Time{FromSeconds(run.Number("/interrupted_s", 0, kLongest_s))};
    }
    if (!Valid(program.config().mapping.map)) {
      return {std::nullopt, "\"program.workspace\" is not inside \"program.map\""};
    }
    return {program, ""};
  } catch (const std::runtime_error& wrong) {
    return {std::nullopt, wrong.what()};
  }
}

}  // namespace pipewright::hil
