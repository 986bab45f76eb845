#pragma once
// The call that makes a result again, for its report.
#include <string>

namespace limberg {

/// This call as it was typed, its words quoted for a shell; the
/// program by its name. Empty where the system does not tell.
std::string this_call();

}  // namespace limberg
