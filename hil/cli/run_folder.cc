// SPDX-License-Identifier: MIT
#include "hil/cli/run_folder.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <limits>
#include <system_error>

#include "hil/replay/depth_recording.h"
#include "perception/octomap/octomap_file.h"
#include "platform/can/candump.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTraceHead =
    "t_s,phase,goal,goal_state,error,x_m,y_m,phi_rad,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,"
    "q7_rad,v_mps,w_radps,qd1_radps,qd2_radps,qd3_radps,qd4_radps,qd5_radps,qd6_radps,qd7_radps,"
    "true_x_m,true_y_m,true_phi_rad,clear_plane_m,clear_pipe_m,clear_self_m,contacts,est_plane_m,"
    "est_pipe_m,est_self_m,est_obstacle_m,rows,chance_rows,qp_iterations,free,occupied,unknown,"
    "covered\n";

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

void Append(fmt::memory_buffer& line, double value) {
  fmt::format_to(std::back_inserter(line), ",{:.6f}", value);
}

}  // namespace

std::string RunFolder::Open(const fs::path& folder, const nlohmann::ordered_json& head,
                            bool record_depth) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    return fmt::format("{}: is not a folder", folder.string());
  }
  if (fs::is_directory(folder, error) && !fs::is_empty(folder, error) &&
      !fs::exists(folder / "run.json", error)) {
    return fmt::format("{}: holds files that are not a run's; choose another --out",
                       folder.string());
  }
  fs::create_directories(folder, error);
  if (error) {
    return fmt::format("{}: {}", folder.string(), error.message());
  }
  folder_ = folder;
  Text("run.json", head.dump(2) + "\n");  // first: by it the folder is known as a run's
  for (const char* old : {"map.bt", "map.ot", "report.html", kDepthFileName}) {
    fs::remove(folder / old, error);
  }
  trace_.open(folder / "trace.csv", std::ios::binary);
  can_.open(folder / "can.log", std::ios::binary);
  plan_.open(folder / "plan.jsonl", std::ios::binary);
  const bool depth = !record_depth || depth_.Open(folder / kDepthFileName);
  if (!trace_ || !can_ || !plan_ || !depth) {
    return fmt::format("{}: cannot write there", folder.string());
  }
  trace_ << kTraceHead;
  return failed_;
}

void RunFolder::Trace(const ControlReport& report, const Plant* plant, const Clearance* truth,
                      const MapCounts& counts) {
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{:.3f},{},{},{}", ToSeconds(report.now),
                 static_cast<int>(report.phase), report.progress.id,
                 static_cast<int>(report.progress.state));
  Append(line, report.progress.error);
  for (const double q : report.state.q) {
    Append(line, q);
  }
  for (const double u : report.sent) {
    Append(line, u);
  }
  const BasePose base = plant != nullptr ? plant->base() : BasePose{kUnknown, kUnknown, kUnknown};
  for (const double x : {base.x_m, base.y_m, base.yaw_rad}) {
    Append(line, x);
  }
  if (truth != nullptr) {
    for (const double x :
         {truth->plane.distance_m, truth->pipe.distance_m, truth->self.distance_m}) {
      Append(line, x);
    }
    fmt::format_to(std::back_inserter(line), ",{}", truth->contacts);
  } else {
    fmt::format_to(std::back_inserter(line), ",nan,nan,nan,nan");
  }
  for (const double x : {report.stats.clearance.plane_m, report.stats.clearance.pipe_m,
                         report.stats.clearance.self_m, report.stats.clearance.obstacle_m}) {
    Append(line, x);
  }
  fmt::format_to(std::back_inserter(line), ",{},{},{},{},{},{},{}\n", report.stats.rows,
                 report.stats.chance_rows, report.stats.qp.iterations, counts.free, counts.occupied,
                 counts.unknown, counts.covered);
  trace_.write(line.data(), static_cast<std::streamsize>(line.size()));
}

void RunFolder::Can(const can::Frame& frame, std::string_view interface) {
  std::array<char, can::kCandumpLineBytes> line;
  const Result<int> length = can::FormatCandump(frame, interface, line);
  if (length.ok()) {
    can_.write(line.data(), *length);
  }
}

void RunFolder::Depth(const DepthFrame& frame, Time given) {
  if (depth_.is_open()) {
    depth_.Add(frame, given);
  }
}

void RunFolder::Plan(const nlohmann::ordered_json& step) { plan_ << step.dump() << '\n'; }

void RunFolder::Text(const char* name, const std::string& text) {
  // Written beside and moved into place: a reader never sees half a file.
  const fs::path path = folder_ / name;
  const fs::path part = folder_ / (std::string(name) + ".part");
  std::ofstream file(part, std::ios::binary);
  file << text;
  file.close();
  std::error_code error;
  if (file) {
    fs::rename(part, path, error);
  }
  if (!file || error) {
    failed_ = fmt::format("{}: cannot be written", path.string());
  }
}

void RunFolder::Map(const VoxelGrid& map) {
  const std::string bt = (folder_ / "map.bt").string();
  const std::string ot = (folder_ / "map.ot").string();
  if (WriteBt(map, bt) != Status::kOk || WriteOt(map, ot) != Status::kOk) {
    failed_ = fmt::format("{}, {}: cannot be written", bt, ot);
  }
}

std::string RunFolder::Close() {
  bool whole = !depth_.is_open() || depth_.Close();
  for (std::ofstream* file : {&trace_, &can_, &plan_}) {
    file->close();
    whole = whole && file->good();
  }
  if (!whole) {
    failed_ = fmt::format("{}: a file could not be written whole", folder_.string());
  }
  return failed_;
}

}  // namespace pipewright::hil
