// SPDX-License-Identifier: MIT
// What is written is read bit for bit; whatever byte is wrong or missing, what is read is a
// beginning of what was written.
#include "hil/replay/depth_recording.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "hil/replay/depth_reader.h"
#include "hil/replay/depth_writer.h"
#include "platform/core/rng.h"
#include "tests/support/can_logs.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

struct GivenFrame {
  std::unique_ptr<DepthFrame> frame = std::make_unique<DepthFrame>();
  Time given{};
};

/// Frames of `width` x `height` that look like a camera's: slopes, noise, holes, and now and then
/// any number at all.
std::vector<GivenFrame> Frames(int count, int width, int height, std::uint64_t seed) {
  std::vector<GivenFrame> frames(static_cast<std::size_t>(count));
  Rng rng(seed);
  for (int k = 0; k < count; ++k) {
    auto& [frame, given] = frames[static_cast<std::size_t>(k)];
    frame->sequence = static_cast<std::uint32_t>(2 * k + 1);
    frame->stamp = Time(Duration(66'666'667LL * k));
    given = frame->stamp + std::chrono::microseconds(333);
    frame->camera = {width, height, 111.7, 112.3, width / 2.0, height / 3.0, 0.168, 6.25};
    for (int i = 0; i < width * height; ++i) {
      const int kind = rng.Index(20);
      frame->depth_mm[static_cast<std::size_t>(i)] =
          static_cast<std::uint16_t>(kind == 0   ? 0
                                     : kind == 1 ? rng.Index(65536)
                                                 : 900 + 3 * i + rng.Index(9));
    }
  }
  return frames;
}

std::string Record(const std::vector<GivenFrame>& frames) {
  const fs::path path = test::TestFolder() / "depth.z16.zst";
  DepthWriter writer;
  EXPECT_TRUE(writer.Open(path));
  for (const GivenFrame& one : frames) {
    writer.Add(*one.frame, one.given);
  }
  EXPECT_TRUE(writer.Close());
  return test::ReadFile(path);
}

struct ReadBack {
  std::string open_error;
  std::vector<GivenFrame> frames;
  std::string end;
};

ReadBack Read(const std::string& bytes) {
  ReadBack read;
  DepthReader reader;
  // const_cast: opened for reading only
  read.open_error =
      reader.Open(fmemopen(const_cast<char*>(bytes.data()), bytes.size(), "rb"), "a.zst");
  GivenFrame one;
  while (read.open_error.empty() && reader.Next(*one.frame, one.given)) {
    read.frames.push_back(std::move(one));
    one = {};
  }
  read.end = reader.end();
  return read;
}

bool Same(const GivenFrame& a, const GivenFrame& b) {
  const int pixels = a.frame->camera.width * a.frame->camera.height;
  return a.given == b.given && a.frame->stamp == b.frame->stamp &&
         a.frame->sequence == b.frame->sequence && a.frame->camera == b.frame->camera &&
         std::equal(a.frame->depth_mm.begin(), a.frame->depth_mm.begin() + pixels,
                    b.frame->depth_mm.begin());
}

void ExpectBeginning(const std::vector<GivenFrame>& got, const std::vector<GivenFrame>& of) {
  ASSERT_LE(got.size(), of.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_TRUE(Same(got[i], of[i])) << "frame " << i;
  }
}

TEST(DepthFold, MakesEverySmallDifferenceSmallAndIsUndone) {
  EXPECT_EQ(Fold(0), 0);
  EXPECT_EQ(Fold(0xFFFF), 1);  // -1
  EXPECT_EQ(Fold(1), 2);
  EXPECT_EQ(Fold(0x8000), 0xFFFF);
  for (int d = 0; d < 65536; ++d) {
    ASSERT_EQ(Unfold(Fold(static_cast<std::uint16_t>(d))), d);
  }
}

TEST(DepthRecording, GivesBackEveryBit) {
  std::vector<GivenFrame> frames = Frames(5, 212, 120, 1);
  for (GivenFrame& one : Frames(3, 848, 480, 2)) {  // another camera in between: the largest
    frames.push_back(std::move(one));
  }
  for (GivenFrame& one : Frames(2, 1, 1, 3)) {
    frames.push_back(std::move(one));
  }
  const ReadBack read = Read(Record(frames));
  EXPECT_EQ(read.open_error, "");
  EXPECT_EQ(read.end, "");
  ASSERT_EQ(read.frames.size(), frames.size());
  ExpectBeginning(read.frames, frames);
}

TEST(DepthRecording, IsAsItsDescriptionSays) {
  std::vector<GivenFrame> frames = Frames(1, 3, 1, 4);
  frames[0].frame->depth_mm[0] = 1000;
  frames[0].frame->depth_mm[1] = 0;
  frames[0].frame->depth_mm[2] = 2;
  std::string plain;
  for (const auto& item : {std::string("PWZ1"), std::string("PWZF"), std::string("PWZE")}) {
    plain += item;
    const auto put = [&plain](const auto& value) {
      plain.append(reinterpret_cast<const char*>(&value), sizeof(value));
    };
    if (item == "PWZ1") {
      put(std::uint32_t{3});
      put(std::uint32_t{1});
      for (const double value : {111.7, 112.3, 1.5, 1 / 3.0, 0.168, 6.25}) {
        put(value);
      }
    } else if (item == "PWZF") {
      put(std::uint32_t{1});
      put(std::int64_t{333'000});
      put(std::int64_t{0});
      // 1000 -> 2000; -1000 -> 1999; 2 -> 4
      plain += {static_cast<char>(2000 & 0xFF),
                static_cast<char>(1999 & 0xFF),
                4,
                2000 >> 8,
                1999 >> 8,
                0};
    } else {
      put(std::uint32_t{1});
    }
  }
  for (const std::string& bytes : {plain, test::Zstd(plain)}) {
    const ReadBack read = Read(bytes);
    EXPECT_EQ(read.end, "");
    ASSERT_EQ(read.frames.size(), 1U);
    ExpectBeginning(read.frames, frames);
  }
}

TEST(DepthRecording, OfNoFrameIsWhole) {
  const ReadBack read = Read(Record({}));
  EXPECT_EQ(read.open_error, "");
  EXPECT_EQ(read.end, "");
  EXPECT_TRUE(read.frames.empty());
}

/// Where the items of a recording end, by the library that packed them.
std::vector<std::size_t> ItemEnds(const std::string& bytes) {
  std::vector<std::size_t> ends;
  for (std::size_t at = 0; at < bytes.size(); ends.push_back(at)) {
    at += ZSTD_findFrameCompressedSize(bytes.data() + at, bytes.size() - at);
  }
  return ends;
}

/// Of a recording by one camera: the frames whose items lie before byte `at`.
std::size_t WholeFrames(const std::vector<std::size_t>& ends, std::size_t at) {
  const auto items = std::upper_bound(ends.begin(), ends.end(), at) - ends.begin();
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
      items - 1, 0, static_cast<std::ptrdiff_t>(ends.size()) - 2));  // camera, frames, end
}

TEST(DepthRecording, CutAtAnyByteGivesTheWholeFramesBeforeAndSaysSo) {
  const std::vector<GivenFrame> frames = Frames(4, 16, 5, 5);
  const std::string bytes = Record(frames);
  const std::vector<std::size_t> ends = ItemEnds(bytes);
  ASSERT_EQ(ends.size(), frames.size() + 2);
  for (std::size_t at = 1; at < bytes.size(); ++at) {
    SCOPED_TRACE(at);
    const ReadBack read = Read(bytes.substr(0, at));
    EXPECT_NE(read.open_error.empty() ? read.end : read.open_error, "");
    EXPECT_EQ(read.frames.size(), WholeFrames(ends, at));
    ExpectBeginning(read.frames, frames);
  }
}

TEST(DepthRecording, WithAnyByteFlippedGivesTheFramesBeforeItAndNoneThatWasNotWritten) {
  const std::vector<GivenFrame> frames = Frames(3, 16, 5, 6);
  const std::string bytes = Record(frames);
  const std::vector<std::size_t> ends = ItemEnds(bytes);
  Rng rng(7);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int flip : {1 << rng.Index(8), 1 + rng.Index(255)}) {
      SCOPED_TRACE(testing::Message() << "byte " << at << " ^ " << flip);
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      const ReadBack read = Read(damaged);
      ExpectBeginning(read.frames, frames);
      EXPECT_GE(read.frames.size(), WholeFrames(ends, at));
      const bool all = read.frames.size() == frames.size();
      EXPECT_TRUE(all || !read.end.empty() || !read.open_error.empty());
    }
  }
}

TEST(DepthRecording, OfAnyBytesEnds) {
  Rng rng(8);
  const std::string bytes = Record(Frames(2, 16, 5, 9));
  for (int k = 0; k < 500; ++k) {
    std::string noise = bytes.substr(0, static_cast<std::size_t>(rng.Index(200)));
    for (int i = 0; i < 200; ++i) {
      noise += static_cast<char>(rng.Index(256));
    }
    EXPECT_LE(Read(noise).frames.size(), 2U);
    EXPECT_LE(Read("PWZ1" + noise).frames.size(), 2U);
  }
}

TEST(DepthRecording, ThatIsNoneIsRefusedByItsName) {
  EXPECT_NE(Read("(1699000000.123456) can0 123#DEADBEEF\n").open_error.find("a.zst: is no depth"),
            std::string::npos);
  DepthReader reader;
  EXPECT_NE(reader.Open("/no/such/depth").find("/no/such/depth: no such file"), std::string::npos);
}

TEST(DepthWriter, OnAFullDiskSaysSoAtTheEnd) {
  DepthWriter writer;
  ASSERT_TRUE(writer.Open("/dev/full"));
  for (const GivenFrame& one : Frames(20, 64, 48, 10)) {
    writer.Add(*one.frame, one.given);
  }
  EXPECT_FALSE(writer.Close());
}

}  // namespace
}  // namespace pipewright::hil
