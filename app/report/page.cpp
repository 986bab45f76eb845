#include "app/report/page.h"

#include <fmt/format.h>

#include "app/report/style.h"
#include "app/words/typeset.h"

namespace limberg {

namespace {

constexpr const char* kTemplate = R"html(<!DOCTYPE html>
<html xmlns="http://www.w3.org/1999/xhtml" lang="{language}">
<head>
<meta charset="utf-8"/>
<meta name="viewport" content="width=device-width, initial-scale=1"/>
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'{scripts}"/>
<title>{title} – Limberg</title>
<style>{style}</style>
</head>
<body>
<header>
<h1>{heading}</h1>
{opening}</header>
{summary}<main>
{sections}</main>
<footer>{footer}</footer>
</body>
</html>
)html";

}  // namespace

std::string text_of(const Page& p) {
  const auto typeset = [&](const html::Markup& m) { return typeset_page(m.tags(), p.w.decimal()); };
  return fmt::format(kTemplate, fmt::arg("language", p.w.language()), fmt::arg("title", html::escape(p.title)),
                     fmt::arg("style", report_style), fmt::arg("heading", typeset(p.heading)),
                     fmt::arg("opening", typeset(p.opening)), fmt::arg("summary", typeset(p.summary)),
                     fmt::arg("sections", typeset(p.sections)), fmt::arg("footer", p.footer.tags()),
                     fmt::arg("scripts", p.nonce.empty() ? "" : "; script-src 'nonce-" + html::escape(p.nonce) + "'"));
}

}  // namespace limberg
