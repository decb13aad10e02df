// SPDX-License-Identifier: MIT
#include "platform/robot/kinematics.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <tuple>

#include "platform/core/rng.h"
#include "platform/robot/robot.h"
#include "platform/robot/uf7.h"
#include "platform/robot/ur5e.h"

namespace pipewright {
namespace {

/// tests/data/robot/dq_oracle.csv: figures of another library.
class Oracle {
 public:
  Oracle() {
    std::ifstream file(PIPEWRIGHT_TEST_DATA "/robot/dq_oracle.csv");
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::istringstream row(line);
      std::string field[5];
      for (std::string& f : field) {
        std::getline(row, f, ',');
      }
      values_[{std::stoi(field[0]), field[1], std::stoi(field[2]), std::stoi(field[3])}] =
          std::stod(field[4]);
    }
  }

  template <int rows, int cols>
  Mat<rows, cols> Get(int c, const std::string& quantity, int first_row = 0) const {
    Mat<rows, cols> m;
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < cols; ++j) {
        m(i, j) = values_.at({c, quantity, first_row + i, j});
      }
    }
    return m;
  }

  Configuration q(int c) const {
    Configuration q;
    q << Get<3, 1>(c, "base_xyphi"), Get<7, 1>(c, "q");
    return q;
  }

 private:
  std::map<std::tuple<int, std::string, int, int>, double> values_;
};

constexpr int kCases = 12;
constexpr double kTolerance = 1e-9;  // what the product promises; met to about 1e-15

template <typename A, typename B>
double MaxDifference(const A& a, const B& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

template <int kJoints>
Vec<3 + kJoints> RandomConfiguration(Rng& rng) {
  Vec<3 + kJoints> q;
  for (int i = 0; i < q.size(); ++i) {
    q(i) = rng.Uniform(-3, 3);
  }
  return q;
}

/// q after a short time at constant controls, to second order in dt.
template <int kJoints>
Vec<3 + kJoints> Moved(const Vec<3 + kJoints>& q, const Vec<2 + kJoints>& u, double dt) {
  Vec<3 + kJoints> moved = q;
  const double heading = q(2) + u(1) * dt / 2;
  moved(0) += std::cos(heading) * u(0) * dt;
  moved(1) += std::sin(heading) * u(0) * dt;
  moved.template tail<1 + kJoints>() += u.template tail<1 + kJoints>() * dt;
  return moved;
}

TEST(Kinematics, FlangeAgreesWithDqRobotics) {
  const Oracle oracle;
  for (int c = 0; c < kCases; ++c) {
    SCOPED_TRACE(c);
    ASSERT_LT(
        MaxDifference(oracle.Get<3, 1>(c, "mount_xyz"), Vector3d(TracerUf7().mount.p_BA_m.data())),
        1e-15);
    const Kinematics<7> body(TracerUf7(), oracle.q(c));
    const Eigen::Vector4d r = oracle.Get<4, 1>(c, "wb_r");
    const Matrix3d R = Eigen::Quaterniond(r(0), r(1), r(2), r(3)).toRotationMatrix();
    EXPECT_LT(MaxDifference(body.X_WL(7).translation(), oracle.Get<3, 1>(c, "wb_t")), kTolerance);
    EXPECT_LT(MaxDifference(body.X_WL(7).linear(), R), kTolerance);
  }
}

TEST(Kinematics, FlangeJacobiansAgreeWithDqRobotics) {
  const Oracle oracle;
  for (int c = 0; c < kCases; ++c) {
    SCOPED_TRACE(c);
    const Kinematics<7> body(TracerUf7(), oracle.q(c));
    const Mat<6, 9> line = body.LineJacobian(7, Vector3d::Zero(), Vector3d::UnitZ());
    EXPECT_LT(
        MaxDifference(body.PointJacobian(7, Vector3d::Zero()), (oracle.Get<3, 9>(c, "wb_J_t_vw"))),
        kTolerance);
    EXPECT_LT(MaxDifference(line.topRows<3>(), (oracle.Get<3, 9>(c, "wb_J_line_z_vw", 1))),
              kTolerance);
    EXPECT_LT(MaxDifference(line.bottomRows<3>(), (oracle.Get<3, 9>(c, "wb_J_line_z_vw", 5))),
              kTolerance);
  }
}

TEST(Kinematics, ElbowAgreesWithDqRobotics) {
  const Oracle oracle;
  for (int c = 0; c < kCases; ++c) {
    SCOPED_TRACE(c);
    Configuration q = oracle.q(c);
    q.head<3>().setZero();  // the oracle's elbow is in A, which then has W's axes
    const Kinematics<7> body(TracerUf7(), q);
    const Vector3d p_WA(TracerUf7().mount.p_BA_m.data());
    const Mat<3, 4> arm_columns = body.PointJacobian(4, Vector3d::Zero()).block<3, 4>(0, 2);
    EXPECT_LT(MaxDifference(body.X_WL(4).translation() - p_WA, oracle.Get<3, 1>(c, "elbow_t")),
              kTolerance);
    EXPECT_LT(MaxDifference(arm_columns, (oracle.Get<3, 4>(c, "elbow_J_t"))), kTolerance);
  }
}

template <int kJoints>
void ExpectJacobiansMatchCentralDifferences(const RobotModel<kJoints>& robot) {
  using Body = Kinematics<kJoints>;
  constexpr double kDt = 1e-5;
  constexpr double kSecondOrder = 1e-8;  // dt^2 of a motion of order 10
  Rng rng(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec<3 + kJoints> q = RandomConfiguration<kJoints>(rng);
    const Body body(robot, q);
    const Vector3d p_LQ{rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vector3d l_L = Vector3d{rng.Normal(), rng.Normal(), rng.Normal()}.normalized();
    for (int control = 0; control < 2 + kJoints; ++control) {
      const Vec<2 + kJoints> u = Vec<2 + kJoints>::Unit(control);
      const Body ahead(robot, Moved<kJoints>(q, u, kDt));
      const Body behind(robot, Moved<kJoints>(q, u, -kDt));
      for (int b = 0; b < Body::kBodies; ++b) {
        SCOPED_TRACE(testing::Message() << "body " << b << ", control " << control);
        const auto line = [&](const Body& at) {
          const Vector3d p = at.Point(b, p_LQ);
          const Vector3d l = at.X_WL(b).linear() * l_L;
          Vec<6> pluecker;
          pluecker << l, p.cross(l);
          return pluecker;
        };
        const Vector3d v = (ahead.Point(b, p_LQ) - behind.Point(b, p_LQ)) / (2 * kDt);
        const Vec<6> line_rate = (line(ahead) - line(behind)) / (2 * kDt);
        EXPECT_LT(MaxDifference(body.PointJacobian(b, p_LQ) * u, v), kSecondOrder);
        EXPECT_LT(MaxDifference(body.LineJacobian(b, p_LQ, l_L) * u, line_rate), kSecondOrder);
      }
      Vec<6> sensor_rate;
      sensor_rate << (ahead.p_WS() - behind.p_WS()) / (2 * kDt),
          (ahead.z_WS() - behind.z_WS()) / (2 * kDt);
      EXPECT_LT(MaxDifference(body.SensorJacobian() * u, sensor_rate), kSecondOrder);
    }
  }
}

TEST(Kinematics, EveryJacobianOfTheUf7MatchesCentralDifferences) {
  ExpectJacobiansMatchCentralDifferences(TracerUf7());
}

TEST(Kinematics, EveryJacobianOfTheUr5eMatchesCentralDifferences) {
  ExpectJacobiansMatchCentralDifferences(TracerUr5e());
}

TEST(Kinematics, ARowIsTheNormalTimesTheJacobian) {
  Rng rng(12);
  for (int trial = 0; trial < 50; ++trial) {
    const Kinematics<7> body(TracerUf7(), RandomConfiguration<7>(rng));
    const Vector3d p_WQ{rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2)};
    const Vector3d n_W = Vector3d{rng.Normal(), rng.Normal(), rng.Normal()}.normalized();
    for (int b = 0; b < Kinematics<7>::kBodies; ++b) {
      EXPECT_LT(MaxDifference(body.PointRow(b, p_WQ, n_W),
                              n_W.transpose() * body.PointJacobianAt(b, p_WQ)),
                1e-14);
    }
  }
}

TEST(Kinematics, NoBodyMovesAtRightAnglesToTheBaseWhenItDrives) {
  Rng rng(13);
  for (int trial = 0; trial < 50; ++trial) {
    const Configuration q = RandomConfiguration<7>(rng);
    const Kinematics<7> body(TracerUf7(), q);
    const Vector3d lateral{-std::sin(q(2)), std::cos(q(2)), 0};
    for (int b = 0; b < Kinematics<7>::kBodies; ++b) {
      EXPECT_EQ(lateral.dot(body.PointJacobian(b, {0.1, 0.2, 0.3}).col(0)), 0.0);
    }
  }
}

TEST(Kinematics, TheUr5eStandsWhereItsMakerSaysAtZero) {
  // Flange in the arm's base at q = 0: (a2 + a3, -(d4 + d6), d1 - d5) of the published table, and
  // pointing along -y. The world's axes are the arm's, for the mount is not turned.
  const Kinematics<6> body(TracerUr5e(), Vec<9>::Zero());
  const Vector3d p_WA(TracerUr5e().mount.p_BA_m.data());
  const Vector3d p_AF = body.X_WL(6).translation() - p_WA;
  EXPECT_LT(MaxDifference(p_AF, Vector3d(-0.8172, -0.2329, 0.0628)), 1e-12);
  EXPECT_LT(MaxDifference(body.X_WL(6).linear().col(2), Vector3d(0, -1, 0)), 1e-12);
}

TEST(Kinematics, SensorAndProbeAreWhereTheToolHoldsThem) {
  Rng rng(14);
  const Kinematics<7> body(TracerUf7(), RandomConfiguration<7>(rng));
  const Isometry3d X_FS = body.X_WL(7).inverse() * body.X_WS();
  EXPECT_LT(MaxDifference(X_FS.translation(), Vector3d(0, 0, 0.045)), 1e-14);
  EXPECT_LT(MaxDifference(X_FS.linear(), Matrix3d::Identity()), 1e-14);
  EXPECT_LT(MaxDifference(body.X_WL(7).inverse() * body.p_WP(), Vector3d(0, 0.045, 0.050)), 1e-14);
}

TEST(Kinematics, AMountThatIsTurnedTurnsTheArm) {
  RobotModel<7> turned = TracerUf7();
  turned.mount.yaw_rad = 0.7;
  Configuration q = Configuration::Zero();
  q(3) = 0.3;
  Configuration same = q;
  same(3) += turned.mount.yaw_rad;
  const Kinematics<7> a(turned, q);
  const Kinematics<7> b(TracerUf7(), same);
  EXPECT_LT(MaxDifference(a.X_WS().matrix(), b.X_WS().matrix()), 1e-14);
}

}  // namespace
}  // namespace pipewright
