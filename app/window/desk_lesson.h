#pragma once
// The panels of a lesson: the goal and its steps beside the patient, the next step over it, how the present stroke lies
// against the plan, a question, and how a try went beside earlier ones. Drawn with Dear ImGui; what it asks for is in
// the state, for whoever carries it out.
#include <vector>

#include "app/teaching/coach.h"
#include "app/window/hand_feed.h"

namespace limberg {

struct DeskLesson {
  // Asked for in this frame:
  bool again = false;              // another try
  int answer = 0;                  // the number of an answer
  std::optional<double> number;    // an answer that is a number
  bool place = false;              // the place under the mouse is the answer
  std::optional<LessonMode> mode;  // another one

  /// In the panel beside the patient. `next`, `clean`, `summary`: set where a button asks for it.
  void steps(const Coach& coach, const char* title, float height, bool showing, bool& next, bool& clean, bool& summary);
  /// Over the patient, from `y` down, between x and x + w, at most `most` high. Returns where it ends; what it covers
  /// goes into `covered`.
  float next_step(const Coach& coach, float x, float y, float width, float most, std::vector<FrameRect>& covered);
  /// How the stroke lies against the plan, above `bottom`.
  void stroke(const Coach& coach, float x, float w, float bottom);
  /// How it went: each try a column; three things to do better.
  void summary(const Coach& coach, int width, int height, bool& open, std::vector<FrameRect>& covered);

 private:
  /// What is asked, by a place or a number (desk_question.cpp).
  void asked(const LessonQuestion& question, const Words& words);
  float number_typed_ = 0;
  float rows_high_ = 0;  // of the summary
};

}  // namespace limberg
