// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace pipewright::timing {

/// A file without a name, gone at the end.
class TemporaryFile {
 public:
  TemporaryFile() : file_(std::tmpfile()) { EXPECT_NE(file_, nullptr); }
  explicit TemporaryFile(const std::string& contents) : TemporaryFile() {
    EXPECT_EQ(std::fwrite(contents.data(), 1, contents.size(), file_), contents.size());
    std::rewind(file_);
  }
  ~TemporaryFile() { std::fclose(file_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  std::FILE* get() const { return file_; }

  std::string Contents() {
    std::rewind(file_);
    std::string contents;
    for (int byte = std::fgetc(file_); byte != EOF; byte = std::fgetc(file_)) {
      contents.push_back(static_cast<char>(byte));
    }
    return contents;
  }

 private:
  std::FILE* file_;
};

}  // namespace pipewright::timing
