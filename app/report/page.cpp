#include "app/report/page.h"

#include <fmt/format.h>

#include "app/report/style.h"

namespace limberg {

namespace {

constexpr const char* kTemplate = R"html(<!DOCTYPE html>
<html xmlns="http://www.w3.org/1999/xhtml" lang="en">
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
  return fmt::format(kTemplate, fmt::arg("title", html::escape(p.title)), fmt::arg("style", report_style),
                     fmt::arg("heading", p.heading.tags()), fmt::arg("opening", p.opening.tags()),
                     fmt::arg("summary", p.summary.tags()), fmt::arg("sections", p.sections.tags()),
                     fmt::arg("footer", p.footer.tags()),
                     fmt::arg("scripts", p.nonce.empty() ? "" : "; script-src 'nonce-" + html::escape(p.nonce) + "'"));
}

}  // namespace limberg
