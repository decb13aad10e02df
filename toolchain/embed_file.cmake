# Script of pipewright_embed: FILE to a header and a source. An array of bytes, not a literal: a
# literal's length is limited, and raw ones end at their delimiter.
file(READ "${FILE}" hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "((0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,))" "\\1\n"
       bytes "${bytes}")
file(WRITE "${HEADER}" "// Generated from a file of the source tree.
#pragma once

#include <string_view>

namespace pipewright::embedded {
std::string_view ${SYMBOL}();
}
")
file(WRITE "${SOURCE}" "// Generated from a file of the source tree.
#include \"embedded/${SYMBOL}.h\"

namespace pipewright::embedded {
namespace {
constexpr unsigned char kBytes[] = {
${bytes}0};
}

std::string_view ${SYMBOL}() {
  return {reinterpret_cast<const char*>(kBytes), ${size}};
}
}  // namespace pipewright::embedded
")
