#include "app/study/task_file.h"

#include <charconv>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg::study {

std::string task_text(const std::vector<Job>& jobs) {
  std::string out;
  for (const Job& job : jobs) {
    out += job.family->name;
    for (size_t i = 0; i < job.values.size(); ++i) {
      char t[40];
      out += " " + job.family->parameters[i].name + "=" +
             std::string(t, std::to_chars(t, t + sizeof t, job.values[i]).ptr);
    }
    out += "\n";
  }
  return out;
}

std::vector<Job> read_task(const std::string& file) {
  std::istringstream lines(read_whole_file(file, size_t(64) << 20, "the members of a task"));
  std::vector<Job> jobs;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string study;
    if (!(words >> study)) continue;
    std::vector<std::string> settings;
    for (std::string s; words >> s;) settings.push_back(s);
    try {
      const Family& family = find_family(study);
      const std::vector<Values> all = members(family, settings);
      if (all.size() != 1) throw InputError("", 0, "names several members; expected one value for each setting");
      jobs.push_back({&family, all[0]});
    } catch (const InputError& e) {
      throw InputError(file, number, e.what());
    }
  }
  return jobs;
}

}  // namespace limberg::study
