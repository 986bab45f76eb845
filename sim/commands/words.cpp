#include "sim/commands/words.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/commands/authorship.h"
#include "sim/commands/table.h"

namespace limberg {

double path_mm(const std::vector<ChartPoint>& p, bool closed) {
  double l = 0;
  for (size_t i = 1; i < p.size(); ++i) l += (p[i] - p[i - 1]).norm();
  return closed && p.size() > 2 ? l + (p.front() - p.back()).norm() : l;
}

double area_mm2(const std::vector<ChartPoint>& p) {
  double a = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const ChartPoint &q = p[i], &r = p[(i + 1) % p.size()];
    a += q.x() * r.y() - r.x() * q.y();
  }
  return 0.5 * std::abs(a);
}

std::string rounded_text(double value, int digits) {
  if (value == 0 || !std::isfinite(value)) return fmt::format("{:g}", value);
  const double unit = elementary::pow(10.0, std::floor(elementary::log10(std::abs(value)) + 1e-12) - digits + 1);
  const double rounded = std::round(value / unit) * unit;
  std::string s = fmt::format("{:.{}f}", rounded, std::max(0, int(std::lround(-elementary::log10(unit)))));
  if (s.find('.') != std::string::npos) {
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
  }
  return s;
}

std::string in_words(const Command& command) {
  return visit_act(command, []<class C>(const C& c) -> std::string {
    if constexpr (requires { Act<C>::words(c); })
      return Act<C>::words(c);
    else
      return Act<C>::name;
  });
}

namespace {

constexpr double kGoesOn_mm = 0.5, kNothing_mm = 0.1;

/// Strokes of a hand that was lifted on the way become the cut that they are.
std::vector<Command> with_strokes_that_go_on(const std::vector<StandingAct>& acts) {
  std::vector<Command> out;
  for (const StandingAct& act : acts) {
    const auto* next = std::get_if<Incise>(&act.command);
    auto* cut = out.empty() ? nullptr : std::get_if<Incise>(&out.back());
    if (next && next->path.empty()) continue;
    const bool alike = next && cut && !next->spline && !cut->spline && next->depth_mm == cut->depth_mm &&
                       std::abs(next->angle_deg - cut->angle_deg) < 0.5;
    if (alike && (next->path.front() - cut->path.back()).norm() <= kGoesOn_mm)
      cut->path.insert(cut->path.end(), next->path.begin(), next->path.end());
    else
      out.push_back(act.command);
  }
  std::erase_if(out, [](const Command& c) {
    const auto* cut = std::get_if<Incise>(&c);
    return cut && path_mm(cut->path) < kNothing_mm;
  });
  return out;
}

/// "3 incisions of 40, 20 and 12 mm, 4 mm deep"; of many only how long they are together. One: as its row says.
std::string sentence_of(const std::vector<Incise>& alike) {
  if (alike.size() == 1) return Act<Incise>::deed(alike.front()).sentence;
  constexpr size_t kNamed = 4;
  std::string lengths;
  double together = 0;
  for (size_t i = 0; i < alike.size(); ++i) {
    const double mm = path_mm(alike[i].path);
    lengths += (i == 0 ? "" : i + 1 == alike.size() ? " and " : ", ") + rounded_text(mm, 3);
    together += mm;
  }
  const std::string one = Act<Incise>::deed(alike.front()).sentence, how = one.substr(one.find(" mm") + 3);
  return std::to_string(alike.size()) + " incisions " +
         (alike.size() <= kNamed ? "of " + lengths + " mm" : "of " + rounded_text(together, 3) + " mm together") + how;
}

Deed deed_of(const Command& command) {
  return visit_act(command, []<class C>(const C& c) -> Deed {
    if constexpr (requires { Act<C>::deed(c); })
      return Act<C>::deed(c);
    else
      return {};
  });
}

/// How many there were of each kind, in the order of the first.
class Counted {
 public:
  void add(const Deed& d) {
    if (!d.one) return;
    const auto same = std::find_if(counted_.begin(), counted_.end(),
                                   [&](const auto& k) { return std::string_view(k.first.one) == d.one; });
    if (same == counted_.end())
      counted_.emplace_back(d, 1);
    else
      ++same->second;
  }
  std::vector<std::string> sentences() const {
    std::vector<std::string> out;
    for (const auto& [d, n] : counted_) out.push_back(n == 1 || !d.many ? d.one : std::to_string(n) + d.many);
    return out;
  }

 private:
  std::vector<std::pair<Deed, int>> counted_;
};

}  // namespace

std::string story_of(const std::vector<Command>& commands) {
  std::string story;
  Counted counted;
  std::vector<Incise> alike;  // incisions that are not told yet
  const auto say = [&](const std::string& sentence) { story += (story.empty() ? "" : " ") + sentence + "."; };
  const auto tell_incisions = [&] {
    if (!alike.empty()) say(sentence_of(alike));
    alike.clear();
  };
  for (const Command& command : with_strokes_that_go_on(standing_acts(commands))) {
    const Deed d = deed_of(command);
    if (const auto* cut = std::get_if<Incise>(&command)) {
      if (!alike.empty() && (alike.back().depth_mm != cut->depth_mm || alike.back().angle_deg != cut->angle_deg))
        tell_incisions();
      alike.push_back(*cut);
      continue;
    }
    if (!d.sentence.empty()) tell_incisions(), say(d.sentence);
    counted.add(d);
  }
  tell_incisions();
  for (const Command& c : commands)
    if (std::holds_alternative<Undo>(c) || std::holds_alternative<Redo>(c)) counted.add(deed_of(c));
  for (const std::string& sentence : counted.sentences()) say(sentence);
  return story;
}

std::string title_of_acts(std::span<const Command> script) {
  std::vector<std::string> nouns;
  for (const StandingAct& act : standing_acts(script)) {
    const std::string noun = visit_act(act.command, []<class C>(const C&) -> std::string {
      if constexpr (requires { Act<C>::noun; })
        return Act<C>::noun;
      else
        return {};
    });
    if (!noun.empty() && std::find(nouns.begin(), nouns.end(), noun) == nouns.end()) nouns.push_back(noun);
  }
  std::string title;
  for (size_t i = 0; i < nouns.size(); ++i) title += (i == 0 ? "" : i + 1 == nouns.size() ? " and " : ", ") + nouns[i];
  if (!title.empty()) title[0] = char(title[0] - 'a' + 'A');
  return title;
}

}  // namespace limberg
