// SPDX-License-Identifier: MIT
#pragma once

#include "platform/core/rng.h"
#include "tests/timing/cycle_case.h"

namespace pipewright::timing {

/// Cases by chance, and others like them. All that they hold is lawful: unit vectors, positive
/// semidefinite covariances, joints within their limits.
class CaseMaker {
 public:
  explicit CaseMaker(std::uint64_t seed) : rng_(seed) {}

  /// Copies the law of `like`; the rest is drawn.
  CycleCase Draw(const CycleCase& like);

  /// Copies the law of `like`. The folded robot amid as many primitives as there may be, all of
  /// them near all of it, the nearest last: each row displaces another.
  CycleCase Crowd(const CycleCase& like);

  /// `c` with one to three things changed.
  CycleCase Mutate(const CycleCase& c);

 private:
  static constexpr int kMaxBoxes = 4;
  static constexpr int kMaxCycles = 30;  ///< of a step: the last command is then at its limits

  Vector3d Direction();
  double Scale(double least, double most);  ///< log-uniform
  Vector3d RobotPoint(const Configuration& q);
  Configuration Place();
  PlaneEstimate Plane(const Vector3d& p_W, double distance_m);
  PipeEstimate Pipe(const Vector3d& p_W, double distance_m);
  PlaneEstimate Plane(const Configuration& q);
  PipeEstimate Pipe(const Configuration& q);
  CaseBox Box(const Configuration& q);
  void Want(const Configuration& q, Goal& goal);
  CaseStep Step(const Configuration& q);
  void Jitter(Configuration& q);
  void Jitter(PlaneEstimate& plane);
  void Jitter(PipeEstimate& pipe);
  void MutateScene(CycleCase& c);
  void MutateSteps(CycleCase& c);
  void MutateBoxes(CycleCase& c);

  Rng rng_;
};

}  // namespace pipewright::timing
