#pragma once
// The sections of the report, each from the data to HTML; empty when there is nothing to show.
#include <string>

#include "app/report/report_data.h"
#include "sim/measure/table.h"

namespace limberg::sections {

inline constexpr double kAtRest = 1e-4;  // residual below which the tissue counts as at rest

/// A picture of a result as a data URL, made smaller to so many pixels; a name that leads out of the folder gives
/// nothing.
std::string picture_url(const std::string& dir, const std::string& name, int widest = 1600);

/// "good", "warn" or "bad".
std::string light_of_force(double force_N);

std::string heading(const ReportData& d, const std::string& dir);  // title, verdict, picture, key figures
std::string story(const ReportData& d, const std::string& dir);
std::string tension(const ReportData& d, const std::string& dir);
std::string gallery(const ReportData& d, const std::string& dir);
std::string sutures(const ReportData& d);
std::string exercise(const ReportData& d);  // lesson, tolerances, figures of the hand
std::string closing(
    const ReportData& d,
    const std::string&
        dir);  // force over time or actions, charts and tables that the command left, predicted points, landmarks
std::string balance(const ReportData& d);
std::string convergence(const ReportData& d);
std::string chart_figure(const ResultChart& chart);  // a chart that a command left, with its title
std::string bars(const ReportData& d);               // what was asked of a study or a bench, and whether it was met
std::string study(const ReportData& d);
std::string timing(const ReportData& d);
std::string residual(const ReportData& d);
std::string figures(const ReportData& d);
std::string script(const ReportData& d);
std::string footer(const ReportData& d);

/// A title for the page.
std::string title(const ReportData& d);

}  // namespace limberg::sections
