// SPDX-License-Identifier: MIT
#include "hil/plant/plant.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "hil/plant/kdl_tree.h"

namespace pipewright::hil {
namespace {

Isometry3d FromKdl(const KDL::Frame& frame) {
  Isometry3d X = Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      X.linear()(row, col) = frame.M(row, col);
    }
    X.translation()(row) = frame.p(row);
  }
  return X;
}

/// sin(x)/x. Below 1e-4 the next term of the series, x^4/120, is under 1e-18.
double Sinc(double x) { return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x; }

double FiniteOrZero(double x) { return std::isfinite(x) ? x : 0; }

}  // namespace

struct Plant::Chain {
  struct Link {
    KDL::Segment segment;
    int parent = 0;
    int joint = -1;  // -1: fixed
  };

  std::vector<std::string> names;  // of the links, root first
  std::vector<Link> links;         // links[i] is names[i + 1]
  int camera = -1;
  int probe = -1;
  std::vector<Isometry3d, Eigen::aligned_allocator<Isometry3d>> X_WL;
  bool stale = true;
};

Plant::Plant(const RobotDescription& description, const BasePose& start,
             const Vec<kPlantJoints>& joints_rad)
    : chain_(std::make_unique<Chain>()), base_(start) {
  const KDL::Tree tree = ToKdlTree(description);
  int moving = 0;
  for (const JointDescription& joint : description.joints) {
    Chain::Link link;
    link.segment = tree.getSegment(joint.child)->second.segment;
    link.parent = description.LinkIndex(joint.parent);
    if (joint.kind != JointDescription::Kind::kFixed) {
      assert(moving < kPlantJoints);
      lower_rad_(moving) = joint.lower;
      upper_rad_(moving) = joint.upper;
      link.joint = moving++;
    }
    chain_->links.push_back(link);
  }
  assert(moving == kPlantJoints);
  chain_->names = description.links;
  chain_->camera = LinkIndex("camera");
  chain_->probe = LinkIndex("probe");
  assert(chain_->camera >= 0 && chain_->probe >= 0);
  chain_->X_WL.assign(description.links.size(), Isometry3d::Identity());
  joints_rad_ = joints_rad.cwiseMax(lower_rad_).cwiseMin(upper_rad_);
}

Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

void Plant::Step(Duration dt, double v_mps, double omega_radps,
                 const Vec<kPlantJoints>& qdot_radps) {
  const double dt_s = ToSeconds(dt);
  const double turn = FiniteOrZero(omega_radps) * dt_s;
  const double chord = FiniteOrZero(v_mps) * dt_s * Sinc(turn / 2);
  base_.x_m += chord * std::cos(base_.yaw_rad + turn / 2);
  base_.y_m += chord * std::sin(base_.yaw_rad + turn / 2);
  base_.yaw_rad += turn;

  for (int i = 0; i < kPlantJoints; ++i) {
    const double wanted = joints_rad_(i) + FiniteOrZero(qdot_radps(i)) * dt_s;
    joints_rad_(i) = std::clamp(wanted, lower_rad_(i), upper_rad_(i));
    const bool stopped = joints_rad_(i) != wanted;
    hard_stops_[i] += stopped && !at_stop_[i] ? 1 : 0;
    at_stop_[i] = stopped;
  }
  chain_->stale = true;
}

int Plant::link_count() const { return static_cast<int>(chain_->names.size()); }

int Plant::LinkIndex(std::string_view link) const {
  const auto found = std::find(chain_->names.begin(), chain_->names.end(), link);
  return found == chain_->names.end() ? -1 : static_cast<int>(found - chain_->names.begin());
}

const Isometry3d& Plant::X_WL(int link) const {
  UpdatePoses();
  return chain_->X_WL[static_cast<std::size_t>(link)];
}

Isometry3d Plant::X_WB() const {
  return Eigen::Translation3d(base_.x_m, base_.y_m, 0) *
         Eigen::AngleAxisd(base_.yaw_rad, Vector3d::UnitZ());
}

const Isometry3d& Plant::X_WS() const { return X_WL(chain_->camera); }

Vector3d Plant::p_WP() const { return X_WL(chain_->probe).translation(); }

int Plant::hard_stops() const { return std::accumulate(hard_stops_.begin(), hard_stops_.end(), 0); }

void Plant::UpdatePoses() const {
  if (!chain_->stale) {
    return;
  }
  chain_->X_WL[0] = X_WB();
  for (std::size_t i = 0; i < chain_->links.size(); ++i) {
    const Chain::Link& link = chain_->links[i];
    const double q = link.joint < 0 ? 0 : joints_rad_(link.joint);
    chain_->X_WL[i + 1] =
        chain_->X_WL[static_cast<std::size_t>(link.parent)] * FromKdl(link.segment.pose(q));
  }
  chain_->stale = false;
}

}  // namespace pipewright::hil
