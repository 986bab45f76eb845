#pragma once
// What viewer/embed.cmake has made of the files that go into a page.

namespace limberg {

extern const char* const three_js_text;  // empty: the build found none
extern const char* const viewer_js_text;
extern const char* const viewer_css_text;

}  // namespace limberg
