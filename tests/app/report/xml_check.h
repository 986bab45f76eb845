#pragma once
// A small checker of well-formedness: tags balanced, attributes quoted, entities known, no stray < or &.
#include <cctype>
#include <set>
#include <string>
#include <vector>

namespace limberg::test {

/// Empty when the text is well formed, otherwise what is wrong and where.
inline std::string xml_fault(const std::string& s) {
  std::vector<std::string> open;
  const auto at = [&](size_t i) { return " at byte " + std::to_string(i) + ": " + s.substr(i, 60); };
  const auto entity = [&](size_t i) {
    const size_t end = s.find(';', i);
    if (end == std::string::npos || end - i > 10) return false;
    const std::string name = s.substr(i + 1, end - i - 1);
    if (name.size() > 1 && name[0] == '#') return name.find_first_not_of("0123456789", 1) == std::string::npos;
    return std::set<std::string>{"amp", "lt", "gt", "quot", "apos"}.count(name) > 0;
  };
  for (size_t i = 0; i < s.size();) {
    if (s[i] == '&') {
      if (!entity(i)) return "stray &" + at(i);
      ++i;
    } else if (s[i] != '<') {
      if (static_cast<unsigned char>(s[i]) < 0x20 && s[i] != '\n' && s[i] != '\t') return "control character" + at(i);
      ++i;
    } else if (s.compare(i, 9, "<![CDATA[") == 0) {
      i = s.find("]]>", i);
      if (i == std::string::npos) return "unfinished CDATA";
      i += 3;
    } else if (s.compare(i, 2, "<!") == 0) {
      i = s.find('>', i);
      if (i == std::string::npos) return "unfinished declaration";
      ++i;
    } else {
      const size_t start = i++;
      const bool closing = i < s.size() && s[i] == '/';
      if (closing) ++i;
      std::string name;
      while (i < s.size() && (std::isalnum(static_cast<unsigned char>(s[i])) || s[i] == '-')) name += s[i++];
      if (name.empty()) return "stray <" + at(start);
      std::set<std::string> attributes;
      bool empty = false;
      for (;;) {
        while (i < s.size() && std::isspace(static_cast<unsigned char>(s[i]))) ++i;
        if (i >= s.size()) return "unfinished tag" + at(start);
        if (s[i] == '>') {
          ++i;
          break;
        }
        if (s.compare(i, 2, "/>") == 0) {
          empty = true;
          i += 2;
          break;
        }
        std::string attribute;
        while (i < s.size() && (std::isalnum(static_cast<unsigned char>(s[i])) || s[i] == '-' || s[i] == ':'))
          attribute += s[i++];
        if (attribute.empty() || !attributes.insert(attribute).second) return "broken attribute" + at(start);
        if (s.compare(i, 2, "=\"") != 0) return "attribute without quotes" + at(start);
        const size_t end = s.find('"', i + 2);
        if (end == std::string::npos) return "unfinished attribute" + at(start);
        for (size_t k = i + 2; k < end; ++k) {
          if (s[k] == '<') return "< in an attribute" + at(start);
          if (s[k] == '&' && !entity(k)) return "stray & in an attribute" + at(start);
        }
        i = end + 1;
      }
      if (closing) {
        if (open.empty() || open.back() != name)
          return "</" + name + "> closes " + (open.empty() ? "nothing" : "<" + open.back() + ">") + at(start);
        open.pop_back();
      } else if (!empty) {
        open.push_back(name);
      }
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

}  // namespace limberg::test
