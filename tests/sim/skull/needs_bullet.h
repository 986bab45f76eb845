#pragma once
// For tests that hold a bone or build a head's patient: where the program was built without Bullet they are skipped,
// and say what is missing. bone/test_part.cpp fails where the part should be there and is not.
#include <gtest/gtest.h>

#include <string>

#include "sim/skull/bone/rigid_world.h"

#define LIMBERG_NEEDS_BULLET() \
  if (const std::string why = limberg::bone::why_no_physics(); !why.empty()) GTEST_SKIP() << why
