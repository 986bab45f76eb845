#pragma once
// A class as a table for a teacher's own statistics: one row a student, columns with their units, and a table that says
// what each column is.
#include <string>
#include <vector>

#include "app/class/findings.h"

namespace limberg {

/// One who is shown: measured, walked along the plan, looked at.
struct ClassRow {
  ClassMember member;
  ClassWalk walk;
  std::vector<Finding> findings;
  bool expert = false;
};

struct ClassColumn {
  std::string name, unit, meaning;
  std::vector<std::string> value;  // a row each; empty: not measured
};
/// The columns of these rows, in the table's order: the name first, whether it is the expert second.
std::vector<ClassColumn> class_columns(const std::vector<ClassRow>& rows);

/// RFC 4180, a point as decimal sign.
std::string csv_of(const std::vector<ClassColumn>& columns);
/// column,unit,meaning
std::string csv_of_meanings(const std::vector<ClassColumn>& columns);
std::string csv_field(const std::string& text);

/// What the closure pulls with, and where most.
struct ClassForces {
  Maybe peak_N, mean_N, closure_N, x_mm, y_mm;
};
ClassForces forces_of(const ClassMember& member);

}  // namespace limberg
