// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace pipewright::test {

inline std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void WriteFile(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  ASSERT_TRUE(file) << path;
}

/// An empty folder of the running test's own.
inline std::filesystem::path TestFolder() {
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "pipewright" /
                                       test.test_suite_name() / test.name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

struct CommandResult {
  int exit_code = -1;
  std::string out;
  std::string error;
};

/// Runs the program with arguments as a shell takes them, in `folder`, which also takes its output.
inline CommandResult RunCommand(const std::string& program, const std::string& arguments,
                                const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "stdout.txt";
  const std::filesystem::path error = folder / "stderr.txt";
  const std::string line = "cd '" + folder.string() + "' && '" + program + "' " + arguments +
                           " >'" + out.string() + "' 2>'" + error.string() + "'";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(out), ReadFile(error)};
}

}  // namespace pipewright::test
