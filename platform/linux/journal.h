// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace pipewright {

enum class Severity { kError, kWarning, kNotice, kInfo };

/// One line on standard error, for people. Where that is the system's journal (JOURNAL_STREAM is
/// set) the line carries its severity, as sd-daemon(3) has it. No heap; cut at 1 kB.
void Say(Severity severity, std::string_view what);

}  // namespace pipewright
