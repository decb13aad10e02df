// SPDX-License-Identifier: MIT
#include "tests/plan/tour/tsplib_file.h"

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

namespace pipewright::test {
namespace {

constexpr int kNodesMax = 4096;

std::string Trimmed(const std::string& s) {
  const auto begin = s.find_first_not_of(" \t\r");
  return begin == std::string::npos ? "" : s.substr(begin, s.find_last_not_of(" \t\r") + 1 - begin);
}

/// Reads a file from its head on, and stops at the first thing that is wrong.
class Reader {
 public:
  Reader(std::istream& in, std::string file) : in_(in), file_(std::move(file)) {}

  TsplibResult Read() {
    while (error_.empty() && !done_ && NextLine()) {
      Entry();
    }
    if (error_.empty() && !done_) {
      Fail("the file ends before a section of weights or coordinates");
    }
    if (!error_.empty()) {
      return {std::nullopt, error_};
    }
    return {std::move(instance_), ""};
  }

 private:
  void Fail(const std::string& what) {
    if (error_.empty()) {
      error_ = file_ + ":" + std::to_string(line_number_) + ": " + what;
    }
  }

  bool NextLine() {
    std::string line;
    if (!std::getline(in_, line)) {
      return false;
    }
    ++line_number_;
    line_ = std::istringstream(line);
    return true;
  }

  /// KEY : VALUE, or a section's name.
  void Entry() {
    const std::string text = Trimmed(line_.str());
    const auto colon = text.find(':');
    const std::string key = Trimmed(text.substr(0, colon));
    if (key == "EDGE_WEIGHT_SECTION") {
      Weights();
    } else if (key == "NODE_COORD_SECTION") {
      Coordinates();
    } else if (colon != std::string::npos) {
      head_[key] = Trimmed(text.substr(colon + 1));
      if (key == "DIMENSION") {
        Dimension();
      }
    } else if (!key.empty()) {
      Fail("'" + key + "' is not known");
    }
  }

  void Dimension() {
    std::istringstream value(head_["DIMENSION"]);
    if (!(value >> instance_.n) || instance_.n < 2 || instance_.n > kNodesMax) {
      instance_.n = 0;
      Fail("DIMENSION is not from 2 to " + std::to_string(kNodesMax));
    }
  }

  /// Whether the head is as a section needs it.
  bool Ready(const std::string& weight_type) {
    if (instance_.n == 0) {
      Fail("no DIMENSION before this section");
    }
    if (head_.contains("TYPE") && head_["TYPE"] != "TSP" && head_["TYPE"] != "ATSP") {
      Fail("TYPE " + head_["TYPE"] + " is not TSP or ATSP");
    }
    if (head_["EDGE_WEIGHT_TYPE"] != weight_type) {
      Fail("EDGE_WEIGHT_TYPE is '" + head_["EDGE_WEIGHT_TYPE"] + "': this section needs " +
           weight_type);
    }
    if (error_.empty()) {
      instance_.name = head_["NAME"];
      instance_.costs.resize(static_cast<std::size_t>(instance_.n) * instance_.n);
    }
    return error_.empty();
  }

  bool Number(double& value) {
    std::string word;
    while (!(line_ >> word)) {
      if (!NextLine()) {
        Fail("the file ends within its section");
        return false;
      }
    }
    std::istringstream number(word);
    if (!(number >> value) || !number.eof() || !std::isfinite(value)) {
      Fail("'" + word + "' is not a number");
      return false;
    }
    return true;
  }

  void Weights() {
    if (!Ready("EXPLICIT")) {
      return;
    }
    if (head_["EDGE_WEIGHT_FORMAT"] != "FULL_MATRIX") {
      Fail("EDGE_WEIGHT_FORMAT is '" + head_["EDGE_WEIGHT_FORMAT"] + "', not FULL_MATRIX");
      return;
    }
    line_.setstate(std::ios::eofbit | std::ios::failbit);  // numbers begin on the next line
    for (float& cost : instance_.costs) {
      double value = 0;
      if (!Number(value)) {
        return;
      }
      cost = static_cast<float>(value);
    }
    done_ = true;
  }

  void Coordinates() {
    if (!Ready("EUC_2D")) {
      return;
    }
    line_.setstate(std::ios::eofbit | std::ios::failbit);
    std::vector<std::pair<double, double>> p(instance_.n);
    for (int i = 0; i < instance_.n; ++i) {
      double number = 0;
      if (!Number(number) || !Number(p[i].first) || !Number(p[i].second)) {
        return;
      }
      if (number != i + 1) {
        Fail("node " + std::to_string(i + 1) + " should be here");
        return;
      }
    }
    for (int i = 0; i < instance_.n; ++i) {
      for (int j = 0; j < instance_.n; ++j) {
        const double d = std::hypot(p[i].first - p[j].first, p[i].second - p[j].second);
        instance_.costs[static_cast<std::size_t>(i) * instance_.n + j] =
            static_cast<float>(std::floor(d + 0.5));
      }
    }
    done_ = true;
  }

  std::istream& in_;
  std::string file_;
  std::istringstream line_;
  int line_number_ = 0;
  std::map<std::string, std::string> head_;
  TsplibInstance instance_;
  std::string error_;
  bool done_ = false;
};

struct Optimum {
  std::string_view name;
  double cost;
};

// Proven: TSPLIB's pages "Best known solutions for asymmetric TSPs" and "... for symmetric TSPs".
constexpr Optimum kOptima[] = {
    {"br17", 39},       {"ftv33", 1286},    {"ftv35", 1473},    {"ftv38", 1530},
    {"p43", 5620},      {"ftv44", 1613},    {"ftv47", 1776},    {"ry48p", 14422},
    {"ft53", 6905},     {"ftv55", 1608},    {"ftv64", 1839},    {"ft70", 38673},
    {"ftv70", 1950},    {"kro124p", 36230}, {"ftv170", 2755},   {"rbg323", 1326},
    {"rbg358", 1163},   {"rbg403", 2465},   {"rbg443", 2720},   {"berlin52", 7542},
    {"st70", 675},      {"eil76", 538},     {"pr76", 108159},   {"rat99", 1211},
    {"kroA100", 21282}, {"kroB100", 22141}, {"kroC100", 20749}, {"kroD100", 21294},
    {"kroE100", 22068}, {"lin105", 14379},  {"ch130", 6110},    {"ch150", 6528},
    {"kroA150", 26524}, {"kroB150", 26130}, {"pr152", 73682},   {"rat195", 2323},
    {"d198", 15780},    {"kroA200", 29368}, {"kroB200", 29437}, {"ts225", 126643},
    {"tsp225", 3916},   {"pr226", 80369},   {"gil262", 2378},   {"a280", 2579},
    {"lin318", 42029},  {"rd400", 15281},   {"fl417", 11861},   {"pcb442", 50778},
    {"d493", 35002},
};

}  // namespace

TsplibResult ReadTsplib(std::istream& in, const std::string& file) {
  return Reader(in, file).Read();
}

TsplibResult ReadTsplibFile(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    return {std::nullopt, path + ": cannot be read"};
  }
  return ReadTsplib(in, path);
}

std::optional<double> TsplibOptimum(std::string_view name) {
  for (const Optimum& optimum : kOptima) {
    if (optimum.name == name) {
      return optimum.cost;
    }
  }
  return std::nullopt;
}

}  // namespace pipewright::test
