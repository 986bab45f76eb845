#include "app/assembly/cases.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "app/program/shipped.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

std::set<std::string> names_of_cases() {
  std::set<std::string> names;
  std::error_code ec;
  for (const std::string& root : shipped_roots()) {
    for (fs::directory_iterator it(fs::path(root) / "app/lessons", ec), end; !ec && it != end; it.increment(ec))
      if (const std::string name = it->path().stem().string();
          it->path().extension() == ".toml" && !shipped_file("recordings/" + name + ".jsonl").empty())
        names.insert(name);
    if (!names.empty()) break;  // the best root alone: another may be of another version
  }
  return names;
}

Case case_of(const std::string& name) {
  return {name, open_lesson(name), shipped_file("recordings/" + name + ".jsonl"),
          shipped_file("recordings/" + name + ".lcm")};
}

}  // namespace

std::vector<Case> shipped_cases() {
  std::vector<Case> all;
  for (const std::string& name : names_of_cases()) all.push_back(case_of(name));
  return all;
}

Case open_case(const std::string& name) {
  const std::set<std::string> names = names_of_cases();
  if (names.contains(name)) return case_of(name);
  std::string list;
  for (const std::string& n : names) list += (list.empty() ? "" : ", ") + n;
  throw InputError("", 0, "there is no case \"" + name.substr(0, 100) + "\"; expected one of: " + list);
}

}  // namespace limberg
