#pragma once
// A whole page. Its template, one text with named places, stands in page.cpp: every page of the program goes through
// it, so each has the same style sheet and fetches nothing.
#include <string>

#include "app/report/markup.h"
#include "app/words/words.h"

namespace limberg {

struct Page {
  std::string title;     // of the browser's tab
  html::Markup heading;  // one line, in large letters
  html::Markup opening;  // what it is of, below the heading
  html::Markup summary;  // what it came to, before the sections
  html::Markup sections;
  html::Markup footer;  // what made it
  std::string nonce{};  // of the scripts that may run; empty: none may
  Words w{};            // its language
};

std::string text_of(const Page& page);

}  // namespace limberg
