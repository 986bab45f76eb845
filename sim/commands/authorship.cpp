#include "sim/commands/authorship.h"

#include "sim/commands/kinds.h"
#include "sim/commands/strokes.h"

namespace limberg {

bool is_undoable(const Command& c) {
  if (const auto* h = std::get_if<HeadCommand>(&c))
    return !std::holds_alternative<GrabFragment>(*h) && !std::holds_alternative<DragFragment>(*h) &&
           !std::holds_alternative<Superpose>(*h);
  return !leaves_patient(c) && !std::holds_alternative<Undo>(c) && !std::holds_alternative<Redo>(c) &&
         !std::holds_alternative<SetHook>(c) && !std::holds_alternative<MoveHook>(c) &&
         !std::holds_alternative<ReleaseHook>(c);
}

std::vector<StandingAct> standing_acts(std::span<const Command> script) {
  std::vector<StandingAct> acts;
  std::vector<std::vector<StandingAct>> undone;  // each an entry of the history and what came after it
  bool shown = false;
  for (const Command& c : join_strokes(script)) {
    if (const auto* s = std::get_if<Shown>(&c)) {
      shown = s->begins;
    } else if (std::holds_alternative<Undo>(c)) {
      size_t last = acts.size();
      while (last > 0 && !is_undoable(acts[last - 1].command)) --last;
      if (last == 0) continue;
      // A fragment is grabbed, carried and let go: one entry, that of letting go.
      --last;
      if (const auto* h = std::get_if<HeadCommand>(&acts[last].command); h && std::holds_alternative<LetGo>(*h))
        while (last > 0 && std::holds_alternative<HeadCommand>(acts[last - 1].command) &&
               !is_undoable(acts[last - 1].command))
          --last;
      const auto from = acts.begin() + std::ptrdiff_t(last);
      undone.emplace_back(from, acts.end());
      acts.erase(from, acts.end());
    } else if (std::holds_alternative<Redo>(c)) {
      if (undone.empty()) continue;
      for (StandingAct& a : undone.back()) acts.push_back(std::move(a));
      undone.pop_back();
    } else if (!leaves_patient(c)) {
      if (is_undoable(c)) undone.clear();
      acts.push_back({c, shown});
    }
  }
  return acts;
}

std::vector<Command> own_acts(std::span<const Command> script) {
  std::vector<Command> own;
  bool shown = false;
  for (const Command& c : script)
    if (const auto* s = std::get_if<Shown>(&c))
      shown = s->begins;
    else if (!shown)
      own.push_back(c);
  return own;
}

bool was_shown(std::span<const Command> script) {
  bool shown = false;
  for (const Command& c : script)
    if (const auto* s = std::get_if<Shown>(&c))
      shown = s->begins;
    else if (shown && !leaves_patient(c) && !std::holds_alternative<Undo>(c))
      return true;
  return false;
}

}  // namespace limberg
