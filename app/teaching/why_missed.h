#pragma once
// Why a press came to nothing, and what to do instead, in words.
#include <string>

#include "app/words/words.h"
#include "devices/missed_press.h"
#include "sim/patient/snapshot.h"

namespace limberg {

std::string why_missed(const MissedPress& press, const Snapshot& patient, const Words& words = {});

}  // namespace limberg
