// SPDX-License-Identifier: MIT
#include "hil/cli/qp_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "hil/cli/heap_watch.h"
#include "hil/cli/qp_sizes.h"
#include "hil/cli/run_figures.h"
#include "hil/qpb/kkt.h"

namespace pipewright::hil {

namespace {

using Json = nlohmann::ordered_json;

const char* Name(QpStatus status) {
  switch (status) {
    case QpStatus::kOptimal:
      return "optimal";
    case QpStatus::kInfeasible:
      return "infeasible";
    case QpStatus::kCapped:
      return "capped";
    case QpStatus::kInvalid:
      return "invalid";
  }
  return "?";
}

QpSizes AllSizes() {
  QpSizes sizes;
  AddQpSizes5(sizes);
  AddQpSizes10(sizes);
  AddQpSizes20(sizes);
  AddQpSizes32(sizes);
  return sizes;
}

/// Variables beside the slacks, and rows.
struct Extent {
  int variables = 0;
  int rows = 0;
};

Extent ExtentOf(const QpbProblem& p) { return {p.kept(), p.equalities() + p.inequalities()}; }

class QpRunner {
 public:
  QpRunner(const QpbSet& set, const QpOptions& options)
      : set_(set), options_(options), sizes_(AllSizes()) {}

  QpRun Run() {
    ChooseSizes();
    run_.answers.resize(set_.problems.size());
    for (int pass = 0; run_.error.empty() && pass < options_.repeat; ++pass) {
      Pass(pass == 0);
    }
    return std::move(run_);
  }

 private:
  SizedQp* SmallestFor(const Extent& extent) const {
    const auto fits = [&extent](const std::unique_ptr<SizedQp>& size) {
      return extent.variables <= size->variables() && extent.rows <= size->rows();
    };
    const auto found = std::find_if(sizes_.begin(), sizes_.end(), fits);
    return found == sizes_.end() ? nullptr : found->get();
  }

  /// An active set is handed on within one solver, so a warm set runs in one that holds all of it.
  void ChooseSizes() {
    Extent all;
    for (const QpbProblem& p : set_.problems) {
      const Extent extent = ExtentOf(p);
      all = {std::max(all.variables, extent.variables), std::max(all.rows, extent.rows)};
      chosen_.push_back(SmallestFor(extent));
      if (chosen_.back() == nullptr) {
        run_.error = fmt::format(
            "problem {}: {} variables beside its slacks and {} rows are too many; compiled in are "
            "{} and {}",
            chosen_.size() - 1, extent.variables, extent.rows, sizes_.back()->variables(),
            sizes_.back()->rows());
        return;
      }
    }
    if (options_.warm) {
      std::fill(chosen_.begin(), chosen_.end(), SmallestFor(all));
    }
  }

  void Pass(bool first) {
    for (std::size_t k = 0; k < set_.problems.size(); ++k) {
      const QpbProblem& p = set_.problems[k];
      SizedQp& size = *chosen_[k];
      if (k == 0 || !options_.warm) {
        size.Forget();
      }
      const QpMeasured measured = size.Solve(p);
      if (measured.status == QpStatus::kInvalid) {
        run_.error = fmt::format(
            "problem {}: H is not positive definite to rounding, or its numbers overflow", k);
        return;
      }
      QpAnswer& answer = run_.answers[k];
      answer.us = first ? measured.us : std::min(answer.us, measured.us);
      run_.heap_allocations += measured.allocations;
      if (first) {
        Take(p, measured, size, answer);
      }
    }
  }

  static void Take(const QpbProblem& p, const QpMeasured& measured, const SizedQp& size,
                   QpAnswer& answer) {
    answer.status = measured.status;
    answer.iterations = measured.iterations;
    if (measured.status != QpStatus::kInfeasible) {
      const QpbPoint at = size.Point(p);
      answer.x = at.x;
      answer.kkt = KktResidual(p, at);
    }
    answer.as_expected = p.infeasible
                             ? measured.status == QpStatus::kInfeasible
                             : measured.status == QpStatus::kOptimal && answer.kkt <= kQpLargestKkt;
  }

  const QpbSet& set_;
  const QpOptions& options_;
  QpSizes sizes_;
  std::vector<SizedQp*> chosen_;  ///< one a problem
  QpRun run_;
};

/// A warm set's first problem is left out, unless it is the only one: it starts cold.
std::vector<float> Times(const QpRun& run, const QpOptions& options) {
  std::vector<float> us;
  for (const QpAnswer& answer : run.answers) {
    us.push_back(static_cast<float>(answer.us));
  }
  if (options.warm && us.size() > 1) {
    us.erase(us.begin());
  }
  return us;
}

Json Rounded(double us) { return std::round(us * 1e3) / 1e3; }

}  // namespace

QpRun RunQpSet(const QpbSet& set, const QpOptions& options) { return QpRunner(set, options).Run(); }

bool Passed(const QpRun& run) {
  return run.error.empty() && std::all_of(run.answers.begin(), run.answers.end(),
                                          [](const QpAnswer& a) { return a.as_expected; });
}

Json QpJson(const QpbSet& set, const QpRun& run, const QpOptions& options) {
  Json problems = Json::array();
  Json unexpected = Json::array();
  for (std::size_t k = 0; k < run.answers.size(); ++k) {
    const QpAnswer& a = run.answers[k];
    problems.push_back({{"status", Name(a.status)},
                        {"iterations", a.iterations},
                        {"kkt", a.status == QpStatus::kOptimal ? Json(a.kkt) : Json(nullptr)},
                        {"us", Rounded(a.us)},
                        {"x", a.x}});
    if (!a.as_expected) {
      unexpected.push_back(k);
    }
  }
  const std::vector<float> us = Times(run, options);
  const Json allocations = HeapWatch::Counting() ? Json(run.heap_allocations) : Json(nullptr);
  return {{"file", options.file},
          {"problem_count", set.problems.size()},
          {"is_sequence", set.is_sequence},
          {"warm", options.warm},
          {"passes", options.repeat},
          {"us",
           {{"p50", Rounded(Percentile(us, 0.5))},
            {"p99", Rounded(Percentile(us, 0.99))},
            {"max", Rounded(Percentile(us, 1))}}},
          {"heap_allocations", allocations},
          {"unexpected", unexpected},
          {"problems", problems}};
}

std::string QpTable(const QpbSet& set, const QpRun& run, const QpOptions& options) {
  std::string table = "problem  status      iterations  KKT residual       us\n";
  int wrong = 0;
  for (std::size_t k = 0; k < run.answers.size(); ++k) {
    const QpAnswer& a = run.answers[k];
    const bool optimal = a.status == QpStatus::kOptimal;
    table += fmt::format("{:7}  {:<10}  {:10}  {:>12}  {:7.2f}{}\n", k, Name(a.status),
                         a.iterations, optimal ? fmt::format("{:.1e}", a.kkt) : "-", a.us,
                         a.as_expected                    ? ""
                         : set.problems[k].infeasible     ? "  expected infeasible"
                         : a.status == QpStatus::kOptimal ? "  no optimum in the file's numbers"
                                                          : "  expected optimal");
    wrong += !a.as_expected;
  }
  const std::vector<float> us = Times(run, options);
  table += fmt::format(
      "{}: {} problems, {} not as expected; {}, least of {} passes: p50 {:.2f} us, p99 {:.2f} us, "
      "max {:.2f} us; heap allocations {}\n",
      options.file, set.problems.size(), wrong, options.warm ? "warm but for the first" : "cold",
      options.repeat, Percentile(us, 0.5), Percentile(us, 0.99), Percentile(us, 1),
      HeapWatch::Counting() ? fmt::format("{}", run.heap_allocations) : "not counted");
  return table;
}

}  // namespace pipewright::hil
