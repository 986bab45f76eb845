#pragma once
// A recording as the session that it is of: what replay does again, and run --continue goes on with.
#include <string>

#include "app/commands/session_command.h"

namespace limberg {

/// Reads it. InputError: it cannot be read, or holds no session or no sample.
Recording open_session(const std::string& file);

/// InputError: it is a session of another scene. One that differs in comments only is the same.
void expect_scene_of(const Recording& recording, const std::string& file, const Scene& scene);

/// Scene, calibration, rates and expected hashes of it; says what is damaged. InputError: its scene is not whole.
void take_session(SessionCall& call, const Recording& recording, const std::string& file);

/// Its samples: as its threads took them then, where they were recorded so, are whole and `as_it_was`; else as a source
/// on an even clock.
void take_samples(SessionCall& call, Recording recording, const std::string& file, bool as_it_was);

/// The session of that recording, to go on with: all of it that is whole. InputError as open_session and take_session.
SessionCall continued_session(const std::string& file);

}  // namespace limberg
