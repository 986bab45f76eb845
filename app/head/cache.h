#pragma once
// The synthetic head of a scene, made once: the meshes go into the user's cache folder
// ($XDG_CACHE_HOME/limberg or ~/.cache/limberg) under a name made of its proportions
// and of the program, and the next start reads them in a tenth of the time.
//
// Made or read, the meshes are the same to the last bit: a made one goes through the same text. A cache that is
// missing, damaged (a hash over all of it tells), another's, writable for others or not writable is no error: the head
// is made. Heads are kept for their owner only. LIMBERG_CACHE names another folder; empty: none.
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {

/// make_head or make_anatomical_head, or what an earlier call of this program with the
/// same proportions has left. Throws InputError as make_head.
HeadModel cached_head(const HeadSpec& spec, Workers& workers);
/// The same with the heads in this folder; empty: nowhere.
HeadModel cached_head(const HeadSpec& spec, Workers& workers, const std::string& cache_folder);

/// The landmarks of a kept head: a name and x y z a line. Nothing when a line is no such thing.
std::optional<std::vector<std::pair<std::string, Vec3>>> parse_kept_landmarks(std::string_view text);

}  // namespace limberg
