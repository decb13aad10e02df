// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pipewright::hil {

/// Writes an MCAP file (mcap.dev, version 0) from front to back: messages in chunks of zstd, each
/// with its checksum and an index by channel and time, and at the end a summary with all schemas
/// and channels, the statistics and the index of the chunks.
///
/// Memory: one chunk, plain and packed, the index of its messages, and some 100 bytes for each
/// chunk before. After the first failure nothing more is written.
class McapWriter {
 public:
  static constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  ///< unpacked, and one message

  McapWriter();
  /// A file that was not closed has no end, and is no whole MCAP file.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Begins the file anew. @param profile  what its messages are by: "ros2", or ""
  /// @returns an error in words, without the path, or nothing
  std::string Open(const std::string& path, std::string_view profile);

  /// @returns the schema's number, the channel's number
  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view text);
  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic,
                           std::string_view message_encoding);
  void Write(std::uint16_t channel, std::int64_t time_ns, std::string_view message);

  /// Writes what is left, the summary and the end. @returns an error in words, or nothing
  std::string Close();
  bool failed() const { return failed_; }

  std::uint64_t messages(std::uint16_t channel) const { return channels_[channel].messages; }
  std::uint64_t bytes() const { return position_; }  ///< of the file so far

 private:
  struct Channel {
    std::string record;
    std::uint64_t messages = 0;
    /// Time and place of those in the chunk that is being filled.
    std::vector<std::pair<std::uint64_t, std::uint64_t>> in_chunk;
  };
  struct Chunk {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
    std::uint64_t index_bytes = 0;
    std::uint64_t packed_bytes = 0;
    std::uint64_t plain_bytes = 0;
    std::vector<std::pair<std::uint16_t, std::uint64_t>> index_of_channel;
  };
  class Packer;

  void EndChunk();
  void WriteIndexes(Chunk& chunk);
  void WriteSummary();
  std::string StatisticsRecord() const;
  void Put(std::string_view bytes);

  std::FILE* file_ = nullptr;
  bool failed_ = false;
  int error_ = 0;  ///< errno of the first failure
  std::uint64_t position_ = 0;
  std::uint32_t checksum_ = 0;  ///< of what was written since the section began
  std::unique_ptr<Packer> packer_;
  std::string records_;  ///< the chunk that is being filled
  std::uint64_t chunk_first_ns_ = 0;
  std::uint64_t chunk_last_ns_ = 0;
  bool chunk_has_message_ = false;
  std::vector<std::string> schemas_;  ///< their records
  std::vector<Channel> channels_;
  std::vector<Chunk> chunks_;
};

}  // namespace pipewright::hil
