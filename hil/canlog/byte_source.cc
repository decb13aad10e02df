// SPDX-License-Identifier: MIT
#include "hil/canlog/byte_source.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace pipewright::hil {
namespace {

constexpr std::size_t kPackedBytes = 64 * 1024;
constexpr unsigned char kGzip[] = {0x1F, 0x8B};
constexpr unsigned char kZstandard[] = {0x28, 0xB5, 0x2F, 0xFD};

template <std::size_t n>
bool BeginsWith(std::span<const char> bytes, const unsigned char (&magic)[n]) {
  return bytes.size() >= n && std::memcmp(bytes.data(), magic, n) == 0;
}

}  // namespace

class ByteSource::Unpacker {
 public:
  /// What one step did; `end` is that of a member or frame, after which another may begin.
  struct Step {
    std::size_t used = 0;
    std::size_t made = 0;
    bool end = false;
    bool corrupt = false;
  };

  virtual ~Unpacker() = default;
  virtual Step Unpack(std::span<const char> in, std::span<char> out) = 0;
  virtual const char* name() const = 0;

  bool between_members = true;
};

class ByteSource::Inflate : public ByteSource::Unpacker {
 public:
  Inflate() { inflateInit2(&stream_, 16 + MAX_WBITS); }
  ~Inflate() override { inflateEnd(&stream_); }

  Step Unpack(std::span<const char> in, std::span<char> out) override {
    if (between_members) {
      inflateReset(&stream_);
    }
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));
    stream_.avail_in = static_cast<uInt>(in.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    const int result = inflate(&stream_, Z_NO_FLUSH);
    return {in.size() - stream_.avail_in, out.size() - stream_.avail_out, result == Z_STREAM_END,
            result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR};
  }
  const char* name() const override { return "gz"; }

 private:
  z_stream stream_{};
};

class ByteSource::Zstd : public ByteSource::Unpacker {
 public:
  ~Zstd() override { ZSTD_freeDStream(stream_); }

  Step Unpack(std::span<const char> in, std::span<char> out) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    const std::size_t result = ZSTD_decompressStream(stream_, &to, &from);
    return {from.pos, to.pos, result == 0, ZSTD_isError(result) != 0};
  }
  const char* name() const override { return "zstd"; }

 private:
  ZSTD_DStream* stream_ = ZSTD_createDStream();
};

ByteSource::ByteSource() : packed_(std::make_unique<char[]>(kPackedBytes)) {}

ByteSource::~ByteSource() {
  if (file_ != nullptr && file_ != stdin) {
    std::fclose(file_);
  }
}

std::string ByteSource::Open(const std::string& path) {
  std::error_code failed;
  if (path == "-") {
    file_ = stdin;
  } else if (std::filesystem::is_directory(path, failed)) {
    return "is a folder";
  } else {
    file_ = std::fopen(path.c_str(), "rb");
    if (file_ == nullptr) {
      return errno == ENOENT ? "no such file" : std::strerror(errno);
    }
    const std::uintmax_t size = std::filesystem::file_size(path, failed);
    size_ = failed ? 0 : size;
  }
  Open(file_);
  return error_;
}

void ByteSource::Open(std::FILE* file) {
  file_ = file;
  std::setvbuf(file_, nullptr, _IONBF, 0);  // whole blocks are read, into buffers of our own
  Refill();
  if (BeginsWith(input_, kGzip)) {
    unpacker_ = std::make_unique<Inflate>();
  } else if (BeginsWith(input_, kZstandard)) {
    unpacker_ = std::make_unique<Zstd>();
  }
}

const char* ByteSource::packing() const { return unpacker_ ? unpacker_->name() : "none"; }

std::size_t ByteSource::Read(std::span<char> out) {
  if (!unpacker_) {
    const std::size_t bytes = ReadPlain(out);
    certain_ += bytes;
    return bytes;
  }
  std::size_t made = 0;
  while (made < out.size() && error_.empty()) {
    if (input_.empty()) {
      Refill();
    }
    const bool at_end = input_.empty();
    if (at_end && unpacker_->between_members) {
      break;
    }
    const std::uint64_t at = position_ - input_.size();
    const Unpacker::Step step = unpacker_->Unpack(input_, out.subspan(made));
    input_ = input_.subspan(step.used);
    made += step.made;
    unpacker_->between_members = step.end;
    certain_ = step.end ? given_ + made : certain_;
    if (step.corrupt) {
      error_ = fmt::format("{} data that make no sense, near byte {} of the file",
                           unpacker_->name(), at + step.used);
    } else if (at_end && !step.end && step.made == 0) {
      error_ = fmt::format("{} data that stop short at byte {} of the file", unpacker_->name(),
                           position_);
    }
  }
  given_ += made;
  return made;
}

std::size_t ByteSource::ReadPlain(std::span<char> out) {
  const std::size_t first = std::min(out.size(), input_.size());
  std::copy_n(input_.begin(), first, out.begin());
  input_ = input_.subspan(first);
  return first + (first < out.size() ? ReadFile(out.subspan(first)) : 0);
}

std::size_t ByteSource::ReadFile(std::span<char> out) {
  const std::size_t bytes = std::fread(out.data(), 1, out.size(), file_);
  position_ += bytes;
  if (bytes < out.size() && std::ferror(file_) != 0 && error_.empty()) {
    error_ = fmt::format("cannot be read beyond byte {}: {}", position_, std::strerror(errno));
  }
  return bytes;
}

void ByteSource::Refill() {
  const std::size_t bytes = ReadFile({packed_.get(), kPackedBytes});
  input_ = {packed_.get(), bytes};
}

}  // namespace pipewright::hil
