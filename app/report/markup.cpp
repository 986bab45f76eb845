#include "app/report/markup.h"

#include "sim/base/xml_text.h"

namespace limberg::html {

std::string escape(std::string_view text) { return xml_text(text); }

}  // namespace limberg::html
