// SPDX-License-Identifier: MIT
#include "hil/qpb/qpb.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>

#include "hil/qpb/problem_check.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "numbers are taken as they lie");

constexpr double kInfinite = 1e30;  ///< in the file
constexpr char kMagic[4] = {'Q', 'P', 'B', '1'};

/// Takes the file from front to back. After the first error it gives zeros and nothing, and keeps
/// that error.
class QpbReader {
 public:
  explicit QpbReader(const fs::path& path) : file_(path, std::ios::binary) {
    std::error_code failed;
    size_ = fs::file_size(path, failed);
    if (failed || !file_) {
      error_ = "cannot be read";
    }
  }

  bool good() const { return error_.empty(); }
  const std::string& error() const { return error_; }

  void Refuse(std::string why) {
    if (good()) {
      error_ = std::move(why);
    }
  }

  void TakeMagic() {
    char magic[4] = {};
    Take(magic, sizeof magic, "its first four bytes");
    if (good() && std::memcmp(magic, kMagic, sizeof magic) != 0) {
      Refuse("is not QPB1: its first four bytes are others");
    }
  }

  int TakeInt(const std::string& name, int least, int most) {
    std::int32_t value = 0;
    const std::uintmax_t from = at_;
    Take(&value, sizeof value, name);
    if (good() && (value < least || value > most)) {
      const std::string range = most == kAnyInt ? fmt::format("at least {}", least)
                                                : fmt::format("from {} to {}", least, most);
      Refuse(fmt::format("{} is {} (byte {}), not {}", name, value, from, range));
    }
    return good() ? value : 0;
  }

  /// rows times columns numbers, each count >= 0.
  std::vector<double> TakeNumbers(const std::string& name, int rows, int columns) {
    const auto count = static_cast<std::uintmax_t>(rows) * static_cast<std::uintmax_t>(columns);
    std::vector<double> values;
    if (good() && count > (size_ - at_) / sizeof(double)) {
      CutShort(name);  // before any memory is taken for it
    }
    if (good() && count > 0) {
      values.resize(count);
      Take(values.data(), count * sizeof(double), name);
    }
    for (double& v : values) {
      constexpr double kInf = std::numeric_limits<double>::infinity();
      v = v >= kInfinite ? kInf : v <= -kInfinite ? -kInf : v;
    }
    return values;
  }

  void TakeEnd() {
    if (good() && at_ != size_) {
      Refuse(fmt::format("has {} bytes after its last problem, from byte {} on", size_ - at_, at_));
    }
  }

  static constexpr int kAnyInt = std::numeric_limits<std::int32_t>::max();

 private:
  void Take(void* to, std::uintmax_t bytes, const std::string& name) {
    if (!good()) {
      return;
    }
    if (bytes > size_ - at_ ||
        !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) {
      CutShort(name);
    }
    at_ += bytes;
  }

  void CutShort(const std::string& name) {
    Refuse(fmt::format("is cut short at byte {}: {} begins at byte {} and does not end", size_,
                       name, at_));
  }

  std::ifstream file_;
  std::uintmax_t size_ = 0;
  std::uintmax_t at_ = 0;
  std::string error_;
};

QpbProblem TakeProblem(QpbReader& from, int number) {
  const auto name = [number](const char* what) {
    return fmt::format("problem {}: {}", number, what);
  };
  QpbProblem p;
  p.n = from.TakeInt(name("n"), 1, QpbReader::kAnyInt);
  const int me = from.TakeInt(name("me"), 0, QpbReader::kAnyInt);
  const int mi = from.TakeInt(name("mi"), 0, QpbReader::kAnyInt);
  const int ns = from.TakeInt(name("ns"), 0, p.n - 1);
  p.infeasible = from.TakeInt(name("expect"), 0, 1) == 1;
  for (int k = 0; from.good() && k < ns; ++k) {
    p.soft_row.push_back(from.TakeInt(name("soft_row"), 0, QpbReader::kAnyInt));
  }
  p.H = from.TakeNumbers(name("H"), p.n, p.n);
  p.g = from.TakeNumbers(name("g"), p.n, 1);
  p.Ae = from.TakeNumbers(name("Ae"), me, p.n);
  p.be = from.TakeNumbers(name("be"), me, 1);
  p.Ai = from.TakeNumbers(name("Ai"), mi, p.n);
  p.l = from.TakeNumbers(name("l"), mi, 1);
  p.u = from.TakeNumbers(name("u"), mi, 1);
  p.lb = from.TakeNumbers(name("lb"), p.n, 1);
  p.ub = from.TakeNumbers(name("ub"), p.n, 1);
  if (from.good()) {
    if (const std::string error = ProblemError(p); !error.empty()) {
      from.Refuse(name(error.c_str()));
    }
  }
  return p;
}

std::string FileError(const fs::path& path) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) {
    return "no such file";
  }
  return fs::is_regular_file(status) ? "" : "is not a file";  // a pipe or device may never end
}

}  // namespace

QpbResult ReadQpb(const fs::path& path) {
  if (const std::string error = FileError(path); !error.empty()) {
    return {std::nullopt, fmt::format("{}: {}", path.string(), error)};
  }
  QpbReader from(path);
  from.TakeMagic();
  const int problems = from.TakeInt("the number of problems", 1, QpbReader::kAnyInt);
  QpbSet set;
  set.is_sequence = from.TakeInt("is_sequence", 0, 1) == 1;
  for (int k = 0; from.good() && k < problems; ++k) {
    set.problems.push_back(TakeProblem(from, k));
  }
  from.TakeEnd();
  if (!from.good()) {
    return {std::nullopt, fmt::format("{}: {}", path.string(), from.error())};
  }
  return {std::move(set), ""};
}

}  // namespace pipewright::hil
