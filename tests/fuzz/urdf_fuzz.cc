// SPDX-License-Identifier: MIT
// Robot descriptions.
#include <string_view>

#include "hil/plant/kdl_tree.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace pipewright;
  const std::string_view xml(reinterpret_cast<const char*>(bytes), size);
  hil::DescriptionError error;
  const auto robot = hil::ParseUrdf(xml, "input", error);
  test::Require(robot.has_value() == error.what.empty(), "a robot, or an error");
  if (robot) {
    test::Require(robot->links.size() == robot->joints.size() + 1, "the links are a tree");
    for (std::size_t i = 0; i < robot->joints.size(); ++i) {
      test::Require(robot->joints[i].child == robot->links[i + 1] &&
                        robot->LinkIndex(robot->joints[i].parent) <= static_cast<int>(i),
                    "a joint's parent comes before its child");
    }
    const KDL::Tree tree = hil::ToKdlTree(*robot);
    test::Require(tree.getNrOfSegments() == robot->joints.size(), "the tree has a segment a joint");
  }
  return 0;
}
