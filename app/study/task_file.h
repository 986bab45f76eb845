#pragma once
// The members that one task of a cluster runs, as a file: one a line, "tissue flap_angle=60 skin_kPa=43.2 ...".
#include <string>
#include <vector>

#include "app/study/engine.h"

namespace limberg::study {

std::string task_text(const std::vector<Job>& jobs);
/// InputError with file and line: an unknown study or setting, or a line that does not name one member.
std::vector<Job> read_task(const std::string& file);

}  // namespace limberg::study
