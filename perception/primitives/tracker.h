// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "perception/cloud/cloud.h"
#include "perception/primitives/config.h"
#include "perception/primitives/depth_view.h"
#include "perception/primitives/detector.h"
#include "perception/primitives/track.h"
#include "perception/scene.h"

namespace pipewright {

struct PrimitiveCounters {
  std::uint64_t frames = 0;
  std::uint64_t refused = 0;     ///< frames that made no sense
  std::uint64_t detections = 0;  ///< planes and pipes of single frames
  std::uint64_t tracks_made = 0;
  std::uint64_t tracks_dropped = 0;  ///< contradicted, or never confirmed
  std::uint64_t merged = 0;
  std::uint64_t improbable = 0;  ///< matches that chance hardly explains: pose or filter too sure
  std::uint64_t full = 0;        ///< primitives without room, in tracks or in the scene
  std::uint64_t unsound = 0;     ///< times that one was not given to others: see Sound()
};

/// Planes and pipes over time: those of each frame are matched to what is known, filtered in W, and
/// given to others once confirmed.
///
/// A primitive that a frame sees through gets less certain, and goes when that happens for long.
/// What is out of view keeps its state and drifts slowly. Covariances of scene() have the pose's
/// error in them. No heap after construction; ~3 MB.
class PrimitiveTracker {
 public:
  static constexpr int kMaxTracks = 24;  ///< of each kind, tentative ones included

  PrimitiveTracker(const PrimitiveConfig& config, std::uint64_t seed);

  /// How noisy the readings are from here on: DepthNoise::c_1pm.
  void Assume(double noise_1pm);

  /// One frame. Cost: 1 to 3 ms for 106x60 readings.
  void Step(const Cloud& cloud);

  /// What is confirmed, as of the last step.
  const Scene& scene() const { return scene_; }
  const PrimitiveCounters& counters() const { return counters_; }
  /// Of the last frame alone, in S.
  const PrimitiveDetector& detector() const { return detector_; }

 private:
  template <typename Track>
  using Tracks = FixedVector<Track, kMaxTracks>;

  PrimitiveHints Hints() const;
  template <typename Track, typename Estimate>
  void Match(Tracks<Track>& tracks, const Estimate& seen, bool* matched);
  template <typename Track>
  void Doubt(Tracks<Track>& tracks, const bool* matched);
  template <typename Track>
  void Merge(Tracks<Track>& tracks);
  template <typename Track>
  void Drop(Tracks<Track>& tracks);
  template <typename Track, typename Out>
  void Publish(const Tracks<Track>& tracks, Out& out);

  PrimitiveConfig config_;
  DepthView view_;
  PrimitiveDetector detector_;
  Tracks<PlaneTrack> planes_;
  Tracks<PipeTrack> pipes_;
  Scene scene_;
  PrimitiveCounters counters_;
  std::uint32_t next_id_ = 1;
};

}  // namespace pipewright
