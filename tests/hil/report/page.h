// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace pipewright::hil {

/// Markup as a tree, read by tinyxml2; fails the test when it is not well-formed.
class Page {
 public:
  explicit Page(const std::string& markup) {
    xml_.Parse(markup.data(), markup.size());
    EXPECT_FALSE(xml_.Error()) << xml_.ErrorStr();
  }

  const tinyxml2::XMLElement* root() const { return xml_.RootElement(); }

  /// All elements for which a condition holds, in the order of the page.
  std::vector<const tinyxml2::XMLElement*> All(
      const std::function<bool(const tinyxml2::XMLElement&)>& holds) const {
    std::vector<const tinyxml2::XMLElement*> found;
    Collect(root(), holds, found);
    return found;
  }
  std::vector<const tinyxml2::XMLElement*> Named(const std::string& name) const {
    return All([&name](const tinyxml2::XMLElement& e) { return e.Name() == name; });
  }
  std::vector<const tinyxml2::XMLElement*> OfClass(const std::string& text) const {
    return All([&text](const tinyxml2::XMLElement& e) { return HasClass(e, text); });
  }

  static bool HasClass(const tinyxml2::XMLElement& e, const std::string& name) {
    const char* classes = e.Attribute("class");
    std::istringstream words(classes == nullptr ? "" : classes);
    const std::istream_iterator<std::string> first(words);
    return std::find(first, {}, name) != std::istream_iterator<std::string>();
  }

  /// All text below an element.
  static std::string Text(const tinyxml2::XMLElement& e) {
    std::string text;
    for (const tinyxml2::XMLNode* n = e.FirstChild(); n != nullptr; n = n->NextSibling()) {
      if (const tinyxml2::XMLText* t = n->ToText(); t != nullptr) {
        text += t->Value();
      } else if (n->ToElement() != nullptr) {
        text += Text(*n->ToElement());
      }
    }
    return text;
  }

 private:
  static void Collect(const tinyxml2::XMLElement* e,
                      const std::function<bool(const tinyxml2::XMLElement&)>& holds,
                      std::vector<const tinyxml2::XMLElement*>& found) {
    for (; e != nullptr; e = e->NextSiblingElement()) {
      if (holds(*e)) {
        found.push_back(e);
      }
      Collect(e->FirstChildElement(), holds, found);
    }
  }

  tinyxml2::XMLDocument xml_;
};

}  // namespace pipewright::hil
