#include "app/report/report.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/report/html.h"
#include "app/report/report_data.h"
#include "app/report/report_file.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"
#include "app/report/style.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

std::string page(const ReportData& d, const std::string& dir) {
  namespace s = sections;
  return whole_page(s::title(d), s::heading(d, dir) + "<main>\n" + s::study(d) + s::story(d, dir) + s::gallery(d, dir) +
                                     s::tension(d, dir) + s::sutures(d) + s::closing(d, dir) + s::exercise(d) +
                                     s::balance(d) + s::convergence(d) + s::timing(d) + s::residual(d) + s::figures(d) +
                                     s::script(d) + "</main>\n" + s::footer(d));
}

}  // namespace

std::string whole_page(const std::string& title, const std::string& body) {
  return "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
         "charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
         "'unsafe-inline'\"/>\n"
         "<title>" +
         html::escape(title) + " – Limberg</title>\n<style>" + report_style + "</style>\n</head>\n<body>\n" + body +
         "</body>\n</html>\n";
}

std::string result_file(const std::string& dir) { return (fs::path(dir) / report_names::result).string(); }

std::string read_result_file(const std::string& dir) {
  std::error_code none;
  if (!fs::is_directory(dir, none))
    throw InputError(dir, 0, "is no folder; expected one that a run has left, with result.json");
  const std::string source = result_file(dir);
  std::ifstream in(source, std::ios::binary);
  if (!in || !fs::is_regular_file(source, none))
    throw InputError(source, 0, "cannot be read; expected the result of a run");
  return {(std::istreambuf_iterator<char>(in)), {}};
}

std::string report_html(const std::string& result_json, const std::string& dir) {
  return page(read_report_data(result_json, result_file(dir)), dir);
}

std::string write_report(const std::string& dir) {
  const std::string text = report_html(read_result_file(dir), dir),
                    target = (fs::path(dir) / report_names::html).string();
  write_whole_file(target, text);
  return target;
}

}  // namespace limberg
