// SPDX-License-Identifier: MIT
#include "hil/mcap/cdr_writer.h"

#include <gtest/gtest.h>

namespace pipewright::hil {
namespace {

using namespace std::string_literals;

TEST(CdrWriter, AlignsEachNumberToItsSizeFromBehindTheHead) {
  CdrWriter cdr;
  cdr.Begin();
  cdr.Put(std::uint8_t{0x11});
  cdr.Put(std::uint16_t{0x2233});
  cdr.Put(std::uint8_t{0x44});
  cdr.Put(std::uint32_t{0x55667788});
  cdr.Put(std::uint8_t{0x99});
  cdr.Put(1.0);
  EXPECT_EQ(cdr.bytes(),
            "\x00\x01\x00\x00"  // CDR_LE
            "\x11\x00\x33\x22"
            "\x44\x00\x00\x00\x88\x77\x66\x55"
            "\x99\x00\x00\x00"
            "\x00\x00\x00\x00\x00\x00\xF0\x3F"s);
}

TEST(CdrWriter, EndsTextsByAZeroThatCounts) {
  CdrWriter cdr;
  cdr.Begin();
  cdr.PutLength(2);
  cdr.Put(std::string_view("ab"));
  cdr.Put(std::string_view(""));
  EXPECT_EQ(cdr.bytes().substr(4),
            "\x02\x00\x00\x00"
            "\x03\x00\x00\x00"
            "ab\x00\x00"
            "\x01\x00\x00\x00\x00"s);
}

TEST(CdrWriter, PutsASequenceOfBytesAsTheyAre) {
  CdrWriter cdr;
  cdr.Begin();
  cdr.PutBytes("a\0b"s);
  cdr.PutBytes("");
  EXPECT_EQ(cdr.bytes().substr(4),
            "\x03\x00\x00\x00"
            "a\x00"
            "b\x00"
            "\x00\x00\x00\x00"s);
}

TEST(CdrWriter, BeginsAnew) {
  CdrWriter cdr;
  cdr.Begin();
  cdr.Put(1.0);
  cdr.Begin();
  EXPECT_EQ(cdr.bytes(), "\x00\x01\x00\x00"s);
}

}  // namespace
}  // namespace pipewright::hil
