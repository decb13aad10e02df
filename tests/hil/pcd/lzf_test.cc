// SPDX-License-Identifier: MIT
#include "hil/pcd/lzf.h"

#include <gtest/gtest.h>

#include <string>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

std::optional<std::size_t> Unpack(const std::string& packed, std::string& out) {
  return UnpackLzf({reinterpret_cast<const unsigned char*>(packed.data()), packed.size()},
                   {reinterpret_cast<unsigned char*>(out.data()), out.size()});
}

TEST(UnpackLzf, GivesWhatTheFormatSays) {
  const struct {
    const char* what;
    std::string packed;
    std::string expected;
  } cases[] = {
      {"nothing", "", ""},
      {"literals",
       {"\x02"
        "abc"},
       "abc"},
      {"a copy from three back, of three",
       {"\x02"
        "abc\x20\x02",
        6},
       "abcabc"},
      {"a copy that overlaps itself: a run",
       {"\x00"
        "a\x60\x00",
        4},
       "aaaaaa"},
      {"a long copy, its length in the next byte",
       {"\x00"
        "a\xE0\x01\x00",
        5},
       "aaaaaaaaaaa"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    std::string out(c.expected.size(), '?');
    EXPECT_EQ(Unpack(c.packed, out), std::nullopt);
    EXPECT_EQ(out, c.expected);
  }
}

TEST(UnpackLzf, NamesTheByteWhereItStopsMakingSense) {
  const struct {
    const char* what;
    std::string packed;
    std::size_t size;
    std::size_t expected;
  } cases[] = {
      {"literals cut short",
       "\x05"
       "abc",
       6, 0},
      {"more literals than room",
       {"\x00"
        "a\x01"
        "bc",
        5},
       2,
       2},
      {"a copy of what was not there",
       {"\x00"
        "a\x20\x01",
        4},
       4,
       2},
      {"a copy cut short",
       {"\x00"
        "a\x20",
        3},
       4,
       2},
      {"a long copy cut short",
       {"\x00"
        "a\xE0\x01",
        4},
       11,
       2},
      {"more copied than room",
       {"\x00"
        "a\x20\x00",
        4},
       3,
       2},
      {"too little for the room",
       {"\x00"
        "a",
        2},
       2,
       2},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    std::string out(c.size, '?');
    EXPECT_EQ(Unpack(c.packed, out), std::optional<std::size_t>(c.expected));
  }
}

TEST(UnpackLzf, SurvivesAnyBytes) {
  Rng rng(3);
  for (int k = 0; k < 20000; ++k) {
    std::string packed(static_cast<std::size_t>(rng.Index(60)), '\0');
    for (char& c : packed) {
      c = static_cast<char>(rng.Index(256));
    }
    std::string out(static_cast<std::size_t>(rng.Index(300)), '\0');
    const auto wrong = Unpack(packed, out);
    EXPECT_LE(wrong.value_or(0), packed.size());
  }
}

}  // namespace
}  // namespace pipewright::hil
