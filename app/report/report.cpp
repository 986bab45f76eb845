#include "app/report/report.h"

#include <filesystem>

#include "app/report/page.h"
#include "app/report/report_data.h"
#include "app/report/report_file.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"
#include "app/report/viewer.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

std::string page(const ReportSource& source) {
  const std::string title = title_of(source.d);
  const Viewer turned = viewer({{title, source.dir}}, source.d.w);
  return text_of({title, title, sections::opening(source), sections::summary(source),
                  turned.section + sections::all(source), sections::footer(source), turned.nonce, source.d.w});
}

}  // namespace

std::string result_file(const std::string& dir) { return (fs::path(dir) / report_names::result).string(); }

std::string read_result_file(const std::string& dir) {
  std::error_code none;
  if (!fs::is_directory(dir, none))
    throw InputError(dir, 0, "is no folder; expected one that a run has left, with result.json");
  return read_whole_file(result_file(dir), size_t(256) << 20, "the result of a run");
}

std::string report_html(const std::string& result_json, const std::string& dir, const Words& w) {
  const ReportData d = read_report_data(result_json, result_file(dir), w);
  return page({d, dir});
}

std::string write_report(const std::string& dir, const Words& w) {
  const std::string text = report_html(read_result_file(dir), dir, w),
                    target = (fs::path(dir) / report_names::html).string();
  write_whole_file(target, text);
  return target;
}

}  // namespace limberg
