// SPDX-License-Identifier: MIT
// Every kind of fault that the robot is to survive, injected many times: what came of it.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/bench/faults/rows.h"
#include "tests/bench/mission_figures.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> rows;
  std::uint64_t n = 0;  ///< 0: each row's own
  std::uint64_t seed = 1;
  int patience_s = 3600;  ///< for one row; then it hangs
  bool json = false;
};

struct RowResult {
  const Row* row;
  Tally tally;
  double wall_s = 0;
};

Json ToJson(const Tally& tally) {
  return {{"counts", tally.counts}, {"latencies_ms", tally.latencies_ms}, {"notes", tally.notes}};
}

Tally TallyOf(const Json& json) {
  Tally tally;
  tally.counts = json["counts"].get<decltype(tally.counts)>();
  tally.latencies_ms = json["latencies_ms"].get<std::vector<double>>();
  tally.notes = json["notes"].get<std::vector<std::string>>();
  return tally;
}

/// All that comes until the other end is closed; false: not within `patience_s`.
bool ReadAll(int from, int patience_s, std::string& text) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(patience_s);
  char bytes[4096];
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd wait{from, POLLIN, 0};
    if (left.count() <= 0 || poll(&wait, 1, static_cast<int>(left.count())) == 0) {
      return false;
    }
    const ssize_t count = read(from, bytes, sizeof bytes);
    if (count <= 0) {
      return true;
    }
    text.append(bytes, static_cast<std::size_t>(count));
  }
}

/// In a process of its own: a crash or a hang is a count, not the end.
Tally RunApart(const Row& row, const Options& options) {
  const std::uint64_t n = options.n != 0 ? options.n : row.n;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    Tally tally;
    tally.Add(Outcome::kCrash);
    tally.Note("no pipe");
    return tally;
  }
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    const std::string text = ToJson(row.run(n, options.seed)).dump();
    std::size_t written = 0;
    while (written < text.size()) {
      const ssize_t count = write(ends[1], text.data() + written, text.size() - written);
      if (count <= 0) {
        break;
      }
      written += static_cast<std::size_t>(count);
    }
    _exit(written == text.size() ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  const bool ended = child > 0 && ReadAll(ends[0], options.patience_s, text);
  close(ends[0]);
  if (child > 0 && !ended) {
    kill(child, SIGKILL);
  }
  int status = -1;
  if (child > 0) {
    waitpid(child, &status, 0);
  }
  const Json json = Json::parse(text, nullptr, false);
  if (ended && WIFEXITED(status) && WEXITSTATUS(status) == 0 && !json.is_discarded()) {
    return TallyOf(json);
  }
  Tally tally;
  tally.Add(Outcome::kCrash);
  tally.Note(!ended                ? fmt::format("no answer within {} s", options.patience_s)
             : WIFSIGNALED(status) ? fmt::format("ended by signal {}", WTERMSIG(status))
                                   : "ended early");
  return tally;
}

std::uint64_t Bad(const Tally& tally) {
  return tally.of(Outcome::kWrong) + tally.of(Outcome::kCrash);
}

/// 95 % bound of W + C.
double Bound(const Tally& tally) {
  return RateBound95(static_cast<int>(Bad(tally)), static_cast<int>(tally.n()));
}

void Print(const RowResult& result) {
  const Tally& t = result.tally;
  fmt::print(
      "{:<4} {:<40} {:>8} {:>8} {:>7} {:>5} {:>3} {:>3} {:>7.1f} {:>7.1f} {:>8.1e} {:>6.1f}\n",
      result.row->id, result.row->what, t.n(), t.of(Outcome::kMasked), t.of(Outcome::kSafeStop),
      t.of(Outcome::kLate), t.of(Outcome::kWrong), t.of(Outcome::kCrash),
      Quantile(t.latencies_ms, 0.5), Quantile(t.latencies_ms, 1), Bound(t), result.wall_s);
  for (const std::string& note : t.notes) {
    fmt::print("       {}\n", note);
  }
  std::fflush(stdout);
}

Json ToJson(const RowResult& result) {
  const Tally& t = result.tally;
  Json json{{"row", result.row->id}, {"what", result.row->what}, {"n", t.n()}};
  for (int i = 0; i < kOutcomes; ++i) {
    json[std::string(1, kOutcomeLetters[static_cast<std::size_t>(i)])] =
        t.counts[static_cast<std::size_t>(i)];
  }
  json["seen"] = t.latencies_ms.size();
  json["latency_p50_ms"] = Quantile(t.latencies_ms, 0.5);
  json["latency_max_ms"] = Quantile(t.latencies_ms, 1);
  json["wrong_or_crash_95"] = Bound(t);
  json["wall_s"] = result.wall_s;
  json["notes"] = t.notes;
  return json;
}

int RunRows(const Options& options) {
  std::vector<RowResult> results;
  if (!options.json) {
    fmt::print("{:<4} {:<40} {:>8} {:>8} {:>7} {:>5} {:>3} {:>3} {:>7} {:>7} {:>8} {:>6}\n", "row",
               "fault", "N", "M", "S", "L", "W", "C", "p50 ms", "max ms", "W+C 95%", "wall s");
  }
  for (const Row& row : Rows()) {
    if (!options.rows.empty() &&
        std::find(options.rows.begin(), options.rows.end(), row.id) == options.rows.end()) {
      continue;
    }
    const auto start = std::chrono::steady_clock::now();
    RowResult result{&row, RunApart(row, options)};
    result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!options.json) {
      Print(result);
    }
    results.push_back(std::move(result));
  }
  std::uint64_t bad = 0;
  std::uint64_t late = 0;
  for (const RowResult& result : results) {
    bad += Bad(result.tally);
    late += result.tally.of(Outcome::kLate);
  }
  if (options.json) {
    Json out{{"seed", options.seed}, {"rows", Json::array()}};
    for (const RowResult& result : results) {
      out["rows"].push_back(ToJson(result));
    }
    fmt::print("{}\n", out.dump(2));
  }
  return bad == 0 && late == 0 ? 0 : 1;
}

std::string Footer() {
  std::string text =
      "M masked: the limits held and the robot went on     S safe stop: standstill within its "
      "bound\n"
      "L late: after the bound, or never                   W wrong: an unlawful command, or what "
      "had\n"
      "C crash: the process died or did not answer           to be refused was taken\n"
      "ms: from the fault until the program (F1: the base's watchdog) saw it. W+C 95%: upper "
      "bound.\n"
      "\n"
      "Who judges: not the program. Commands are read off the wire by their bytes and held "
      "against\n"
      "the robot's limits (0.4 m/s, 0.8 m/s^2; 1 rad/s, 2 rad/s^2; joints 1 rad/s, 10 rad/s^2; of\n"
      "growth, over any time T by no more than a (T + 40 ms); towards zero any step is lawful, "
      "for\n"
      "devices have ramps of their own). Standstill is the emulated motors'. Unless a row says\n"
      "otherwise it is due 700 ms after the fault: seen in 100, braked in 500, 100 for the wire.\n"
      "The robot goes to and fro in an empty hall; contacts are what F17 and F18 look for.\n";
  for (const Row& row : Rows()) {
    text += fmt::format("\n{:<4} {}: {}. N = {}\n", row.id, row.what, row.rule, row.n);
  }
  return text + "\nExit code: 0 no L, W or C; 1 some; 2 bad usage.";
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  namespace bench = pipewright::bench;
  bench::Options options;
  CLI::App app("Faults injected into the robot program and its devices, in virtual time",
               "bench_faults");
  app.add_option("--row", options.rows, "only these, with commas between: F3,F9")->delimiter(',');
  app.add_option("--n", options.n, "cases of each row, in place of its own number");
  app.add_option("--seed", options.seed, "of all that is drawn")->capture_default_str();
  app.add_option("--patience", options.patience_s, "seconds after which a row counts as hanging")
      ->check(CLI::Range(1, 86400))
      ->capture_default_str();
  app.add_flag("--json", options.json, "one JSON object on stdout");
  app.footer(bench::Footer());
  try {
    app.parse(argc, argv);
    for (const std::string& name : options.rows) {
      const auto rows = bench::Rows();
      if (std::none_of(rows.begin(), rows.end(), [&](const auto& r) { return name == r.id; })) {
        throw CLI::ValidationError("--row", name + ": no such row");
      }
    }
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return bench::RunRows(options);
}
