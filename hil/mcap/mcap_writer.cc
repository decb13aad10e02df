// SPDX-License-Identifier: MIT
#include "hil/mcap/mcap_writer.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hil/mcap/little_endian.h"

namespace pipewright::hil {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::string_view kLibrary = "pipewright";
constexpr std::string_view kPacking = "zstd";
constexpr int kPackingLevel = 3;

enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

void AppendText(std::string& to, std::string_view text) {
  AppendNumber(to, static_cast<std::uint32_t>(text.size()));
  to.append(text);
}

/// An array or map of pairs, by its length in bytes.
template <typename A, typename B>
void AppendPairs(std::string& to, const std::vector<std::pair<A, B>>& pairs) {
  AppendNumber(to, static_cast<std::uint32_t>(pairs.size() * (sizeof(A) + sizeof(B))));
  for (const auto& [a, b] : pairs) {
    AppendNumber(to, a);
    AppendNumber(to, b);
  }
}

void AppendHead(std::string& to, Op op, std::size_t bytes) {
  to += static_cast<char>(op);
  AppendNumber(to, static_cast<std::uint64_t>(bytes));
}

std::string Record(Op op, std::string_view content) {
  std::string record;
  AppendHead(record, op, content.size());
  return record.append(content);
}

std::uint32_t Checksum(std::uint32_t before, std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

class McapWriter::Packer {
 public:
  Packer() : context_(ZSTD_createCCtx()) {}
  ~Packer() { ZSTD_freeCCtx(context_); }
  Packer(const Packer&) = delete;
  Packer& operator=(const Packer&) = delete;

  /// Valid until the next call.
  std::string_view Pack(std::string_view plain) {
    packed_.resize(std::max(packed_.size(), ZSTD_compressBound(plain.size())));
    const std::size_t bytes = ZSTD_compressCCtx(context_, packed_.data(), packed_.size(),
                                                plain.data(), plain.size(), kPackingLevel);
    return {packed_.data(), bytes};  // cannot fail: there is room for the worst
  }

 private:
  ZSTD_CCtx* context_;
  std::string packed_;
};

McapWriter::McapWriter() : packer_(std::make_unique<Packer>()) {}

McapWriter::~McapWriter() {
  if (file_ != nullptr) {
    std::fclose(file_);
  }
}

std::string McapWriter::Open(const std::string& path, std::string_view profile) {
  file_ = std::fopen(path.c_str(), "wb");
  if (file_ == nullptr) {
    return std::strerror(errno);
  }
  std::string head;
  AppendText(head, profile);
  AppendText(head, kLibrary);
  Put(kMagic);
  Put(Record(Op::kHeader, head));
  return "";
}

std::uint16_t McapWriter::AddSchema(std::string_view name, std::string_view encoding,
                                    std::string_view text) {
  const auto number = static_cast<std::uint16_t>(schemas_.size() + 1);  // 0: no schema
  std::string content;
  AppendNumber(content, number);
  AppendText(content, name);
  AppendText(content, encoding);
  AppendText(content, text);
  schemas_.push_back(Record(Op::kSchema, content));
  records_ += schemas_.back();
  return number;
}

std::uint16_t McapWriter::AddChannel(std::uint16_t schema, std::string_view topic,
                                     std::string_view message_encoding) {
  const auto number = static_cast<std::uint16_t>(channels_.size());
  std::string content;
  AppendNumber(content, number);
  AppendNumber(content, schema);
  AppendText(content, topic);
  AppendText(content, message_encoding);
  AppendNumber(content, std::uint32_t{0});  // no metadata
  channels_.push_back({Record(Op::kChannel, content), 0, {}});
  records_ += channels_.back().record;
  return number;
}

void McapWriter::Write(std::uint16_t channel, std::int64_t time_ns, std::string_view message) {
  Channel& to = channels_[channel];
  const auto time = static_cast<std::uint64_t>(time_ns);
  const std::uint64_t at = records_.size();
  constexpr std::size_t kBefore = 2 + 4 + 8 + 8;
  AppendHead(records_, Op::kMessage, kBefore + message.size());
  AppendNumber(records_, channel);
  AppendNumber(records_, static_cast<std::uint32_t>(to.messages));
  AppendNumber(records_, time);  // logged
  AppendNumber(records_, time);  // published
  records_.append(message);
  to.in_chunk.emplace_back(time, at);
  ++to.messages;
  chunk_first_ns_ = chunk_has_message_ ? std::min(chunk_first_ns_, time) : time;
  chunk_last_ns_ = chunk_has_message_ ? std::max(chunk_last_ns_, time) : time;
  chunk_has_message_ = true;
  if (records_.size() >= kChunkBytes) {
    EndChunk();
  }
}

void McapWriter::EndChunk() {
  if (records_.empty()) {
    return;
  }
  const std::string_view packed = packer_->Pack(records_);
  Chunk chunk{.first_ns = chunk_first_ns_,
              .last_ns = chunk_last_ns_,
              .begin = position_,
              .packed_bytes = packed.size(),
              .plain_bytes = records_.size(),
              .index_of_channel = {}};
  std::string head;
  AppendNumber(head, chunk.first_ns);
  AppendNumber(head, chunk.last_ns);
  AppendNumber(head, chunk.plain_bytes);
  AppendNumber(head, Checksum(0, records_));
  AppendText(head, kPacking);
  AppendNumber(head, chunk.packed_bytes);
  std::string begin;
  AppendHead(begin, Op::kChunk, head.size() + packed.size());
  Put(begin);
  Put(head);
  Put(packed);
  chunk.bytes = position_ - chunk.begin;
  WriteIndexes(chunk);
  chunks_.push_back(std::move(chunk));
  records_.clear();
  chunk_first_ns_ = 0;
  chunk_last_ns_ = 0;
  chunk_has_message_ = false;
}

void McapWriter::WriteIndexes(Chunk& chunk) {
  const std::uint64_t begin = position_;
  for (std::size_t number = 0; number < channels_.size(); ++number) {
    auto& in_chunk = channels_[number].in_chunk;
    if (in_chunk.empty()) {
      continue;
    }
    std::sort(in_chunk.begin(), in_chunk.end());
    chunk.index_of_channel.emplace_back(static_cast<std::uint16_t>(number), position_);
    std::string index;
    AppendNumber(index, static_cast<std::uint16_t>(number));
    AppendPairs(index, in_chunk);
    Put(Record(Op::kMessageIndex, index));
    in_chunk.clear();
  }
  chunk.index_bytes = position_ - begin;
}

std::string McapWriter::StatisticsRecord() const {
  std::uint64_t messages = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> of_channel;
  for (std::size_t number = 0; number < channels_.size(); ++number) {
    messages += channels_[number].messages;
    of_channel.emplace_back(static_cast<std::uint16_t>(number), channels_[number].messages);
  }
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  bool any = false;
  for (const Chunk& chunk : chunks_) {
    if (!chunk.index_of_channel.empty()) {
      first = any ? std::min(first, chunk.first_ns) : chunk.first_ns;
      last = any ? std::max(last, chunk.last_ns) : chunk.last_ns;
      any = true;
    }
  }
  std::string content;
  AppendNumber(content, messages);
  AppendNumber(content, static_cast<std::uint16_t>(schemas_.size()));
  AppendNumber(content, static_cast<std::uint32_t>(channels_.size()));
  AppendNumber(content, std::uint32_t{0});  // attachments
  AppendNumber(content, std::uint32_t{0});  // metadata
  AppendNumber(content, static_cast<std::uint32_t>(chunks_.size()));
  AppendNumber(content, first);
  AppendNumber(content, last);
  AppendPairs(content, of_channel);
  return Record(Op::kStatistics, content);
}

void McapWriter::WriteSummary() {
  const std::uint64_t begin = position_;
  checksum_ = 0;
  std::string offsets;
  std::uint64_t group_begin = position_;
  const auto end_group = [&](Op op) {
    if (position_ > group_begin) {
      std::string content(1, static_cast<char>(op));
      AppendNumber(content, group_begin);
      AppendNumber(content, position_ - group_begin);
      offsets += Record(Op::kSummaryOffset, content);
    }
    group_begin = position_;
  };
  for (const std::string& schema : schemas_) {
    Put(schema);
  }
  end_group(Op::kSchema);
  for (const Channel& channel : channels_) {
    Put(channel.record);
  }
  end_group(Op::kChannel);
  Put(StatisticsRecord());
  end_group(Op::kStatistics);
  for (const Chunk& chunk : chunks_) {
    std::string content;
    AppendNumber(content, chunk.first_ns);
    AppendNumber(content, chunk.last_ns);
    AppendNumber(content, chunk.begin);
    AppendNumber(content, chunk.bytes);
    AppendPairs(content, chunk.index_of_channel);
    AppendNumber(content, chunk.index_bytes);
    AppendText(content, kPacking);
    AppendNumber(content, chunk.packed_bytes);
    AppendNumber(content, chunk.plain_bytes);
    Put(Record(Op::kChunkIndex, content));
  }
  end_group(Op::kChunkIndex);
  const std::uint64_t offsets_begin = position_;
  Put(offsets);
  std::string footer;
  AppendHead(footer, Op::kFooter, 8 + 8 + 4);
  AppendNumber(footer, begin);
  AppendNumber(footer, offsets_begin);
  AppendNumber(footer, Checksum(checksum_, footer));
  Put(footer);
}

std::string McapWriter::Close() {
  EndChunk();
  std::string end;
  AppendNumber(end, checksum_);
  Put(Record(Op::kDataEnd, end));
  WriteSummary();
  Put(kMagic);
  if (std::fclose(std::exchange(file_, nullptr)) != 0 && !failed_) {
    failed_ = true;
    error_ = errno;
  }
  return failed_ ? std::strerror(error_) : "";
}

void McapWriter::Put(std::string_view bytes) {
  if (!failed_ && std::fwrite(bytes.data(), 1, bytes.size(), file_) < bytes.size()) {
    failed_ = true;
    error_ = errno;
  }
  position_ += bytes.size();
  checksum_ = Checksum(checksum_, bytes);
}

}  // namespace pipewright::hil
