#pragma once
// Rhomboid flaps by shape and fusiform excisions by ratio (patch.h says on what they are done), and the shipped
// rhomboid flap by its tissue.
#include "app/study/study.h"

namespace limberg::study {

Family rhomboid();
Family fusiform();
Family tissue_flap();

}  // namespace limberg::study
