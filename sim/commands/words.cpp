#include "sim/commands/words.h"

#include <cmath>

#include "sim/base/elementary.h"
#include "sim/commands/strokes.h"
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

std::string story_of(const std::vector<Command>& commands) {
  std::string story;
  std::vector<std::pair<Deed, int>> counted;
  const auto say = [&](const std::string& sentence) { story += (story.empty() ? "" : " ") + sentence + "."; };
  for (const Command& command : join_strokes(commands)) {
    const Deed d = visit_act(command, []<class C>(const C& c) -> Deed {
      if constexpr (requires { Act<C>::deed(c); })
        return Act<C>::deed(c);
      else
        return {};
    });
    if (!d.sentence.empty()) say(d.sentence);
    if (!d.one) continue;
    const auto same = std::find_if(counted.begin(), counted.end(),
                                   [&](const auto& k) { return std::string_view(k.first.one) == d.one; });
    if (same == counted.end())
      counted.emplace_back(d, 1);
    else
      ++same->second;
  }
  for (const auto& [deed, n] : counted) say(n == 1 || !deed.many ? deed.one : std::to_string(n) + deed.many);
  return story;
}

}  // namespace limberg
