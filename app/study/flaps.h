#pragma once
// The studies of whole operations; what each is about stands in flaps.cpp.
#include "app/study/study.h"

namespace limberg::study {

Family zplasty();
Family rhomboid();
Family fusiform();

}  // namespace limberg::study
