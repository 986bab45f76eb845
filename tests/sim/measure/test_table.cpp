#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "sim/measure/table.h"

namespace limberg {
namespace test_table {

/// A unit that a name ends in must be the unit that the table gives: "dog_ear_volume_mm3" is in mm³.
std::string unit_of_name(std::string name) {
  static const std::pair<const char*, const char*> units[] = {
      {"_N_per_m", "N/m"}, {"_mm3", "mm³"}, {"_mm2", "mm²"}, {"_mm", "mm"},      {"_kPa", "kPa"},
      {"_mJ", "mJ"},       {"_N", "N"},     {"_id", ""},     {"_deg", "degrees"}};
  for (const auto& [end, unit] : units)
    if (name.ends_with(end)) return unit;
  return "";
}

TEST(MeasureTable, NamesAreOneEachAndEndInTheirUnit) {
  std::set<std::string> names;
  for (const Measure& m : measure_table()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name;
    if (!std::string(m.name).starts_with("sutures_over")) {
      EXPECT_EQ(unit_of_name(m.name), m.unit) << m.name;
    }
    EXPECT_GT(std::string(m.words).size(), 3u) << m.name;
    EXPECT_GT(std::string(m.definition).size(), 8u) << m.name;
    EXPECT_GT(std::string(m.error).size(), 4u) << m.name;
  }
}

TEST(MeasureTable, AFigureOfAListOrOfBonesHasNoValueAndEveryOtherHasOne) {
  for (const Measure& m : measure_table())
    EXPECT_EQ(m.value == nullptr, std::string(m.name).find("[]") != std::string::npos || m.of_bones) << m.name;
}

TEST(MeasureTable, WhatDoesNotApplyHasNoValue) {
  const Metrics none;
  for (const char* name : {"elongation", "elongation_planimetric", "flap_area_mm2", "waste_mm2", "landmark_max_mm",
                           "closure_energy_mJ", "stress_fibre_angle_deg"}) {
    ASSERT_NE(find_measure(name), nullptr) << name;
    EXPECT_FALSE(find_measure(name)->value(none)) << name;
  }
  EXPECT_EQ(find_measure("no_such_figure"), nullptr);
}

TEST(MeasureTable, EachEntryReadsItsOwnField) {
  // Every scalar of Metrics gets a value of its own; no two entries may then give the same one.
  Metrics m;
  double next = 100;
  for (double* v : {&m.volume_mm3,
                    &m.removed_volume_mm3,
                    &m.initial_volume_mm3,
                    &m.volume_change,
                    &m.compression,
                    &m.closure_force_N,
                    &m.suture_force_max_N,
                    &m.suture_gap_max_mm,
                    &m.stretch_max,
                    &m.stretch_p99,
                    &m.stress_max_kPa,
                    &m.stress_p95_kPa,
                    &m.beyond_law_mm2,
                    &m.dog_ear_mm,
                    &m.dog_ear_volume_mm3,
                    &m.wound_gape_mm,
                    &m.wound_gape_mean_mm,
                    &m.gape.widest_mm,
                    &m.gape.open_mm,
                    &m.gape.over_mm,
                    &m.turned.area_mm2,
                    &m.raw.area_mm2,
                    &m.contact_force_N,
                    &m.min_J,
                    &m.suture_force_peak_N,
                    &m.scar_length_mm,
                    &m.closure_line_N_per_m,
                    &m.step_off_mm,
                    &m.step_off_mean_mm,
                    &m.compressed_mm2,
                    &m.inverted_mm3,
                    &m.excised_mm2,
                    &m.landmark_max_mm,
                    &m.penetration.max_mm,
                    &m.penetration.p99_mm,
                    &m.penetration.overlapping_mm2,
                    &m.perfused.undermined_mm2,
                    &m.perfused.least,
                    &m.perfused.farthest_mm,
                    &m.perfused.below_40_mm2,
                    &m.perfused.severed_mm2})
    *v = next++;
  for (int* v : {&m.pieces, &m.suture_force_max_id, &m.inverted_cells, &m.sutures_over_2_5_N, &m.sutures_over_5_N})
    *v = int(next++);
  m.closure_energy_mJ = next++, m.stress_fibre_angle_deg = next++, m.waste_mm2 = next++, m.elongation = next++;
  m.flap_area_mm2 = next++;
  m.elongations.emplace();
  m.elongations->planimetric = next++, m.elongations->stereometric = next++;
  m.landmarks.resize(1);
  std::set<double> seen;
  for (const Measure& k : measure_table())
    if (k.value) {
      const auto v = k.value(m);
      ASSERT_TRUE(v) << k.name;
      EXPECT_GE(*v, 100) << k.name;
      EXPECT_TRUE(seen.insert(*v).second) << k.name;
    }
  EXPECT_EQ(seen.size(), size_t(next - 100));
}

TEST(MeasureTable, LimitsHaveASource) {
  int limited = 0;
  for (const Measure& m : measure_table())
    if (m.limits) {
      ++limited;
      EXPECT_LE(m.limits->warn, m.limits->bad) << m.name;
      EXPECT_GT(std::string(m.limits->source).size(), 20u) << m.name;
    }
  EXPECT_GE(limited, 3);
}

}  // namespace test_table
}  // namespace limberg
