// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace pipewright::hil {

/// Text as content or attribute of XHTML. Characters that XML forbids become U+FFFD.
/// @param text  UTF-8
std::string Escape(std::string_view text);

/// A number for people: 4 significant digits, whole numbers in full with digits in groups of
/// three, a true minus sign; "–" when it is not finite.
std::string Number(double value);

/// Replaces each {{name}} of a page by its text, which is taken as it is. A name that is not given
/// stays.
std::string Fill(std::string_view page,
                 std::initializer_list<std::pair<std::string_view, std::string>> slots);

}  // namespace pipewright::hil
