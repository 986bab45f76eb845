#include "app/report/elements.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

namespace limberg::html {

namespace {

/// An attribute; without a value it is left out.
struct Attribute {
  const char* name;
  std::string_view value;
};

std::string opened(const char* name, std::initializer_list<Attribute> attributes) {
  std::string s = std::string("<") + name;
  for (const Attribute& a : attributes)
    if (!a.value.empty()) s += std::string(" ") + a.name + "=\"" + escape(a.value) + "\"";
  return s;
}
/// <name ...>content</name>, and a line end after a block.
Markup element(const char* name, std::initializer_list<Attribute> attributes, const Markup& content,
               const char* after = "") {
  return Markup::of_tags(opened(name, attributes) + ">" + content.tags() + "</" + name + ">" + after);
}
Markup block(const char* name, std::string_view look, const Markup& content) {
  return element(name, {{"class", look}}, content, "\n");
}
/// A block with its content on lines of its own.
Markup tall_block(const char* name, std::string_view look, const Markup& content) {
  return element(name, {{"class", look}}, Markup::of_tags("\n" + content.tags()), "\n");
}

std::string look_of(Light light) {
  switch (light) {
    case Light::good:
      return "good";
    case Light::warn:
      return "warn";
    case Light::bad:
      return "bad";
    case Light::none:
      break;
  }
  return "";
}
/// Two looks of one element.
std::string both(std::string a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + " " + b; }

Markup image(const std::string& url, const std::string& alt) {
  return Markup::of_tags(opened("img", {{"src", url}, {"alt", alt}}) + "/>");
}

Markup row_of(const char* cell, const Row& row) {
  Markup cells;
  for (const Cell& c : row)
    cells +=
        element(cell, {{"class", both(both(c.bar ? "bar" : "", c.soft ? "soft" : ""), look_of(c.light))}}, c.words);
  return block("tr", "", cells);
}

Markup table_with(std::string_view look, const Row& head, const std::vector<Row>& rows) {
  Markup body;
  for (const Row& r : rows) body += row_of("td", r);
  const Markup top = head.empty() ? Markup() : block("thead", "", row_of("th", head));
  return block("div", "wide", tall_block("table", look, top + tall_block("tbody", "", body)));
}

}  // namespace

Markup bold(const Markup& words, Light light) { return element("b", {{"class", look_of(light)}}, words); }
Markup soft(const Markup& words) { return element("span", {{"class", "soft"}}, words); }
Markup code(const Markup& words) { return element("code", {}, words); }
Markup dot(Light light) { return element("span", {{"class", both("light", look_of(light))}}, {}); }
Markup line_break() { return Markup::of_tags("<br/>"); }
Markup explained(const Markup& words, const std::string& more) { return element("span", {{"title", more}}, words); }

Markup paragraph(const Markup& words) { return block("p", "", words); }
Markup soft_paragraph(const Markup& words) { return block("p", "soft", words); }
Markup note(const Markup& words) { return block("p", "note", words); }
Markup notice(const Markup& words) { return block("div", "notice", words); }
Markup verdict(Light light, const Markup& words) {
  return block("div", both("verdict", look_of(light)), element("div", {}, dot(light) + words));
}
Markup list(const std::vector<Markup>& items) {
  Markup all;
  for (const Markup& i : items) all += block("li", "", i);
  return tall_block("ul", "", all);
}
Markup lines(const Markup& text) { return block("pre", "", text); }

Markup cards(const std::vector<Card>& all) {
  Markup m;
  for (const Card& c : all)
    m += block("div", "card",
               bold(c.value, c.light) + element("span", {}, c.name) +
                   (c.why.empty() ? Markup() : element("span", {{"class", "why"}}, c.why)));
  return m.empty() ? m : tall_block("div", "cards", m);
}

Markup figure(const std::string& url, const std::string& alt, const Markup& caption) {
  return block(
      "figure", "",
      (url.empty() ? Markup() : image(url, alt)) + (caption.empty() ? Markup() : element("figcaption", {}, caption)));
}
Markup map(const std::string& url, const std::string& alt) { return block("figure", "onchart", image(url, alt)); }
Markup hero(const Markup& figure) { return block("div", "hero", figure); }
Markup story(const Markup& figures) { return tall_block("div", "story", figures); }
Markup pairs(const Markup& figures) { return tall_block("div", "story pairs", figures); }
Markup chart(const std::string& svg) { return block("figure", "wide", Markup::of_tags(svg)); }

Cell soft_cell(const Markup& words) {
  Cell c(words);
  c.soft = true;
  return c;
}
Cell meter(std::optional<double> share, Light light) {
  Cell c(Markup(), light);
  c.bar = true;
  if (share) {
    const std::string width = "width:" + std::to_string(std::lround(100 * std::clamp(*share, 0.0, 1.0))) + "%";
    c.words = element("span", {{"class", "meter"}, {"style", width}}, {});
  }
  return c;
}

Markup table(const Row& head, const std::vector<Row>& rows) { return table_with("", head, rows); }
Markup table_of_words(const Row& head, const std::vector<Row>& rows) { return table_with("bars", head, rows); }

Markup titled(const Markup& title, const Markup& body) { return block("h3", "", title) + body; }
Markup folded(const Markup& title, const Markup& body) {
  return body.empty() ? body : tall_block("details", "", block("summary", "", title) + body);
}
Markup section(const Markup& title, const Markup& body) {
  return body.empty() ? body : tall_block("section", "", block("h2", "", title) + body);
}

}  // namespace limberg::html
