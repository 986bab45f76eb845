#pragma once
// Rhomboid flaps by shape and fusiform excisions by ratio; patch.h says on what they are done.
#include "app/study/study.h"

namespace limberg::study {

Family rhomboid();
Family fusiform();

}  // namespace limberg::study
