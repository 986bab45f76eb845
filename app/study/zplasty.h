#pragma once
// Z-plasties of 20 mm limbs in three settings, after the same
// protocol; what is compared with what stands in zplasty_bars.cpp.
//   zplasty  skin on fat, undermined: the patient
//   plate    the skin alone, on a bed that it can rise from or with nothing beneath it: how far thin skin stands up
//   planar   a membrane that cannot leave its plane, clamped at six
//            limbs: how much of the theory a flat surrounding allows
#include "app/study/study.h"

namespace limberg::study {

inline constexpr double kLimb_mm = 20;

Row run_z(const Values& values,
          const Run& with);  // angle, prestretch, cell_mm, contact, depth_mm, push_mm, spacing_mm, fronts
Row run_plate(const Values& values, const Run& with);   // angle, prestretch, cell_mm, bed
Row run_planar(const Values& values, const Run& with);  // angle, prestretch, cell_mm

/// What a Z-plasty gains, over the height of the dog-ears that it costs, 1/mm.
inline double gain_per_ear(const Row& r) { return (r.at("elongation") - 1) / r.at("ear_mm"); }

std::vector<Bar> bars_z(const std::vector<Row>& rows);
std::vector<Bar> bars_plate(const std::vector<Row>& rows);
std::vector<Bar> bars_planar(const std::vector<Row>& rows);

Family zplasty();
Family plate();
Family planar();

}  // namespace limberg::study
