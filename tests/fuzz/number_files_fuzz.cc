// SPDX-License-Identifier: MIT
// Binary files of numbers, told apart by their first four bytes: QPB1 problems, scans, views, rays.
#include "hil/qpb/qpb.h"
#include "hil/scans/scan_file.h"
#include "tests/fuzz/memory_file.h"

namespace pipewright::test {
namespace {

void RequireShape(const hil::QpbProblem& p) {
  const auto n = static_cast<std::size_t>(p.n);
  const auto me = static_cast<std::size_t>(p.equalities());
  const auto mi = static_cast<std::size_t>(p.inequalities());
  Require(p.n >= 1 && p.H.size() == n * n && p.g.size() == n && p.Ae.size() == me * n &&
              p.Ai.size() == mi * n && p.u.size() == mi && p.lb.size() == n && p.ub.size() == n,
          "a problem's matrices have its sizes");
  Require(p.kept() >= 1, "not all variables are slacks");
  for (const int row : p.soft_row) {
    Require(0 <= row && row < p.inequalities(), "a softened row is there");
  }
}

}  // namespace
}  // namespace pipewright::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  using test::Require;
  const test::MemoryFile file(bytes, size);
  const hil::QpbResult problems = hil::ReadQpb(file.path());
  Require(problems.set.has_value() == problems.error.empty(), "a set of problems, or an error");
  if (problems.set) {
    for (const hil::QpbProblem& problem : problems.set->problems) {
      test::RequireShape(problem);
    }
  }
  const auto scans = hil::ReadScans(file.path());
  Require(scans.content.has_value() == scans.error.empty(), "scans, or an error");
  const auto views = hil::ReadViews(file.path());
  Require(views.content.has_value() == views.error.empty(), "views, or an error");
  const auto rays = hil::ReadRays(file.path());
  Require(rays.content.has_value() == rays.error.empty(), "rays, or an error");
  return 0;
}
