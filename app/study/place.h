#pragma once
// Scripts that survive a change of mesh, lattice or skin; what is measured stands in place.cpp.
#include "app/study/study.h"

namespace limberg::study {

Family place_scripts();

}  // namespace limberg::study
