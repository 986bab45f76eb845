#include "app/words/placeholders.h"

#include <algorithm>
#include <cctype>

namespace limberg {

Placeholders placeholders_of(std::string_view text) {
  Placeholders p;
  p.piece.emplace_back();
  bool counted = false, numbered = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c != '{' && c != '}') {
      p.piece.back() += c;
      continue;
    }
    if (i + 1 < text.size() && text[i + 1] == c) {  // a brace that is seen
      p.piece.back() += c, ++i;
      continue;
    }
    const size_t end = text.find('}', i);
    if (c == '}' || end == std::string_view::npos) {
      p.wrong = c == '}' ? "a } without its {" : "a { without its }";
      return p;
    }
    const std::string_view inside = text.substr(i + 1, end - i - 1);
    const size_t colon = inside.find(':');
    const std::string_view number = inside.substr(0, colon);
    Placeholder place;
    if (inside.find('{') != std::string_view::npos || number.size() > 2 ||
        !std::all_of(number.begin(), number.end(), [](char d) { return d >= '0' && d <= '9'; })) {
      p.wrong = "{" + std::string(inside) + "} is no place";
      return p;
    }
    (number.empty() ? counted : numbered) = true;
    place.index = number.empty() ? int(p.place.size()) : std::stoi(std::string(number));
    if (colon != std::string_view::npos) place.spec = inside.substr(colon + 1);
    p.place.push_back(std::move(place));
    p.piece.emplace_back();
    i = end;
  }
  if (counted && numbered) p.wrong = "places with numbers and without";
  return p;
}

std::string places_differ(const Placeholders& english, const Placeholders& translated, bool may_omit) {
  const auto shown = [](const Placeholder& p) {
    return "{" + std::to_string(p.index) + (p.spec.empty() ? "" : ":" + p.spec) + "}";
  };
  for (const Placeholder& t : translated.place) {
    const auto same = [&](const Placeholder& e) { return e.index == t.index; };
    const auto e = std::find_if(english.place.begin(), english.place.end(), same);
    if (e == english.place.end()) return "has " + shown(t) + ", which the English has not";
    if (e->spec != t.spec) return "has " + shown(t) + " where the English has " + shown(*e);
  }
  for (const Placeholder& e : english.place)
    if (!may_omit && std::none_of(translated.place.begin(), translated.place.end(),
                                  [&](const Placeholder& t) { return t.index == e.index; }))
      return "lacks " + shown(e);
  return "";
}

std::string by_locale(std::string_view format) {
  std::string out;
  bool inside = false, colon = false;
  for (size_t i = 0; i < format.size(); ++i) {
    const char c = format[i];
    if (c == '{' && i + 1 < format.size() && format[i + 1] == '{') {
      out += "{{", ++i;
      continue;
    }
    if (c == '{') inside = true, colon = false;
    if (inside && c == ':') colon = true;
    if (inside && c == '}') {
      if (colon && !out.empty() && std::string_view("fgeFGE").find(out.back()) != std::string_view::npos)
        out.insert(out.size() - 1, 1, 'L');
      inside = false;
    }
    out += c;
  }
  return out;
}

}  // namespace limberg
