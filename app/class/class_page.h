#pragma once
// The page of a class: what the class as a whole gets wrong most, a table that is read at a glance, times and forces,
// and of each student the way of the tool beside the expert's, a picture of the result, and what was off. One file
// that fetches nothing and needs no script, in the style of every page of the program.
//
// Nobody is graded: there is no sum of points, and students stand in the order of their names.
#include <string>
#include <vector>

#include "app/assembly/lesson.h"
#include "app/class/class_table.h"
#include "app/teaching/lesson_plan.h"
#include "app/words/words.h"

namespace limberg {

struct ClassPage {
  const Lesson* lesson = nullptr;  // null: none
  LessonPlan plan;                 // no acts: none
  std::vector<ClassRow> rows;      // the expert first, if there is one; students in the order of their names
  int to_come = 0;                 // sessions that were not measured yet
  int left_out = 0, passed_over = 0;
  bool pseudonyms = true;
  Words w = {};  // its language
  std::string reproduce;
};

std::string class_html(const ClassPage& page);

}  // namespace limberg
