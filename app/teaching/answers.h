#pragma once
// Answers to a lesson's question: a choice, a place pointed at on the skin, or a number.
#include <string>

#include "app/assembly/lesson_steps.h"
#include "app/words/words.h"

namespace limberg {

struct Answered {
  bool right = false;
  std::string words;  // "Right. ...", or what it is instead, and why
};

/// By the number of an answer, from 1.
Answered judge_choice(const LessonQuestion& question, int number, const Words& words = {});
/// By a place of the chart, at rest.
Answered judge_place(const LessonQuestion& question, const ChartPoint& at, const Words& words = {});
Answered judge_number(const LessonQuestion& question, double value, const Words& words = {});

}  // namespace limberg
