#include "app/study/member_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/program/version.h"
#include "app/result/json_nesting.h"
#include "app/result/output.h"
#include "app/result/result.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"

namespace limberg::study {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string member_text(double v) {
  char t[40];
  return {t, std::to_chars(t, t + sizeof t, v).ptr};
}

Json member_numbers(const std::vector<double>& v) {
  Json out = Json::array();
  for (const double x : v) out.push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
  return out;
}
double number(const Json& j) { return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>(); }
std::vector<double> member_numbers(const Json& j) {
  std::vector<double> out;
  for (const Json& x : j) out.push_back(number(x));
  return out;
}

Json parse(const std::string& file) {
  const std::string whole = read_whole_file(file, size_t(64) << 20);
  if (json_nesting(whole) > 20) throw InputError(file, 0, "is nested too deeply; expected a member of a study");
  return Json::parse(whole, nullptr, false);
}

[[noreturn]] void broken(const std::string& file) {
  throw InputError(file, 0, "is no member of a study; expected what `limberg study NAME --member` writes");
}

}  // namespace

std::string member_name(const Family& f, const Values& v) {
  std::string name = f.name;
  for (size_t i = 0; i < v.size(); ++i) name += "," + f.parameters[i].name + "=" + member_text(v[i]);
  return name;
}

std::string member_file(const std::string& dir, const Family& f, const Values& v, const char* ending) {
  return dir + "/members/" + member_name(f, v) + ending;
}

uint64_t program_hash() {
  static const uint64_t hash = [] {
    const std::string bytes = read_whole_file("/proc/self/exe", size_t(1) << 30);
    Hash64 h;
    h.bytes(bytes.data(), bytes.size());
    return h.value();
  }();
  return hash;
}

std::string first_line_of(const std::string& file) {
  std::error_code ec;
  if (!fs::is_regular_file(file, ec)) return {};
  const std::string text = read_whole_file(file, size_t(1) << 20);
  return text.substr(0, text.find('\n'));
}

std::string member_text(const Family& f, const Values& v, const MemberResult& r) {
  Json j;
  j["limberg"] = {{"version", version()}, {"commit", commit()}};
  j["study"] = f.name;
  for (size_t i = 0; i < v.size(); ++i) j["values"][f.parameters[i].name] = v[i];
  j["program"] = hex(r.program), j["inputs"] = hex(r.inputs), j["seconds"] = r.seconds;
  if (!r.failure.empty()) {
    j["failure"] = r.failure;
    if (r.cut_short) j["cut_short"] = true;
    return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  }
  j["figures"] = Json::array();
  for (const auto& [name, x] : r.row.figures)
    j["figures"].push_back({name, std::isfinite(x) ? Json(x) : Json(nullptr)});
  j["title"] = r.row.title;
  if (const ChartSeries& p = r.row.profile; !p.x.empty())
    j["profile"] = {{"name", p.name}, {"markers", p.markers}, {"x", member_numbers(p.x)}, {"y", member_numbers(p.y)}};
  return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<MemberResult> read_member(const std::string& file, const Family& f, const Values& v) {
  if (std::error_code ec; !fs::exists(file, ec)) return std::nullopt;
  const Json j = parse(file);
  MemberResult r;
  try {
    if (j.at("study").get<std::string>() != f.name) broken(file);
    for (size_t i = 0; i < v.size(); ++i)
      if (j.at("values").at(f.parameters[i].name).get<double>() != v[i])
        throw InputError(file, 0, "holds another member; expected " + member_name(f, v));
    r.program = std::stoull(j.at("program").get<std::string>(), nullptr, 16),
    r.inputs = std::stoull(j.at("inputs").get<std::string>(), nullptr, 16);
    r.seconds = j.at("seconds").get<double>();
    if (j.contains("failure")) {
      r.failure = j["failure"].get<std::string>();
      r.cut_short = j.value("cut_short", false);
      return r;
    }
    for (const Json& x : j.at("figures")) r.row.figures.emplace_back(x.at(0).get<std::string>(), number(x.at(1)));
    r.row.title = j.at("title").get<std::string>();
    if (j.contains("profile")) {
      const Json& p = j["profile"];
      r.row.profile = {p.at("name").get<std::string>(), member_numbers(p.at("x")), member_numbers(p.at("y")),
                       p.at("markers").get<bool>()};
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    broken(file);
  }
  return r;
}

std::vector<Values> members_in(const std::string& dir, const Family& f) {
  std::vector<Values> out;
  std::error_code ec;
  fs::directory_iterator files(dir + "/members", ec);
  if (ec)
    throw InputError(dir + "/members", 0,
                     "cannot be read; expected the folder that the members of a study were left in");
  for (const fs::directory_entry& e : files) {
    const std::string name = e.path().filename().string();
    if (e.path().extension() != ".json" || name.rfind(f.name + ",", 0) != 0) continue;
    const Json j = parse(e.path().string());
    Values v;
    try {
      for (const Parameter& p : f.parameters) v.push_back(j.at("values").at(p.name).get<double>());
    } catch (const std::exception&) {
      broken(e.path().string());
    }
    out.push_back(std::move(v));
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace limberg::study
