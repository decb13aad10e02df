// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>

namespace pipewright::hil {

/// The bytes of a file or of standard input, unpacked if they are gz or zstd: their first bytes
/// tell, not the name. Memory: two buffers of 64 KiB and the unpacker's window, at most 128 MiB.
class ByteSource {
 public:
  ByteSource();
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  /// @param path  "-": standard input
  /// @returns an error in words, without the path, or nothing
  std::string Open(const std::string& path);
  /// Takes over a stream that is open for reading.
  void Open(std::FILE* file);

  /// Fills `out` from the front, with less only at the end; 0: the end.
  std::size_t Read(std::span<char> out);

  /// Why the end came before that of the data, in words; empty if it did not.
  const std::string& error() const { return error_; }
  /// Bytes read of the file itself, and how many it has; 0: not known.
  std::uint64_t file_position() const { return position_; }
  std::uint64_t file_size() const { return size_; }
  /// Bytes given so far that are beyond doubt: of packed data, those of the members or frames that
  /// came to their ends, checksums included.
  std::uint64_t certain() const { return certain_; }
  const char* packing() const;  ///< "gz", "zstd" or "none"

 private:
  class Unpacker;
  class Inflate;
  class Zstd;

  std::size_t ReadPlain(std::span<char> out);
  std::size_t ReadFile(std::span<char> out);
  void Refill();

  std::FILE* file_ = nullptr;
  std::unique_ptr<Unpacker> unpacker_;
  std::unique_ptr<char[]> packed_;
  std::span<const char> input_;  ///< of packed_: read and not yet used
  std::uint64_t position_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t given_ = 0;
  std::uint64_t certain_ = 0;
  std::string error_;
};

}  // namespace pipewright::hil
