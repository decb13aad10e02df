// SPDX-License-Identifier: MIT
#include "tests/timing/cycle_case.h"

#include <istream>
#include <limits>
#include <ostream>
#include <sstream>

namespace pipewright::timing {
namespace {

constexpr const char* kFirstLine = "pipewright cycle case 1";

/// Every number of a thing in its order, for the writer and the reader alike.
template <typename See, typename Box>
void EachOfBox(Box& box, const See& see) {
  see(box.lo_W);
  see(box.hi_W);
}

template <typename See, typename Plane>
void EachOfPlane(Plane& plane, const See& see) {
  see(plane.n_W);
  see(plane.d_m);
  see(plane.p_WCentroid);
  see(plane.e1_W);
  see(plane.e2_W);
  for (const int i : {0, 1}) {
    see(plane.extent_lo_m[i]);
    see(plane.extent_hi_m[i]);
  }
  see(plane.covariance);
}

template <typename See, typename Pipe>
void EachOfPipe(Pipe& pipe, const See& see) {
  see(pipe.p_W);
  see(pipe.l_W);
  see(pipe.radius_m);
  see(pipe.extent_lo_m);
  see(pipe.extent_hi_m);
  see(pipe.covariance);
}

template <typename See, typename Step>
void EachOfStep(Step& step, const See& see) {
  see(step.cycles);
  see(step.alone);
  see(step.q);
  see(step.goal.p_WS);
  see(step.goal.z_WS);
}

template <typename See, typename Case>
void EachOfLaw(Case& c, const See& see) {
  see(c.period_s);
  see(c.alpha);
  see(c.joint_risk);
}

struct Writer {
  template <typename T>
  void operator()(const T& value) const {
    if constexpr (std::is_arithmetic_v<T>) {
      out << ' ' << value;
    } else {
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        out << ' ' << value(i);
      }
    }
  }
  std::ostream& out;
};

struct Reader {
  template <typename T>
  void operator()(T& value) const {
    if constexpr (std::is_arithmetic_v<T>) {
      in >> value;
    } else {
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        in >> value(i);
      }
    }
  }
  std::istream& in;
};

/// One line; false when its first word is none of ours, it has no place, or a number is missing.
bool ReadLine(const std::string& text, CycleCase& c) {
  std::istringstream line(text);
  const Reader see{line};
  std::string what;
  line >> what;
  if (what == "law") {
    EachOfLaw(c, see);
  } else if (what == "box") {
    EachOfBox(c.boxes.emplace_back(), see);
  } else if (what == "plane") {
    PlaneEstimate plane;
    EachOfPlane(plane, see);
    return !line.fail() && c.scene.planes.push_back(plane);
  } else if (what == "pipe") {
    PipeEstimate pipe;
    EachOfPipe(pipe, see);
    return !line.fail() && c.scene.pipes.push_back(pipe);
  } else if (what == "step") {
    EachOfStep(c.steps.emplace_back(), see);
  } else if (what == "waypoint" && !c.steps.empty()) {
    Configuration q;
    see(q);
    return !line.fail() && c.steps.back().goal.path.push_back(q);
  } else {
    return false;
  }
  return !line.fail();
}

}  // namespace

void Number(CycleCase& c) {
  std::uint32_t id = 0;
  for (PlaneEstimate& plane : c.scene.planes) {
    plane.id = ++id;
  }
  id = 0;
  for (PipeEstimate& pipe : c.scene.pipes) {
    pipe.id = ++id;
  }
  id = 0;
  for (CaseStep& step : c.steps) {
    step.goal.id = ++id;
  }
}

void Write(const CycleCase& c, std::ostream& out) {
  out.precision(std::numeric_limits<double>::max_digits10);
  const Writer see{out};
  out << kFirstLine << "\nlaw";
  EachOfLaw(c, see);
  for (const CaseBox& box : c.boxes) {
    out << "\nbox";
    EachOfBox(box, see);
  }
  for (const PlaneEstimate& plane : c.scene.planes) {
    out << "\nplane";
    EachOfPlane(plane, see);
  }
  for (const PipeEstimate& pipe : c.scene.pipes) {
    out << "\npipe";
    EachOfPipe(pipe, see);
  }
  for (const CaseStep& step : c.steps) {
    out << "\nstep";
    EachOfStep(step, see);
    for (const Configuration& q : step.goal.path) {
      out << "\nwaypoint";
      see(q);
    }
  }
  out << '\n';
}

bool Read(std::istream& in, CycleCase& c, std::string& error) {
  c = {};
  std::string text;
  if (!std::getline(in, text) || text != kFirstLine) {
    error = "the first line is not \"" + std::string(kFirstLine) + '"';
    return false;
  }
  for (int number = 2; std::getline(in, text); ++number) {
    if (!ReadLine(text, c)) {
      error = "line " + std::to_string(number) + " is not understood";
      return false;
    }
  }
  if (c.steps.empty()) {
    error = "it has no step";
    return false;
  }
  Number(c);
  return true;
}

}  // namespace pipewright::timing
