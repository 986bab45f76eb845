#include "tests/bench/figures/figures.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg::bench {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kEarlier = "earlier.json";

std::string text_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, 0, "cannot be read; expected a file");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Json object_of(const std::string& file) {
  Json json = Json::parse(text_of(file), nullptr, false);
  if (!json.is_object()) throw InputError(file, 0, "is no JSON object; expected the result of a bench");
  return json;
}

std::string day_of(const std::string& file) {
  struct stat st {};
  stat(file.c_str(), &st);
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(st.st_mtime));
}

/// The words of a call that say what was measured; where the result goes is left out.
std::vector<std::string> settings_of(const std::string& call) {
  std::istringstream in(call);
  std::vector<std::string> words;
  for (std::string word; in >> word;) {
    if (word == "--json" || word == "--out")
      in >> word;
    else if (!word.starts_with("--json=") && !word.starts_with("--out="))
      words.push_back(word);
  }
  return words;
}

/// "speed-quick-slab" of "limberg bench speed --quick --only slab": letters, digits and hyphens.
std::string name_of(const std::vector<std::string>& settings) {
  std::string name;
  for (const std::string& word : settings) {
    if (word == "limberg" || word == "bench" || word == "--only") continue;
    if (!name.empty()) name += '-';
    for (const char c : word.starts_with("--") ? word.substr(2) : word)
      name += std::isalnum((unsigned char)c) ? c : '-';
  }
  return name;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// A cell of a table.
std::string cell(std::string text) {
  for (size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2) text.insert(i, "\\");
  return text;
}

std::string number(const Json& v) { return v.is_number() ? fmt::format("{:.3g}", v.get<double>()) : "not a number"; }

/// Suites whose figures are a table, beside bars.
bool is_table(const std::string& suite) { return suite == "soak" || suite == "start"; }

std::string table(const Json& rows) {
  std::string text = "\n| case | method | ms | | |\n|---|---|---|---|---|\n";
  for (const Json& r : rows)
    text += fmt::format("| {} | {} | {} | {} {} | {} |\n", cell(r.at("case").get<std::string>()),
                        cell(r.at("method").get<std::string>()), number(r.at("time_ms")), number(r.at("error")),
                        cell(r.at("error_unit").get<std::string>()), cell(r.at("settings").get<std::string>()));
  return text;
}

/// Pictures that the bench has left beside its result, NAME-*.svg of a suite NAME: kept with it.
Json keep_pictures(const std::string& result_file, const std::string& suite, const std::string& folder) {
  Json names = Json::array();
  std::vector<fs::path> files;
  const fs::path beside = fs::path(result_file).parent_path();
  for (const auto& e : fs::directory_iterator(beside.empty() ? "." : beside))
    if (e.path().extension() == ".svg" && e.path().filename().string().starts_with(suite + "-"))
      files.push_back(e.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& f : files) {
    fs::copy_file(f, fs::path(folder) / f.filename(), fs::copy_options::overwrite_existing);
    names.push_back(f.filename().string());
  }
  return names;
}

std::string section(const std::string& name, const Json& m) {
  std::string text =
      fmt::format("### {}\n\n`{}`,\n{}, {} cores, {}, version {} ({}).", name, m.at("call").get<std::string>(),
                  m.at("cpu").get<std::string>(), m.at("cores").get<int>(), m.at("date").get<std::string>(),
                  m.at("version").get<std::string>(), m.at("commit").get<std::string>());
  if (m.at("quick").get<bool>()) text += "\nQuick: the smallest sizes only.";
  if (const std::string remark = m.value("remark", ""); !remark.empty()) text += "\n" + remark;
  text += "\n\n| bar | value | limit | |\n|---|---|---|---|\n";
  for (const Json& bar : m.at("bars"))
    text += fmt::format("| {} | {}{} | {} {} | {} |\n", cell(bar.at("name").get<std::string>()),
                        bar.value("at_least", false) ? "> " : "", number(bar.at("value")),
                        bar.value("larger_is_better", true) ? "at least" : "at most", number(bar.at("bar")),
                        bar.at("pass").get<bool>() ? "met" : "**missed**");
  if (m.contains("rows")) text += table(m.at("rows"));
  for (const Json& picture : m.value("pictures", Json::array()))
    text += fmt::format("\n![{}](figures/{})\n", fs::path(picture.get<std::string>()).stem().string(),
                        picture.get<std::string>());
  return text;
}

}  // namespace

std::string keep_result(const std::string& result_file, const std::string& folder, const KeepOptions& options) {
  const Json result = object_of(result_file);
  try {
    if (result.at("command") != "bench") throw InputError(result_file, 0, "is no result of a bench; expected one");
    const std::string suite = result.at("suite");
    std::string call = result.value("reproduce", "");
    if (call.empty()) call = "limberg bench " + suite + (result.at("quick").get<bool>() ? " --quick" : "");
    const std::vector<std::string> settings = settings_of(call);
    Json kept;
    kept["suite"] = suite;
    kept["quick"] = result.at("quick").get<bool>();
    kept["call"] = joined(settings);
    kept["date"] = options.date.empty() ? day_of(result_file) : options.date;
    kept["cpu"] = result.at("machine").at("cpu");
    kept["cores"] = result.at("machine").at("cores");
    kept["version"] = result.at("limberg").at("version");
    kept["commit"] = result.at("limberg").at("commit");
    if (!options.remark.empty()) kept["remark"] = options.remark;
    kept["bars"] = Json::array();
    for (const Json& bar : result.at("bars")) {
      Json b;
      for (const char* key : {"name", "value", "at_least", "bar", "larger_is_better", "pass"}) b[key] = bar.at(key);
      kept["bars"].push_back(b);
    }
    fs::create_directories(folder);
    if (is_table(suite)) {
      kept["rows"] = Json::array();
      for (const Json& row : result.at("rows")) {
        Json r;
        for (const char* key : {"case", "method", "time_ms", "error", "error_unit", "settings"}) r[key] = row.at(key);
        kept["rows"].push_back(r);
      }
      if (const Json pictures = keep_pictures(result_file, suite, folder); !pictures.empty())
        kept["pictures"] = pictures;
    }
    const std::string file = folder + "/" + name_of(settings) + ".json";
    write_whole_file(file, kept.dump(1) + "\n");
    return file;
  } catch (const Json::exception& e) {
    throw InputError(result_file, 0, fmt::format("is no result of a bench ({}); expected one", e.what()));
  }
}

std::string figures_text(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code ec;
  for (const auto& e : fs::directory_iterator(folder, ec))
    if (e.path().extension() == ".json" && e.path().filename() != kEarlier) files.push_back(e.path().string());
  if (ec) throw InputError(folder, 0, "cannot be read; expected a folder of kept results");
  std::sort(files.begin(), files.end());
  std::set<std::string> measured;  // suites with a whole measurement
  std::string text;
  for (const std::string& file : files) {
    const Json kept = object_of(file);
    try {
      const std::string name = fs::path(file).stem();
      text += (text.empty() ? "" : "\n") + section(name, kept);
      if (name == kept.at("suite")) measured.insert(name);
    } catch (const Json::exception& e) {
      throw InputError(file, 0, fmt::format("is no kept result ({}); expected one of ./do figures RESULT", e.what()));
    }
  }
  std::string earlier;
  if (const std::string file = folder + "/" + kEarlier; fs::exists(file)) {
    const Json dates = object_of(file);
    for (const auto& [suite, date] : dates.items())
      if (!measured.contains(suite)) earlier += fmt::format("| {} | {} |\n", suite, date.get<std::string>());
  }
  if (!earlier.empty())
    text +=
        "\n### Not measured anew\n\nThe last whole measurements of these suites stand in "
        "[validation.md](validation.md)."
        "\n\n| suite | date |\n|---|---|\n" +
        earlier;
  return text;
}

void write_page(const std::string& folder, const std::string& page_file) {
  const std::string page = text_of(page_file);
  const size_t begin = page.find(kFiguresBegin), end = page.find(kFiguresEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw InputError(page_file, 0,
                     fmt::format("has no markers; expected \"{}\" and \"{}\"", kFiguresBegin, kFiguresEnd));
  write_whole_file(page_file,
                   page.substr(0, begin) + kFiguresBegin + "\n\n" + figures_text(folder) + "\n" + page.substr(end));
}

}  // namespace limberg::bench
