#pragma once
// A surgical act, as a script line or a gesture states it: chart points on the skin and mm, nothing of any mesh.
// How each is written in a script, with units, limits and what it means, stands in table.h;
// `limberg actions` prints it. Acts on bones and face are in head_command.h.
#include <string>
#include <variant>
#include <vector>

#include "sim/commands/head_command.h"
#include "sim/commands/in_space.h"

namespace limberg {

struct Undo {};
struct Redo {};
struct Stage {
  std::string name;
};
struct Wait {
  double seconds = 1;
};
/// A bracket around acts that the program has shown: they are not the learner's (authorship.h).
struct Shown {
  bool begins = true;
};

using Command = std::variant<Incise, InciseMore, Undermine, Excise, SetHook, MoveHook, ReleaseHook, Suture, SutureRow,
                             Undo, Redo, Stage, Wait, Shown, Mark, SutureCorner, SutureBetween, CutSuture, ExcisePiece,
                             CutThrough, InSpace, HeadCommand, SutureBite, TieSuture, LetThreadGo, Activate>;

/// What came of a command. A refused one has changed nothing.
struct Outcome {
  bool done = false;
  // when refused: what is wrong and what was expected, one line; when done: what is worth knowing, mostly nothing
  std::string reason;
  bool no_memory = false;  // refused because memory ran out: with more of it the act may be done
};

}  // namespace limberg
