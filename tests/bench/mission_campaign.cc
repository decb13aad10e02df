// SPDX-License-Identifier: MIT
#include "tests/bench/mission_campaign.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>

namespace pipewright::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kBadInput = 2;  ///< pipewright's exit code

/// What Campaign::Run waits for. Blocked and taken from the queue, none comes between a look and a
/// wait.
sigset_t Awaited() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGCHLD, SIGINT, SIGTERM}) {
    sigaddset(&set, signal);
  }
  return set;
}

std::string LastLine(const fs::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    last = line.empty() ? last : line;
  }
  return last;
}

}  // namespace

std::string Stem(const std::string& name_or_file) { return fs::path(name_or_file).stem().string(); }

Campaign::Campaign(const CampaignOptions& options, const fs::path& folder, bool keep)
    : keep_(keep) {
  if (options.faults) {
    faults_ = {"--faults", *options.faults};
  }
  jobs_ = static_cast<std::size_t>(options.jobs);
  const std::string faults = options.faults ? "-" + Stem(*options.faults) : "";
  for (const std::string& scenario : options.scenarios) {
    for (std::uint64_t i = 0; i <= options.last_seed - options.first_seed; ++i) {
      const std::uint64_t seed = options.first_seed + i;
      Mission mission;
      mission.scenario = scenario;
      mission.run.scenario = Stem(scenario);
      mission.run.seed = seed;
      mission.folder = folder / fmt::format("{}{}-{}", Stem(scenario), faults, seed);
      mission.log = mission.folder.string() + ".log";
      waiting_.push_back(mission);
    }
  }
  std::reverse(waiting_.begin(), waiting_.end());
}

void Campaign::Start(Mission mission) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "pipewright";
  std::vector<std::string> words = {program.string(), "inspect",
                                    "--scenario",     mission.scenario,
                                    "--seed",         std::to_string(mission.run.seed),
                                    "--out",          mission.folder.string()};
  words.insert(words.end(), faults_.begin(), faults_.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, mission.log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  // In a process group of its own a mission does not see the terminal's Ctrl-C, only ours.
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  std::error_code ignored;
  fs::remove(mission.folder / "run.json", ignored);  // an earlier campaign's says nothing of this
  pid_t pid = 0;
  const int error =
      posix_spawn(&pid, program.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);

  mission.start = Clock::now();
  if (error == 0) {
    running_.emplace(pid, std::move(mission));
  } else {
    mission.run.stop = "crashed";
    mission.run.detail = fmt::format("{}: {}", program.string(), std::strerror(error));
    runs_.push_back(mission.run);
  }
}

/// What became of a mission whose process has ended, and what it left of its evidence.
void Campaign::End(Mission& mission, int status) {
  MissionRun& run = mission.run;
  run.wall_s = std::chrono::duration<double>(Clock::now() - mission.start).count();
  if (WIFEXITED(status) && WEXITSTATUS(status) == kBadInput) {
    run.stop = "refused";
    run.detail = LastLine(mission.log);
    refused_ = true;
    Stop();
  } else if (WIFEXITED(status)) {
    ReadRun(mission.folder / "run.json", run);
    if (!run.read) {
      run.stop = "crashed";
      run.detail = fmt::format("exit code {}: {}", WEXITSTATUS(status), run.detail);
    } else if (stopping_ && run.stop == "none") {
      run.stop = "interrupted";
    }
  } else {
    run.stop = stopping_ && WTERMSIG(status) == SIGTERM ? "interrupted" : "crashed";
    run.detail = fmt::format("signal {}: {}", WTERMSIG(status), LastLine(mission.log));
  }
  if (!keep_) {
    std::error_code ignored;
    fs::remove_all(mission.folder, ignored);  // tens of MB each, and missions may be many
    fs::remove(mission.log, ignored);
  }
}

/// Starts no more, and asks those that run to come to rest and say how far they got.
void Campaign::Stop() {
  stopping_ = true;
  not_started_ += waiting_.size();
  waiting_.clear();
  for (const auto& [pid, mission] : running_) {
    kill(pid, SIGTERM);
  }
}

void Campaign::Run(std::FILE* to) {
  const sigset_t awaited = Awaited();
  sigprocmask(SIG_BLOCK, &awaited, nullptr);
  fmt::print(to, "{}", RunHead());
  std::size_t printed = 0;
  while (!waiting_.empty() || !running_.empty()) {
    while (!waiting_.empty() && running_.size() < jobs_) {
      const Mission next = waiting_.back();
      waiting_.pop_back();
      Start(next);
    }
    int signal = SIGCHLD;
    if (!running_.empty() && sigwait(&awaited, &signal) == 0 && signal != SIGCHLD) {
      Stop();
    }
    int status = 0;
    for (pid_t pid = 0; (pid = waitpid(-1, &status, WNOHANG)) > 0;) {
      auto ended = running_.extract(pid);
      End(ended.mapped(), status);
      runs_.push_back(ended.mapped().run);
    }
    for (; printed < runs_.size(); ++printed) {
      fmt::print(to, "{}", RunLine(runs_[printed], waiting_.size() + running_.size()));
      std::fflush(to);
    }
  }
}

}  // namespace pipewright::bench
