// Questions of a lesson that are answered by pointing at a place, or by a number.
#include <imgui.h>

#include "app/window/desk_lesson.h"
#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

void DeskLesson::asked(const LessonQuestion& q, const Words& w) {
  if (q.place) {
    text(ink::hint(), w("Click on the place, or point at it and press K."));
    tip(w("arrows lead the pointer; with a stylus K means where its tip is"));
  } else if (q.number) {
    ImGui::PushItemWidth(96);
    const bool entered =
        ImGui::InputFloat("##number", &number_typed_, 0, 0, "%.1f", ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::PopItemWidth();
    ImGui::SameLine();
    if (!q.unit.empty()) ImGui::TextUnformatted(q.unit.c_str()), ImGui::SameLine();
    if (button(w, "Answer") || entered) number = double(number_typed_);
  }
}

}  // namespace limberg
