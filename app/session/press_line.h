#pragma once
// Questions of a force device to the solver thread, and its answers: the newest of each, nobody waiting.
#include "app/session/triple_buffer.h"
#include "devices/force/stiffness_line.h"

namespace limberg {

class PressLine final : public StiffnessLine {
 public:
  // The device thread's side.
  void ask(const PressQuestion& question) noexcept override { questions_.writing() = question, questions_.publish(); }
  const PressAnswer& newest() noexcept override { return answers_.update(), answers_.reading(); }

  // The solver thread's side. Null: nobody has asked since the last time.
  const PressQuestion* asked() noexcept { return questions_.update() ? &questions_.reading() : nullptr; }
  void answer(const PressAnswer& answer) noexcept { answers_.writing() = answer, answers_.publish(); }

 private:
  TripleBuffer<PressQuestion> questions_;
  TripleBuffer<PressAnswer> answers_;
};

}  // namespace limberg
