#pragma once
// The table of acts (table.h) as plain data: for help, for panels, for tests.
#include <string>
#include <vector>

#include "sim/commands/field.h"

namespace limberg {

/// One field of a line, in words.
struct ActionField {
  Field field;
  std::string kind;       // "number", "true or false", "points [x, y]", ...
  std::string unit;       // "mm", "degrees", "kPa", "s" or nothing
  std::string limits;     // "above 0 to 200", "at least 3", "bone or face", or nothing
  std::string otherwise;  // its default; empty where it must be given
};

/// One kind of line.
struct ActionLine {
  std::string name, form;  // form: " by a contour", where an action has two
  bool of_head = false;
  std::string help, example;
  std::vector<ActionField> fields;
};

/// All of them, in the order of the table.
const std::vector<ActionLine>& action_lines();
/// The fields of an action, of its first form. std::logic_error: there is no such action.
const std::vector<ActionField>& action_fields(const std::string& action);
/// The field of an action. std::logic_error: there is none of that name.
const ActionField& action_field(const std::string& action, const std::string& key);

/// The table as text, or as Markdown. `action`: of this one only; empty: of all.
std::string actions_text(const std::string& action = {});
std::string actions_markdown();

}  // namespace limberg
