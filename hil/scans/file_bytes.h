// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace pipewright::hil {

/// Takes a little-endian file from front to back. After the first error it gives zeros and nothing,
/// and keeps that error, with the byte where it is. Memory follows the size of the file, not what
/// its counts claim.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path);

  bool good() const { return error_.empty(); }
  const std::string& error() const { return error_; }  ///< in words, without the file's name
  void Refuse(std::string why);

  void TakeMagic(const char (&magic)[5]);
  int TakeCount(const std::string& name, int least, int most);
  float TakeFloat(const std::string& name);
  /// Finite ones.
  Eigen::Vector3f TakeVector(const std::string& name);
  /// Any floats at all: a sensor's readings need not be numbers.
  std::vector<Eigen::Vector3f> TakePoints(const std::string& name, int count);
  /// The file must end here.
  void TakeEnd();

  static constexpr int kAnyCount = 1 << 30;

 private:
  void Take(void* to, std::uintmax_t bytes, const std::string& name);
  void CutShort(const std::string& name);

  std::ifstream file_;
  std::uintmax_t size_ = 0;
  std::uintmax_t at_ = 0;
  std::string error_;
};

}  // namespace pipewright::hil
