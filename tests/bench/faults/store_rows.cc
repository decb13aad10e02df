// SPDX-License-Identifier: MIT
// F12 and F14 to F16: stores that are full, logs and configurations that are damaged, cycles that
// would take memory.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "ctrl/daemon/config.h"
#include "hil/canlog/log_reader.h"
#include "hil/world/scenario.h"
#include "perception/map/voxel_grid.h"
#include "perception/primitives/tracker.h"
#include "plan/gain/surface.h"
#include "plan/motion/motion_planner.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"
#include "tests/plan/motion/cell.h"
#include "tests/support/can_logs.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

/// Points of a room with a post, seen from its middle.
std::vector<Vector3f> RoomPoints(Rng& rng) {
  std::vector<Vector3f> points;
  for (int i = 0; i < 2000; ++i) {
    Vector3f p(static_cast<float>(rng.Uniform(-1.5, 1.5)),
               static_cast<float>(rng.Uniform(-1.5, 1.5)),
               static_cast<float>(rng.Uniform(-1.5, 1.5)));
    p(rng.Index(3)) = rng.Index(2) == 0 ? -1.5F : 1.5F;
    points.push_back(p);
  }
  return points;
}

MapConfig Room(int bricks) {
  MapConfig config;
  config.lo = config.workspace_lo = {-32, -32, -32};
  config.hi = config.workspace_hi = {31, 31, 31};
  config.brick_capacity = bricks == 0 ? BricksOfBox(config) : bricks;
  return config;
}

/// A map with few bricks beside one with all, fed the same: each voxel that the small one knows is
/// as the large one has it, and what it does not know was counted.
Outcome FullMap(Rng& rng, std::string& why) {
  const int bricks = 1 + rng.Index(200);
  VoxelGrid small(Room(bricks));
  VoxelGrid large(Room(0));
  for (int scan = 0; scan < 3; ++scan) {
    const std::vector<Vector3f> points = RoomPoints(rng);
    const Vector3f from(0, 0, 0.1F * static_cast<float>(scan));
    small.InsertScan(points.data(), static_cast<int>(points.size()), from, -1);
    large.InsertScan(points.data(), static_cast<int>(points.size()), from, -1);
  }
  int known = 0;
  int missing = 0;
  const MapConfig& c = small.config();
  for (VoxelIndex v = c.lo; v.x <= c.hi.x; ++v.x) {
    for (v.y = c.lo.y; v.y <= c.hi.y; ++v.y) {
      for (v.z = c.lo.z; v.z <= c.hi.z; ++v.z) {
        const bool same = small.State(v) == large.State(v);
        known += same && small.State(v) != VoxelState::kUnknown ? 1 : 0;
        missing += same ? 0 : 1;
        if (!same && small.State(v) != VoxelState::kUnknown) {
          why = "a full map says otherwise of a voxel that it knows";
          return Outcome::kWrong;
        }
      }
    }
  }
  const bool counted = (small.updates_refused() > 0) == (missing > 0);
  if (!counted || known == 0 || small.bricks_used() > bricks || large.updates_refused() != 0) {
    why = "a full map does not say so";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

/// One wall after the other, each seen some times from a metre away, until tracks and scene are
/// full.
Outcome FullPrimitives(Rng& rng, std::string& why) {
  const auto cloud = std::make_unique<Cloud>();
  cloud->width = 106;
  cloud->height = 60;
  for (int v = 0; v < cloud->height; ++v) {
    for (int u = 0; u < cloud->width; ++u) {
      const double z = 1 + 0.003 * rng.Normal();
      const auto i = static_cast<std::size_t>(v * cloud->width + u);
      cloud->p_SQ[i] = Vector3d(z * (u - 52.5) / 56, z * (v - 29.5) / 56, z).cast<float>();
      cloud->valid[i] = 1;
    }
  }
  cloud->valid_count = cloud->size();
  const auto tracker = std::make_unique<PrimitiveTracker>(PrimitiveConfig{}, rng.Next());
  const Vector3d step = rng.Uniform(3, 6) * Vector3d::UnitZ();
  int most = 0;
  for (int wall = 0; wall < PrimitiveTracker::kMaxTracks + 6; ++wall) {
    cloud->X_WS.translation() = wall * step;
    for (int frame = 0; frame < 8; ++frame) {
      cloud->stamp += 66ms;
      tracker->Step(*cloud);
    }
    most = std::max(most, tracker->scene().planes.size());
  }
  if (most != Scene::kMaxPlanes || tracker->counters().full == 0) {
    why = fmt::format("{} planes in the scene, {} counted as without room", most,
                      tracker->counters().full);
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

Outcome FullCandidates(Rng& rng, std::string& why) {
  VoxelGrid map(Room(0));
  const std::vector<Vector3f> points = RoomPoints(rng);
  map.InsertScan(points.data(), static_cast<int>(points.size()), Vector3f(0, 0, 0), -1);
  const int capacity = 1 + rng.Index(100);
  SurfaceToCover small(map.config(), capacity);
  SurfaceToCover large(map.config(), 65536);
  const Status of_small = small.Update(map, Scene{}, 1);
  const Status of_large = large.Update(map, Scene{}, 1);
  if (of_small != Status::kFull || of_large != Status::kOk ||
      static_cast<int>(small.patches().size()) != capacity ||
      static_cast<int>(large.patches().size()) <= capacity) {
    why = "a full store of patches does not say so, or holds less than it could";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

/// Behind a wall that leaves no way: the node store of the small one is full before its samples are
/// drawn; then it still finds an easy way.
Outcome FullNodes(Rng& rng, const test::Cell& walled, std::string& why) {
  Configuration from = test::Cell::Start();
  from(0) = 0.1;
  Configuration beyond = from;
  beyond(0) = 1.4;
  Configuration near = from;
  near(2) += 0.1;
  MotionPlanner small({.node_capacity = 2 * Goal::kMaxWaypoints, .iterations = 100000});
  MotionPlanner::Path path;
  double duration_s = 0;
  const Status full = small.Plan(walled.around(), from, beyond, rng, path, &duration_s);
  const bool empty = path.empty();
  const Status then = small.Plan(walled.around(), from, near, rng, path, &duration_s);
  if (full != Status::kFull || !empty || then != Status::kOk) {
    why = "a full node store does not say so, or spoils the next plan";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

}  // namespace

Tally StoresFull(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  Rng rng(seed);
  test::Cell walled;
  walled.AddBox({0.75, -0.5, 0}, {0.8, 1.95, 1.65});
  for (std::uint64_t i = 0; i < n; ++i) {
    std::string why;
    const Outcome outcome = i % 4 == 0   ? FullMap(rng, why)
                            : i % 4 == 1 ? FullPrimitives(rng, why)
                            : i % 4 == 2 ? FullCandidates(rng, why)
                                         : FullNodes(rng, walled, why);
    tally.Add(outcome);
    if (!why.empty()) {
      tally.Note(why);
    }
  }
  return tally;
}

namespace {

struct ReadLog {
  bool opened = false;
  bool ended_early = false;
  std::uint64_t malformed = 0;
  std::vector<hil::LogFrame> frames;
};

ReadLog ReadAll(std::string bytes) {
  ReadLog read;
  hil::ChannelNames channels;
  hil::LogReader log(channels);
  std::FILE* file = fmemopen(bytes.data(), bytes.size(), "r");
  if (file == nullptr || !log.Open(file, "log", {.whole_lines = true}).empty()) {
    return read;
  }
  read.opened = true;
  for (auto block = log.Next(); !block.empty(); block = log.Next()) {
    read.frames.insert(read.frames.end(), block.begin(), block.end());
  }
  read.malformed = log.problems().malformed();
  read.ended_early = !log.problems().end().empty();
  return read;
}

bool Same(const hil::LogFrame& a, const hil::LogFrame& b) {
  return a.id == b.id && a.length == b.length && a.stamp_ns == b.stamp_ns &&
         std::equal(a.data.begin(), a.data.begin() + a.length, b.data.begin());
}

/// The frames of a cut log are the first of the whole one's, all that are whole.
bool IsBeginning(const ReadLog& cut, const ReadLog& whole) {
  return cut.frames.size() <= whole.frames.size() &&
         std::equal(cut.frames.begin(), cut.frames.end(), whole.frames.begin(), Same);
}

}  // namespace

Tally LogsDamaged(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  const std::vector<hil::LogFrame> frames = test::RandomFrames(24, seed);
  for (const test::NamedLog& form : test::InEveryFormat(frames)) {
    const ReadLog whole = ReadAll(form.bytes);
    std::size_t before = 0;
    for (std::size_t at = 1; at < form.bytes.size() && tally.n() < n; ++at) {
      const ReadLog cut = ReadAll(form.bytes.substr(0, at));
      const bool right = IsBeginning(cut, whole) && cut.frames.size() >= before;
      before = std::max(before, cut.frames.size());
      tally.Add(right ? Outcome::kMasked : Outcome::kWrong);
      if (!right) {
        tally.Note(
            fmt::format("{} cut after {} bytes: not the beginning of the whole", form.name, at));
      }
    }
    for (std::size_t at = 0; at < form.bytes.size() && tally.n() < n; ++at) {
      std::string damaged = form.bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
      const ReadLog read = ReadAll(damaged);
      // A separator flipped in or out makes one record more, or two of one. Formats with lengths
      // may take the rest for one record.
      const bool right = read.frames.size() <= whole.frames.size() + 1;
      tally.Add(right ? Outcome::kMasked : Outcome::kWrong);
      if (!right) {
        tally.Note(fmt::format("{} with byte {} flipped: {} frames of {}", form.name, at,
                               read.frames.size(), whole.frames.size()));
      }
    }
  }
  tally.Note("a full disk, and what replay makes of cut runs: tests/mission/replay_test.cc");
  return tally;
}

namespace {

struct Text {
  std::vector<std::string> lines;
  std::string With(std::size_t line, const std::string& instead) const {
    std::string text;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      text += (i == line ? instead : lines[i]) + "\n";
    }
    return text;
  }
};

Text DaemonText() {
  return {{"[can]",
           "base = \"can0\"",
           "arm = \"can1\"",
           "[base]",
           "mode_codes = \"sdk\"",
           "[control]",
           "rate_hz = 200",
           "alpha = 0.8",
           "[realtime]",
           "required = true",
           "priority = 70",
           "cpu = 3",
           "[camera]",
           "source = \"v4l2\"",
           "device = \"/dev/video2\"",
           "width = 424",
           "height = 240",
           "fx = 223.4",
           "fy = 223.4",
           "cx = 211.5",
           "cy = 119.5",
           "z_min_m = 0.168",
           "z_max_m = 6.0",
           "stamp_offset_ms = -8.5",
           "stride = 4",
           "timeout_s = 1.5",
           "[workspace]",
           "min_m = [0.1, 0.1, 0.1]",
           "max_m = [1.4, 1.4, 1.4]",
           "[start]",
           "x_m = 0.35",
           "y_m = 0.75",
           "yaw_rad = 0.25",
           "clearance_m = 0.2",
           "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
           "[mission]",
           "planner = \"cfnbv\"",
           "seed = 7",
           "time_limit_s = 600",
           "autostart = true",
           "[watchdog]",
           "tasks_s = 2",
           "planning_s = 20",
           "[service]",
           "socket = \"/run/x/s.sock\""}};
}

Text ScenarioText() {
  return {{"name = 'test'",
           "[workspace]",
           "min_m = [0.1, 0.1, 0.1]",
           "max_m = [1.4, 1.4, 1.4]",
           "[start]",
           "x_m = 0.3",
           "y_m = 0.75",
           "yaw_rad = 0",
           "clearance_m = 0.15",
           "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
           "[camera]",
           "rate_hz = 30",
           "[base]",
           "yaw_scale_slow = 1.06",
           "slip = 0.01",
           "[[plane]]",
           "name = 'p'",
           "normal = [0, 0, 1]",
           "offset_m = 0.0",
           "[[box]]",
           "name = 'b'",
           "center_m = [3, 3, 3]",
           "size_m = [1, 1, 1]",
           "[[cylinder]]",
           "name = 'c'",
           "from_m = [3, 0, 0]",
           "to_m = [3, 2, 0]",
           "radius_m = 0.05",
           "[[fault]]",
           "device = 'arm3'",
           "kind = 'silent'",
           "at_s = 2.5"}};
}

/// A line of `text`, from 0, and what makes a contradiction or nonsense of it.
struct BadLine {
  std::size_t line;
  std::string instead;
};

/// Each key: an unknown one in its place, another type, and, where it is a number or some, none
/// that is one, infinities, and sizes that nothing has.
std::vector<BadLine> EveryKey(const Text& text) {
  std::vector<BadLine> all;
  for (std::size_t i = 0; i < text.lines.size(); ++i) {
    const std::string& line = text.lines[i];
    const std::size_t sign = line.find(" = ");
    if (sign == std::string::npos) {
      continue;
    }
    const std::string key = line.substr(0, sign);
    const std::string value = line.substr(sign + 3);
    all.push_back({i, line + "\nno_such_key = 1"});
    all.push_back({i, line + "\n" + line});  // twice
    all.push_back({i, key + " = { a = 1 }"});
    all.push_back({i, key + " = "});
    if (value[0] == '"' || value[0] == '\'' || value == "true") {
      all.push_back({i, key + " = 3.5"});
      continue;
    }
    all.push_back({i, key + " = 'text'"});
    for (const char* bad : {"nan", "inf", "-inf", "1e300", "-1e300"}) {
      std::string instead = bad;
      if (value[0] == '[') {
        instead = "[" + std::string(bad) + value.substr(value.find(','));
      }
      all.push_back({i, key + " = " + instead});
    }
    if (value[0] == '[') {
      all.push_back({i, key + " = [1, 2]"});  // one missing, or five
    }
  }
  return all;
}

std::size_t LineOf(const Text& text, const std::string& line) {
  return static_cast<std::size_t>(std::find(text.lines.begin(), text.lines.end(), line) -
                                  text.lines.begin());
}

constexpr std::size_t kAnyLine = static_cast<std::size_t>(-1);

/// Every message begins with the file and a line; one names the line, or the one after it. What
/// contradicts another line may name that.
bool Located(const std::vector<std::string>& errors, std::size_t line) {
  bool named = false;
  for (const std::string& error : errors) {
    if (error.rfind("x.toml:", 0) != 0) {
      return false;
    }
    const auto at = static_cast<std::size_t>(std::atoi(error.c_str() + 7));
    named = named || line == kAnyLine || at == line + 1 || at == line + 2;
  }
  return named;
}

template <typename Errors>
void Try(const Text& text, const std::vector<BadLine>& bad, bool contradicts,
         const Errors& errors_of, std::uint64_t n, Tally& tally) {
  for (const BadLine& b : bad) {
    if (tally.n() >= n) {
      return;
    }
    const std::vector<std::string> errors = errors_of(text.With(b.line, b.instead));
    const bool right = Located(errors, contradicts ? kAnyLine : b.line);
    tally.Add(right ? Outcome::kSafeStop : Outcome::kWrong);
    if (!right) {
      tally.Note(fmt::format("{} -> {}", b.instead, errors.empty() ? "taken" : errors.front()));
    }
  }
}

}  // namespace

Tally BadConfigurations(std::uint64_t n, std::uint64_t) {
  Tally tally;
  const auto of_daemon = [](const std::string& text) {
    const DaemonConfigResult result = ParseDaemonConfig(text, "x.toml");
    return result.config ? std::vector<std::string>{} : result.errors;
  };
  const auto of_scenario = [](const std::string& text) {
    const hil::ScenarioResult result = hil::ParseScenario(text, "x.toml", "");
    return result.scenario ? std::vector<std::string>{} : result.errors;
  };
  const Text daemon = DaemonText();
  const Text scenario = ScenarioText();
  if (!ParseDaemonConfig(daemon.With(daemon.lines.size(), ""), "x.toml").config ||
      !hil::ParseScenario(scenario.With(scenario.lines.size(), ""), "x.toml", "").scenario) {
    tally.Add(Outcome::kWrong);
    tally.Note("what is right is refused");
    return tally;
  }
  Try(daemon, EveryKey(daemon), false, of_daemon, n, tally);
  Try(scenario, EveryKey(scenario), false, of_scenario, n, tally);
  const auto in = [&](const Text& text, const char* line, const char* instead) {
    return BadLine{LineOf(text, line), instead};
  };
  Try(daemon,
      {in(daemon, "max_m = [1.4, 1.4, 1.4]", "max_m = [1.4, 0.05, 1.4]"),
       in(daemon, "z_max_m = 6.0", "z_max_m = 0.1"), in(daemon, "rate_hz = 200", "rate_hz = 300"),
       in(daemon, "rate_hz = 200", "rate_hz = 0"),
       in(daemon, "arm = \"can1\"", "arm = \"can0\""),  // one bus does not carry 200 Hz
       in(daemon, "stride = 4", "stride = 0"), in(daemon, "alpha = 0.8", "alpha = 0.3"),
       in(daemon, "priority = 70", "priority = 0"), in(daemon, "cx = 211.5", "cx = 500"),
       in(daemon, "mode_codes = \"sdk\"", "mode_codes = \"none\""),
       in(daemon, "joints_rad = [0, -0.9, 0, 0.5, 0, -0.4, 0]",
          "joints_rad = [0, -0.9, 0, 5.0, 0, -0.4, 0]")},
      true, of_daemon, n, tally);
  Try(scenario,
      {in(scenario, "max_m = [1.4, 1.4, 1.4]", "max_m = [1.4, 1.4, 0.1]"),
       in(scenario, "normal = [0, 0, 1]", "normal = [0, 0, 0]"),
       in(scenario, "to_m = [3, 2, 0]", "to_m = [3, 0, 0]"),
       in(scenario, "size_m = [1, 1, 1]", "size_m = [1, 0, 1]"),
       in(scenario, "device = 'arm3'", "device = 'arm8'"),
       in(scenario, "kind = 'silent'", "kind = 'loud'")},
      true, of_scenario, n, tally);
  return tally;
}

Tally CyclesThatAllocate(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  while (rig.cycles() < n) {
    if (!rig.Ready()) {
      tally.Add(Outcome::kCrash);
      return tally;
    }
    rig.arm().Lose(rig.rng().Index(60), [](const can::Frame&) { return true; });
    for (int i = 0; i < 20; ++i) {
      rig.base().Replay(rig.rng());
    }
    rig.For(200ms);
  }
  tally.Add(Outcome::kMasked, rig.cycles() - rig.cycles_that_allocate());
  tally.Add(Outcome::kWrong, rig.cycles_that_allocate());
  tally.Note(
      hil::HeapWatch::Counting()
          ? "heap; locks and allocators: scripts/check_heap_free.sh, by the archives' symbols"
          : "nothing was counted: a sanitizer has the heap");
  return tally;
}

}  // namespace pipewright::bench
