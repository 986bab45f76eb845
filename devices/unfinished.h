#pragma once
// Recordings that were left without their end mark: their session was killed, crashed or lost its machine.
#include <optional>
#include <string>
#include <vector>

namespace limberg {

struct UnfinishedRecording {
  std::string file;
  double length_s = 0;  // as far as it is on the disk
};

/// Of a recording of a session that has no end mark and that nobody is writing at the moment; looks at its ends only.
std::optional<UnfinishedRecording> unfinished_recording(const std::string& file);
/// The longest unfinished recording in a folder that no other recording there goes on with.
std::optional<UnfinishedRecording> longest_unfinished(const std::string& folder);
/// What seeds[kGoesOnWith] of a recording says that goes on with this one: of its first event. 0: it cannot be read.
uint64_t recording_mark(const std::string& file);

}  // namespace limberg
