#pragma once
#include "app/commands/session_command.h"
#include "sim/commands/script.h"

namespace limberg {

/// `operate` on a scene with a head: one run, to rest.
int operate_head(const Scene& scene, const Script& script, bool keep_going, const CommonOptions& common);

}  // namespace limberg
