#pragma once
// Reading [[step]] and [[limit]] of a lesson (lesson_steps.h).
#include "app/assembly/lesson_steps.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// InputError with the line where something is missing, unknown or out of its range.
LessonWords read_lesson_words(const toml::table& root, const std::string& file);

}  // namespace limberg
