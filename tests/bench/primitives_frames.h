// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/primitives_rooms.h"

namespace pipewright::bench {

/// Normalised errors squared of everything found that is there, and what is found that is not.
struct FrameErrors {
  std::vector<double> plane;   ///< (n, d): 3 degrees of freedom
  std::vector<double> axis;    ///< of pipes, (point, direction): 4
  std::vector<double> radius;  ///< 1
  std::vector<double> pipe;    ///< all of it: 5
  int frames = 0;
  int wrong_planes = 0;
  int wrong_pipes = 0;

  void operator+=(const FrameErrors& other);
};

/// Simulated frames, each a room, a pose and noise of its own, through cloud and detector.
FrameErrors MeasureErrors(const FrameCase& c, int frames, std::uint64_t seed);

/// Processor times [ms] of what a frame costs from depth image to primitives, and what was found.
struct FrameTimes {
  std::vector<double> cloud_ms;
  std::vector<double> view_ms;
  std::vector<double> planes_ms;
  std::vector<double> pipes_ms;
  std::vector<double> all_ms;       ///< up to here
  std::vector<double> clusters_ms;  ///< of what they leave unexplained
  double planes = 0;                ///< a frame
  double pipes = 0;
  double clusters = 0;
  std::uint64_t heap_allocations = 0;
};

/// Each frame `passes` times; its time is the least of them.
FrameTimes MeasureTimes(const FrameCase& c, int frames, int passes, std::uint64_t seed);

}  // namespace pipewright::bench
