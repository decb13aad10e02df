// SPDX-License-Identifier: MIT
#include "hil/replay/depth_writer.h"

#include <zstd.h>

#include <bit>
#include <type_traits>

#include "hil/replay/depth_recording.h"

namespace pipewright::hil {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Noise does not get smaller by looking longer.
constexpr int kLevel = 1;

}  // namespace

struct DepthWriter::Packer {
  Packer() {
    ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, kLevel);
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  }
  ~Packer() { ZSTD_freeCCtx(context); }
  Packer(const Packer&) = delete;
  Packer& operator=(const Packer&) = delete;

  ZSTD_CCtx* context = ZSTD_createCCtx();
};

DepthWriter::DepthWriter() = default;
DepthWriter::~DepthWriter() = default;

bool DepthWriter::Open(const std::filesystem::path& path) {
  packer_ = std::make_unique<Packer>();
  file_.open(path, std::ios::binary);
  return file_.good();
}

template <typename T>
void DepthWriter::Put(const T& value) {
  static_assert(std::is_arithmetic_v<T>);
  const char* const bytes = reinterpret_cast<const char*>(&value);
  item_.insert(item_.end(), bytes, bytes + sizeof(T));
}

void DepthWriter::PutDepths(std::span<const std::uint16_t> depth_mm) {
  const std::size_t low = item_.size();
  const std::size_t high = low + depth_mm.size();
  item_.resize(high + depth_mm.size());
  std::uint16_t before = 0;
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    const std::uint16_t folded = Fold(static_cast<std::uint16_t>(depth_mm[i] - before));
    item_[low + i] = static_cast<char>(folded & 0xFFU);
    item_[high + i] = static_cast<char>(folded >> 8);
    before = depth_mm[i];
  }
}

void DepthWriter::WriteItem() {
  packed_.resize(ZSTD_compressBound(item_.size()));
  const std::size_t bytes =
      ZSTD_compress2(packer_->context, packed_.data(), packed_.size(), item_.data(), item_.size());
  item_.clear();
  if (ZSTD_isError(bytes) != 0) {  // out of memory
    file_.setstate(std::ios::badbit);
    return;
  }
  file_.write(packed_.data(), static_cast<std::streamsize>(bytes));
}

void DepthWriter::Add(const DepthFrame& frame, Time given) {
  const CameraIntrinsics& c = frame.camera;
  if (camera_ != c) {
    camera_ = c;
    Put(kDepthCamera);
    Put(static_cast<std::uint32_t>(c.width));
    Put(static_cast<std::uint32_t>(c.height));
    for (const double value : {c.fx, c.fy, c.cx, c.cy, c.z_min_m, c.z_max_m}) {
      Put(value);
    }
    WriteItem();
  }
  Put(kDepthFrame);
  Put(frame.sequence);
  Put(std::int64_t{given.time_since_epoch().count()});
  Put(std::int64_t{frame.stamp.time_since_epoch().count()});
  PutDepths(std::span(frame.depth_mm)
                .first(static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height)));
  WriteItem();
  ++frames_;
}

bool DepthWriter::Close() {
  Put(kDepthEnd);
  Put(frames_);
  WriteItem();
  file_.close();
  return file_.good();
}

}  // namespace pipewright::hil
