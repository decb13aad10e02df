// SPDX-License-Identifier: MIT
// Whether the chance constraints hold with the probability they state, and what that costs: for
// every probability, mode and primitive, over cycles of the controller in closed loop in which the
// constraint decides u. svfi_share.h says what the shares are of.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/svfi_share.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kAlphas[] = {0.7, 0.9, 0.95, 0.99, 0.999};

/// What is uncertain. (A cell without its probability and mode.)
struct Variant {
  const char* name;
  Cell cell;
};
constexpr Variant kVariants[] = {
    {"plane", {.primitive = Primitive::kPlane}},
    {"pipe", {.primitive = Primitive::kPipe}},
    {"pipe end", {.primitive = Primitive::kPipeEnd}},
    {"voxel", {.primitive = Primitive::kVoxel}},
    {"plane+q", {.primitive = Primitive::kPlane, .unsure = true}},
    {"pipe+q", {.primitive = Primitive::kPipe, .unsure = true}},
    {"voxel+q", {.primitive = Primitive::kVoxel, .unsure = true}},
    {"joint", {.primitive = Primitive::kPlane, .joint = true}},
};
constexpr int kModes = static_cast<int>(std::size(kSvfiModes));
constexpr int kCellsPerVariant = static_cast<int>(std::size(kAlphas)) * kModes;

struct Options {
  int draws = 100000;
  int estimates = 100000;
  int episodes = 60;
  std::uint64_t seed = 1;
  std::string only;  ///< a variant's name; empty: all
  bool json = false;
};

/// One cell's figures.
struct Figures {
  LoopResult loop;
  TruthShares rising;
  TruthShares rest;
  TruthShares worst;  ///< of the one cycle with the least margin
  Share lived;
};

/// holds: the lower bound is alpha or more. agrees: alpha is within the bounds. FAILS: it is not.
const char* Verdict(const Share& share, double alpha) {
  if (share.draws == 0) {
    return "none";
  }
  return share.lower() >= alpha ? "holds" : share.upper() >= alpha ? "agrees" : "FAILS";
}

Figures Measure(const Cell& cell, const Options& options) {
  constexpr int kKeep = 200;
  Figures figures;
  figures.loop = RunLoops(cell, options.episodes, kKeep, options.seed);
  Rng rng(options.seed, 2);
  figures.rising = DrawTruths(figures.loop.rising.sample, options.draws, rng);
  figures.rest = DrawTruths(figures.loop.rest.sample, options.draws, rng);
  if (figures.loop.rising.cycles + figures.loop.rest.cycles > 0) {
    figures.worst = DrawTruths({&figures.loop.worst, 1}, options.draws, rng);
  }
  figures.lived = DrawEstimates(figures.loop.rising.sample, options.estimates / 2, rng);
  figures.lived += DrawEstimates(figures.loop.rest.sample, options.estimates / 2, rng);
  return figures;
}

double Mean(double a, double b, long count) {
  return count > 0 ? (a + b) / static_cast<double>(count) : 0;
}

Json ToJson(const Share& share, double alpha) {
  return {{"share", share.value()},
          {"lower99", share.lower()},
          {"upper99", share.upper()},
          {"draws", share.draws},
          {"verdict", Verdict(share, alpha)}};
}

Json ToJson(const Leaned& leaned, const TruthShares& shares, double alpha) {
  return {{"cycles", leaned.cycles},
          {"first_order", ToJson(shares.first_order, alpha)},
          {"full", ToJson(shares.full, alpha)},
          {"with_buffer", ToJson(shares.with_buffer, alpha)},
          {"z_margin_mean", Mean(leaned.margin_sum, 0, leaned.cycles)},
          {"z_margin_min", leaned.margin_min},
          {"z_margin_with_buffer_min", leaned.row_margin_min},
          {"slack_mean_mps", Mean(leaned.slack_sum_mps, 0, leaned.cycles)}};
}

Json ToJson(const char* name, const Cell& cell, const Figures& f) {
  return {{"primitive", name},
          {"q_uncertain", cell.unsure},
          {"joint_risk", cell.joint},
          {"alpha", cell.alpha},
          {"mode", Name(cell.mode)},
          {"rising", ToJson(f.loop.rising, f.rising, cell.alpha)},
          {"rest", ToJson(f.loop.rest, f.rest, cell.alpha)},
          {"worst_cycle",
           {{"first_order", ToJson(f.worst.first_order, cell.alpha)},
            {"full", ToJson(f.worst.full, cell.alpha)}}},
          {"estimate_drawn", ToJson(f.lived, cell.alpha)},
          {"clamped_cycles", f.loop.clamped},
          {"episodes", f.loop.episodes},
          {"episodes_kept", f.loop.episodes_kept},
          {"penetration_mm", f.loop.penetration_mm}};
}

void PrintHead(const Options& options) {
  fmt::print(
      "seed {}; a cell: {} true surfaces a kind of cycle, {} estimates, {} closed loops\n"
      "truth: share of true surfaces, drawn about the estimate, for which the VFI holds at the u\n"
      "  that is sent: first order, its lower bound (99 %, Wilson), full: drawn on the manifold.\n"
      "  holds: the bound is alpha or more; agrees: alpha is within both bounds; FAILS: neither\n"
      "rising: cycles in which sigma_f is 1 % or more above that of the u before; rest: the "
      "others;\n"
      "  worst: the one cycle with the least margin\n"
      "lived: the truth is fixed and the estimate drawn, from which u is chosen; both bounds\n"
      "+q: the robot's q is drawn, too (3 mm, 3 mrad, 1 mrad a joint); joint: alpha is of all "
      "rows\n"
      "  of a cycle together, and so are the shares\n"
      "margin: mean of (b - a'u)/sigma_f - z; slack: mean of b - a'u - z sigma_f in mm/s\n"
      "deep: by how much the true surface came nearer than d_safe at worst, in mm; kept: loops in\n"
      "  which it never did; clamped: cycles in which standing still already had less than "
      "alpha\n\n"
      "{:<8} {:>5} {:<17} | {:>6} {:>7} {:>7} {:<6} {:>7} | {:>7} {:<6} | {:>6} {:>7} {:>7} {:<6} "
      "{:>7} | {:>7} {:>15} | {:>6} {:>6} | {:>5} {:>5} {:>7}\n",
      options.seed, options.draws, options.estimates, options.episodes, "", "alpha", "mode",
      "rising", "truth", "lower", "", "full", "worst", "", "rest", "truth", "lower", "", "full",
      "lived", "bounds", "margin", "slack", "deep", "kept", "clamped");
}

void Print(const char* name, const Cell& cell, const Figures& f) {
  const Leaned& up = f.loop.rising;
  const Leaned& rest = f.loop.rest;
  const long cycles = up.cycles + rest.cycles;
  const auto truth = [&](const Leaned& leaned, const TruthShares& s) {
    return fmt::format("{:>6} {:>7.4f} {:>7.4f} {:<6} {:>7.4f}", leaned.cycles,
                       s.first_order.value(), s.first_order.lower(),
                       Verdict(s.first_order, cell.alpha), s.full.value());
  };
  fmt::print(
      "{:<8} {:>5} {:<17} | {} | {:>7.4f} {:<6} | {} | {:>7.4f} {:.4f} - {:.4f} | {:>6.3f} "
      "{:>6.2f} | {:>5.1f} {:>4.0f}% {:>7}\n",
      name, cell.alpha, Name(cell.mode), truth(up, f.rising), f.worst.first_order.value(),
      Verdict(f.worst.first_order, cell.alpha), truth(rest, f.rest), f.lived.value(),
      f.lived.lower(), f.lived.upper(), Mean(up.margin_sum, rest.margin_sum, cycles),
      1000 * Mean(up.slack_sum_mps, rest.slack_sum_mps, cycles), f.loop.penetration_mm,
      100.0 * f.loop.episodes_kept / f.loop.episodes, f.loop.clamped);
  std::fflush(stdout);
}

/// 1 when `exact` is refuted somewhere.
int Run(const Options& options) {
  Json out{{"seed", options.seed},
           {"draws", options.draws},
           {"estimates", options.estimates},
           {"episodes", options.episodes},
           {"cells", Json::array()}};
  if (!options.json) {
    PrintHead(options);
  }
  int failed = 0;
  for (const Variant& variant : kVariants) {
    if (!options.only.empty() && options.only != variant.name) {
      continue;
    }
    for (int i = 0; i < kCellsPerVariant; ++i) {
      Cell cell = variant.cell;
      cell.alpha = kAlphas[i / kModes];
      cell.mode = kSvfiModes[i % kModes];
      if (options.json) {  // the table grows by itself
        fmt::print(stderr, "{} {}/{} {} {}\n", variant.name, i + 1, kCellsPerVariant, cell.alpha,
                   Name(cell.mode));
      }
      const Figures figures = Measure(cell, options);
      for (const TruthShares* shares : {&figures.rising, &figures.rest}) {
        failed += cell.mode == SvfiMode::kExact && shares->first_order.upper() < cell.alpha ? 1 : 0;
      }
      out["cells"].push_back(ToJson(variant.name, cell, figures));
      if (!options.json) {
        Print(variant.name, cell, figures);
      }
    }
  }
  out["exact_refuted"] = failed;
  if (options.json) {
    fmt::print("{}\n", out.dump(2));
  }
  return failed > 0 ? 1 : 0;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  pipewright::bench::Options options;
  CLI::App app("Monte Carlo of the chance constraints (stochastic VFIs)", "bench_svfi");
  app.add_option("--draws", options.draws, "true surfaces a kind of cycle")
      ->check(CLI::Range(1000, 100000000))
      ->capture_default_str();
  app.add_option("--estimates", options.estimates, "estimates a cell; each is a control cycle")
      ->check(CLI::Range(2, 100000000))
      ->capture_default_str();
  app.add_option("--episodes", options.episodes, "closed loops a cell")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of everything that is drawn")->capture_default_str();
  std::vector<std::string> names;
  for (const auto& variant : pipewright::bench::kVariants) {
    names.emplace_back(variant.name);
  }
  app.add_option("--only", options.only, "one primitive")->check(CLI::IsMember(names));
  app.add_flag("--json", options.json, "one JSON object on stdout");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::bench::Run(options);
}
