#pragma once
// The look of the report: one style sheet for phone, desk, dark screen and paper.
namespace limberg {
extern const char* const report_style;
}
