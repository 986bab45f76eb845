#pragma once
// The elements of a page, each a function from words and data to Markup. Their looks stand in style.cpp. What holds
// nothing, a section without a body or a row of cards without a card, is nothing.
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/markup.h"

namespace limberg::html {

/// How a figure stands to its limits.
enum class Light : uint8_t { none, good, warn, bad };

// Within a line.
Markup bold(const Markup& words, Light light = Light::none);
Markup soft(const Markup& words);
Markup code(const Markup& words);
Markup dot(Light light);
Markup line_break();
/// Words with more words for whoever points at them.
Markup explained(const Markup& words, const std::string& more);

// Blocks.
Markup paragraph(const Markup& words);
Markup soft_paragraph(const Markup& words);
Markup note(const Markup& words);
Markup notice(const Markup& words);
Markup verdict(Light light, const Markup& words);
Markup list(const std::vector<Markup>& items);
/// As it stands, line by line.
Markup lines(const Markup& text);

/// A figure of the result in large letters.
struct Card {
  std::string value, name, why;
  Light light = Light::none;
};
Markup cards(const std::vector<Card>& all);

/// A picture by its address and what stands below it; no address: the words alone.
Markup figure(const std::string& url, const std::string& alt, const Markup& caption);
/// A map on the chart at rest.
Markup map(const std::string& url, const std::string& alt);
/// The largest picture of a page.
Markup hero(const Markup& figure);
/// Figures side by side; in pairs: two in each row.
Markup story(const Markup& figures);
Markup pairs(const Markup& figures);
/// A drawing that svg_chart.h has made; wider than a phone it scrolls.
Markup chart(const std::string& svg);

struct Cell {
  template <std::convertible_to<Markup> Words>
  Cell(const Words& what, Light shown = Light::none) : words(what), light(shown) {}
  Markup words;
  Light light;
  bool soft = false, bar = false;  // bar: of the column of meters
};
Cell soft_cell(const Markup& words);
/// A bar over so much of the column's width; nothing: an empty cell of that column.
Cell meter(std::optional<double> share, Light light);

using Row = std::vector<Cell>;
/// An empty head: none. A table wider than the page scrolls.
Markup table(const Row& head, const std::vector<Row>& rows);
/// Its first and last columns are words, which may take several lines.
Markup table_of_words(const Row& head, const std::vector<Row>& rows);

/// A title of the third order and what belongs to it.
Markup titled(const Markup& title, const Markup& body);
Markup section(const Markup& title, const Markup& body);
/// A section of which only the title is seen until it is opened.
Markup folded(const Markup& title, const Markup& body);

}  // namespace limberg::html
