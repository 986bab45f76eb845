#pragma once
#include "app/commands/session_command.h"
#include "sim/commands/script.h"

namespace limberg {

/// `operate` on a scene with a head: one run, to rest. lesson: by which the bones are judged; null: by none.
int operate_head(const Scene& scene, const Script& script, const Lesson* lesson, bool keep_going,
                 const CommonOptions& common);

}  // namespace limberg
