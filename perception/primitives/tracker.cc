// SPDX-License-Identifier: MIT
#include "perception/primitives/tracker.h"

#include <algorithm>
#include <cmath>

#include "perception/primitives/evidence.h"
#include "perception/primitives/soundness.h"

namespace pipewright {
namespace {

constexpr int kLookStep = 2;        // every second pixel of every second row
constexpr int kMinTold = 6;         // readings before a frame speaks against a primitive
constexpr double kThrough = 0.6;    // share of them that must lie behind it
constexpr int kTentativeDoubt = 2;  // net contradictions before an unconfirmed track goes

Vector3d AwayFrom(const PlaneEstimate& plane) { return plane.n_W; }
Vector3d AwayFrom(const PipeEstimate& pipe) { return pipe.l_W; }

template <typename Estimate>
bool Finite(const Estimate& e) {
  return e.covariance.allFinite() && AwayFrom(e).allFinite();
}

bool Within(const Fit& fit, const PrimitiveConfig& c) {
  return fit.angle_rad < c.gate_angle_rad && fit.offset_m < c.gate_offset_m &&
         fit.radius_m < c.gate_radius_m && fit.gap_m < c.gate_gap_m;
}

/// How far apart, in gates.
double Distance(const Fit& fit, const PrimitiveConfig& c) {
  return fit.angle_rad / c.gate_angle_rad + fit.offset_m / c.gate_offset_m +
         fit.radius_m / c.gate_radius_m + std::max(0.0, fit.gap_m / c.gate_gap_m);
}

/// Removes item i; the others keep their order.
template <typename Vector>
void Erase(Vector& items, int i) {
  for (int k = i; k + 1 < items.size(); ++k) {
    items[k] = items[k + 1];
  }
  items.pop_back();
}

}  // namespace

PrimitiveTracker::PrimitiveTracker(const PrimitiveConfig& config, std::uint64_t seed)
    : config_(config), detector_(config, seed) {}

void PrimitiveTracker::Assume(double noise_1pm) {
  config_.noise.c_1pm = noise_1pm;
  detector_.Assume(noise_1pm);
}

void PrimitiveTracker::Step(const Cloud& cloud) {
  ++counters_.frames;
  scene_.stamp = cloud.stamp;
  if (view_.Set(cloud, config_.noise) != Status::kOk) {
    ++counters_.refused;
    return;
  }
  for (PlaneTrack& track : planes_) {
    Drift(track.estimate, config_.drift_sigma_rad, config_.drift_sigma_m);
  }
  for (PipeTrack& track : pipes_) {
    Drift(track.estimate, config_.drift_sigma_rad, config_.drift_sigma_m);
  }
  detector_.Detect(view_, Hints());

  bool matched_planes[kMaxTracks] = {};
  for (const DetectedPlane& plane : detector_.planes()) {
    Match(planes_, ToWorld(plane, view_.X_WS()), matched_planes);
  }
  bool matched_pipes[kMaxTracks] = {};
  for (const DetectedPipe& pipe : detector_.pipes()) {
    Match(pipes_, ToWorld(pipe, view_.X_WS()), matched_pipes);
  }
  Doubt(planes_, matched_planes);
  Doubt(pipes_, matched_pipes);
  Merge(planes_);
  Merge(pipes_);
  Drop(planes_);
  Drop(pipes_);
  Publish(planes_, scene_.planes);
  Publish(pipes_, scene_.pipes);
}

PrimitiveHints PrimitiveTracker::Hints() const {
  PrimitiveHints hints;
  for (const PlaneTrack& track : planes_) {
    if (LookAt(view_, track.estimate, config_.noise, 2 * kLookStep).agree >= kMinTold) {
      (void)hints.planes.push_back(ToSensor(track.estimate, view_.X_WS()));
    }
  }
  for (const PipeTrack& track : pipes_) {
    if (LookAt(view_, track.estimate, config_.noise, kLookStep).agree >= kMinTold) {
      (void)hints.pipes.push_back(ToSensor(track.estimate, view_.X_WS()));
    }
  }
  return hints;
}

/// Fuses a detection into the nearest track within the gates, or starts a track with it.
template <typename Track, typename Estimate>
void PrimitiveTracker::Match(Tracks<Track>& tracks, const Estimate& seen, bool* matched) {
  ++counters_.detections;
  if (!Finite(seen)) {
    return;
  }
  const Vector3d p_WS = view_.X_WS().translation();
  Track* nearest = nullptr;
  double least = 1e9;
  for (Track& track : tracks) {
    const Fit fit = Compare(track.estimate, seen);
    if (Within(fit, config_) && Distance(fit, config_) < least) {
      least = Distance(fit, config_);
      nearest = &track;
    }
  }
  if (nearest == nullptr) {
    Track track;
    track.estimate = seen;
    track.estimate.id = next_id_++;
    if (!tracks.push_back(track)) {
      ++counters_.full;
      return;
    }
    ++counters_.tracks_made;
    nearest = &tracks.back();
  } else {
    constexpr double kImprobable = 25;
    counters_.improbable += Fuse(nearest->estimate, seen, config_, p_WS) > kImprobable;
  }
  bool& already = matched[nearest - tracks.begin()];
  nearest->estimate.frames_seen += !already;
  already = true;
  nearest->estimate.last_seen = scene_.stamp;
  nearest->life.p_WS = p_WS;
  nearest->life.contradictions = std::max(0, nearest->life.contradictions - 1);
  nearest->life.confirmed |= nearest->estimate.frames_seen >= config_.confirm_frames;
}

/// Asks the frame about each track it did not detect.
template <typename Track>
void PrimitiveTracker::Doubt(Tracks<Track>& tracks, const bool* matched) {
  for (int k = 0; k < tracks.size(); ++k) {
    Track& track = tracks[k];
    ++track.life.age_frames;
    if (matched[k]) {
      continue;
    }
    const Evidence evidence = LookAt(view_, track.estimate, config_.noise, kLookStep);
    if (evidence.told() >= kMinTold && evidence.through > kThrough * evidence.told()) {
      ++track.life.contradictions;
      Drift(track.estimate, config_.doubt_sigma_rad, config_.doubt_sigma_m);
    }
  }
}

/// Two tracks that turn out to be one: the newer goes into the older.
template <typename Track>
void PrimitiveTracker::Merge(Tracks<Track>& tracks) {
  PrimitiveConfig gates = config_;
  gates.gate_angle_rad = config_.merge_angle_rad;
  gates.gate_offset_m = config_.merge_offset_m;
  for (int i = 0; i < tracks.size(); ++i) {
    for (int k = tracks.size() - 1; k > i; --k) {
      Track& older = tracks[i];
      const Track& newer = tracks[k];
      if (!Within(Compare(older.estimate, newer.estimate), gates)) {
        continue;
      }
      Fuse(older.estimate, newer.estimate, config_, newer.life.p_WS);
      older.estimate.frames_seen += newer.estimate.frames_seen;
      older.estimate.last_seen = std::max(older.estimate.last_seen, newer.estimate.last_seen);
      older.life.confirmed |= newer.life.confirmed;
      older.life.contradictions = std::min(older.life.contradictions, newer.life.contradictions);
      ++counters_.merged;
      Erase(tracks, k);
    }
  }
}

template <typename Track>
void PrimitiveTracker::Drop(Tracks<Track>& tracks) {
  for (int k = tracks.size() - 1; k >= 0; --k) {
    const TrackLife& life = tracks[k].life;
    const bool contradicted =
        life.contradictions >= (life.confirmed ? config_.contradictions_max : kTentativeDoubt);
    const bool never = !life.confirmed && life.age_frames > config_.tentative_frames;
    if (contradicted || never || !Finite(tracks[k].estimate)) {
      ++counters_.tracks_dropped;
      Erase(tracks, k);
    }
  }
}

template <typename Track, typename Out>
void PrimitiveTracker::Publish(const Tracks<Track>& tracks, Out& out) {
  out.clear();
  for (const Track& track : tracks) {
    if (!track.life.confirmed) {
      continue;
    }
    auto estimate = track.estimate;
    estimate.covariance += PoseCovariance(estimate, track.life.p_WS, config_);
    if (!Sound(estimate)) {
      ++counters_.unsound;
      continue;
    }
    counters_.full += !out.push_back(estimate);
  }
}

}  // namespace pipewright
