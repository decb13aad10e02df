// SPDX-License-Identifier: MIT
#include "hil/report/markup.h"

#include <fmt/format.h>

#include <cmath>

namespace pipewright::hil {
namespace {

constexpr std::string_view kThinSpace = "\u202F";
constexpr std::string_view kMinus = "\u2212";

/// "12345.6" as "12 345.6".
std::string Grouped(const std::string& digits) {
  const std::size_t whole = std::min(digits.find_first_of(".e"), digits.size());
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && i < whole && whole > 4 && (whole - i) % 3 == 0) {
      text += kThinSpace;
    }
    text += digits[i];
  }
  return text;
}

}  // namespace

std::string Escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default: {
        const auto byte = static_cast<unsigned char>(c);
        const bool forbidden = byte < 0x20 && c != '\t' && c != '\n' && c != '\r';
        if (forbidden) {
          out += "\uFFFD";
        } else {
          out += c;
        }
      }
    }
  }
  return out;
}

std::string Number(double value) {
  if (!std::isfinite(value)) {
    return "–";
  }
  const double size = std::abs(value);
  const bool whole = size < 1e15 && (size >= 1000 || size == std::floor(size));
  std::string digits = whole ? fmt::format("{:.0f}", size) : fmt::format("{:.4g}", size);
  const std::string sign(value < 0 ? kMinus : "");
  if (const std::size_t e = digits.find('e'); e != std::string::npos) {
    const int power = std::stoi(digits.substr(e + 1));
    return fmt::format("{}{}e{}{}", sign, digits.substr(0, e), power < 0 ? kMinus : "",
                       std::abs(power));
  }
  return sign + Grouped(digits);
}

std::string Fill(std::string_view page,
                 std::initializer_list<std::pair<std::string_view, std::string>> slots) {
  std::string out;
  while (!page.empty()) {
    const std::size_t open = page.find("{{");
    const std::size_t close = open == page.npos ? page.npos : page.find("}}", open);
    if (close == page.npos) {
      break;
    }
    out += page.substr(0, open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    std::string_view text = page.substr(open, close + 2 - open);
    for (const auto& [key, value] : slots) {
      if (key == name) {
        text = value;
      }
    }
    out += text;
    page.remove_prefix(close + 2);
  }
  return out.append(page);
}

}  // namespace pipewright::hil
