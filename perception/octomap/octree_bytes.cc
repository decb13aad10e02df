// SPDX-License-Identifier: MIT
#include "perception/octomap/octree_bytes.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

namespace pipewright {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are taken as they lie");

constexpr int kLeast = -(1 << (kOctreeDepth - 1));
constexpr int kChildren = 8;

/// The next line, without its end; false: there is none.
bool TakeLine(std::string_view bytes, std::size_t& at, std::string_view& line) {
  const std::size_t feed = bytes.find('\n', at);
  if (feed == std::string_view::npos) {
    return false;
  }
  line = bytes.substr(at, feed - at);
  line.remove_suffix(line.ends_with('\r') ? 1 : 0);
  at = feed + 1;
  return true;
}

template <typename Number>
bool IsNumber(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

class LeafReader {
 public:
  LeafReader(std::string_view bytes, const OctreeHead& head,
             const std::function<void(const OctreeLeaf&)>& use)
      : bytes_(bytes.substr(head.body)), use_(use) {}

  /// Each of the two takes one node with all that is below it; false: it makes no sense.
  bool TakeNode(const VoxelIndex& lo, int voxels) {
    float log_odds = 0;
    if (bytes_.size() < sizeof log_odds + 1) {
      return false;
    }
    ++nodes_;
    std::memcpy(&log_odds, bytes_.data(), sizeof log_odds);
    const unsigned children = static_cast<unsigned char>(bytes_[sizeof log_odds]);
    bytes_.remove_prefix(sizeof log_odds + 1);
    if (children == 0) {
      use_({lo, voxels, log_odds});
      return true;
    }
    for (int i = 0; voxels > 1 && i < kChildren; ++i) {
      if ((children >> i & 1) != 0 && !TakeNode(ChildLo(lo, voxels, i), voxels / 2)) {
        return false;
      }
    }
    return voxels > 1;
  }

  bool TakeBinaryNode(const VoxelIndex& lo, int voxels) {
    if (bytes_.size() < 2 || voxels == 1) {
      return false;
    }
    ++nodes_;
    const unsigned kinds = static_cast<unsigned char>(bytes_[0]) |
                           static_cast<unsigned>(static_cast<unsigned char>(bytes_[1])) << 8;
    bytes_.remove_prefix(2);
    for (int i = 0; i < kChildren; ++i) {
      const unsigned kind = kinds >> 2 * i & 3;
      if (kind == kFree || kind == kOccupied) {
        ++nodes_;
        use_({ChildLo(lo, voxels, i), voxels / 2,
              kind == kFree ? -OctreeLeaf::kCertain : OctreeLeaf::kCertain});
      } else if (kind == kInner && !TakeBinaryNode(ChildLo(lo, voxels, i), voxels / 2)) {
        return false;
      }
    }
    return true;
  }

  std::uint64_t nodes() const { return nodes_; }
  bool at_end() const { return bytes_.empty(); }

 private:
  static constexpr unsigned kFree = 1;
  static constexpr unsigned kOccupied = 2;
  static constexpr unsigned kInner = 3;

  static VoxelIndex ChildLo(const VoxelIndex& lo, int voxels, int child) {
    const int half = voxels / 2;
    return {lo.x + (child & 1) * half, lo.y + (child >> 1 & 1) * half,
            lo.z + (child >> 2 & 1) * half};
  }

  std::string_view bytes_;
  const std::function<void(const OctreeLeaf&)>& use_;
  std::uint64_t nodes_ = 0;
};

}  // namespace

Result<OctreeHead> ReadOctreeHead(std::string_view bytes) {
  OctreeHead head;
  std::string_view line;
  bool is_octree = false;
  bool has_size = false;
  if (!TakeLine(bytes, head.body, line) || !line.starts_with("# Octomap OcTree ")) {
    return Status::kMalformed;
  }
  head.binary = line.find("binary") != std::string_view::npos;
  while (TakeLine(bytes, head.body, line)) {
    if (line == "data") {
      return is_octree && has_size && std::isfinite(head.width_m) && head.width_m > 0
                 ? Result<OctreeHead>(head)
                 : Status::kMalformed;
    }
    const std::size_t blank = line.find(' ');
    const std::string_view key = line.substr(0, blank);
    const std::string_view value =
        blank == std::string_view::npos ? std::string_view() : line.substr(blank + 1);
    const bool good = key == "id"     ? (is_octree = value == "OcTree")
                      : key == "size" ? (has_size = IsNumber(value, head.nodes))
                      : key == "res"  ? IsNumber(value, head.width_m)
                                      : line.starts_with('#');
    if (!good) {
      break;
    }
  }
  return Status::kMalformed;
}

Status ReadOctreeLeaves(std::string_view bytes, const OctreeHead& head,
                        const std::function<void(const OctreeLeaf&)>& use) {
  LeafReader reader(bytes, head, use);
  constexpr VoxelIndex kLo{kLeast, kLeast, kLeast};
  constexpr int kVoxels = 1 << kOctreeDepth;
  const bool good = head.nodes == 0 || (head.binary ? reader.TakeBinaryNode(kLo, kVoxels)
                                                    : reader.TakeNode(kLo, kVoxels));
  return good && reader.nodes() == head.nodes && reader.at_end() ? Status::kOk : Status::kMalformed;
}

}  // namespace pipewright
