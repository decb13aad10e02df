// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "platform/core/depth_frame.h"

namespace pipewright::hil {

/// Writes a depth recording, frame by frame. The first write that fails, on a full disk say, is the
/// last: what is there stays readable, and Close() tells.
class DepthWriter {
 public:
  DepthWriter();
  ~DepthWriter();

  /// @returns whether the file can be written
  bool Open(const std::filesystem::path& path);
  bool is_open() const { return file_.is_open(); }

  /// A frame that the robot program gets at `given`.
  void Add(const DepthFrame& frame, Time given);

  /// Marks the end. False: not everything could be written.
  bool Close();

 private:
  struct Packer;

  template <typename T>
  void Put(const T& value);
  void PutDepths(std::span<const std::uint16_t> depth_mm);
  void WriteItem();

  std::ofstream file_;
  std::unique_ptr<Packer> packer_;
  std::vector<char> item_;
  std::vector<char> packed_;
  std::optional<CameraIntrinsics> camera_;
  std::uint32_t frames_ = 0;
};

}  // namespace pipewright::hil
