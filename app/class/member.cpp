#include "app/class/member.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/result/read_result.h"

namespace limberg {
namespace {

/// Lists that belong together are equally long.
void cut_to_shortest(std::initializer_list<std::vector<double>*> lists, size_t most = size_t(-1)) {
  for (const std::vector<double>* l : lists) most = std::min(most, l->size());
  for (std::vector<double>* l : lists) l->resize(most);
}

}  // namespace

ClassMember read_member(const std::string& text, const std::string& file) {
  ClassMember m;
  m.result = read_report_data(text, file);  // refuses what is no JSON, or nests too deep
  const nlohmann::json all = nlohmann::json::parse(text, nullptr, false);
  result_json::read(result_json::member(all, "class"), m.also);
  if (m.also.kind.empty()) m.also.kind = "result";
  ClassPath& p = m.also.path;
  cut_to_shortest({&p.x_mm, &p.y_mm, &p.tool});
  ClassMissed& missed = m.also.missed;
  cut_to_shortest({&missed.x_mm, &missed.y_mm}, missed.why.size());
  missed.why.resize(missed.x_mm.size());
  ClassStitches& s = m.also.stitches;
  cut_to_shortest({&s.x_mm, &s.y_mm});
  if (m.also.act_s.size() != m.result.script.size()) m.also.act_s.clear();
  return m;
}

Maybe exercise_of(const ReportData& d, const char* name) {
  const auto at = d.exercise.find(name);
  return at == d.exercise.end() ? Maybe() : Maybe(at->second);
}

std::string pseudonym(uint64_t content) {
  static constexpr char consonant[] = "bdfghjklmnprstvz", vowel[] = "aiou";
  const auto word = [](uint32_t v) {  // 16 bits
    std::string s;
    for (int letter = 0, bit = 16; letter < 5; ++letter)
      s += letter % 2 == 0 ? consonant[v >> (bit -= 4) & 15] : vowel[v >> (bit -= 2) & 3];
    return s;
  };
  return word(uint32_t(content >> 48)) + "-" + word(uint32_t(content >> 32 & 0xffff));
}

}  // namespace limberg
