#include "sim/commands/procedures/catalogue.h"

#include <charconv>
#include <cmath>

#include "sim/base/error.h"
#include "sim/commands/procedures/figures.h"

namespace limberg {
namespace {

using V = const std::vector<double>&;

std::string plain(double v) {
  char t[40];
  return {t, std::to_chars(t, t + sizeof t, v).ptr};
}

std::vector<Procedure> all() {
  using namespace figures;
  return {
      {"fusiform",
       "Spindle-shaped excision, closed in a line from the middle",
       {{"width_mm", "of the wound", 14, 4, 60}, {"ratio", "length over width", 3.5, 1.5, 8}},
       [](V v) { return fusiform(v[0], v[1]); }},
      {"m_plasty",
       "Fusiform excision whose right end is shortened to an M",
       {{"width_mm", "of the wound", 14, 4, 60},
        {"ratio", "length over width before the shortening", 3, 1.5, 8},
        {"tip_share", "width where the M begins, of the whole width", 0.7, 0.3, 0.95},
        {"tip_deg", "of each of the two small tips", 40, 25, 80}},
       [](V v) { return m_plasty(v[0], v[1], v[2], v[3]); }},
      {"rhomboid",
       "Limberg's flap for a rhombic defect",
       {{"side_mm", "of the rhombus", 20, 6, 60}, {"angle_deg", "acute angle of the rhombus", 60, 40, 90}},
       [](V v) { return rhomboid(v[0], v[1]); }},
      {"dufourmentel",
       "Dufourmentel's flap for a rhombic defect",
       {{"side_mm", "of the rhombus", 20, 6, 60}, {"angle_deg", "acute angle of the rhombus", 75, 50, 90}},
       [](V v) { return dufourmentel(v[0], v[1]); }},
      {"webster",
       "Webster's flap with a narrow tip for a rhombus of 60 degrees (without the M-plasty at its base)",
       {{"side_mm", "of the rhombus", 20, 6, 60}, {"tip_deg", "of the flap", 30, 20, 60}},
       [](V v) { return webster(v[0], v[1]); }},
      {"z_plasty",
       "Z-plasty: two flaps change places and lengthen the line between them",
       {{"limb_mm", "of all three limbs", 20, 5, 60},
        {"angle_a_deg", "at the upper end", 60, 20, 100},
        {"angle_b_deg", "at the lower end", 60, 20, 100}},
       [](V v) { return z_plasty(v[0], v[1], v[2]); }},
      {"multiple_z",
       "Several Z-plasties in a row along one scar",
       {{"length_mm", "of the scar", 36, 10, 100},
        {"count", "how many", 3, 2, 6},
        {"angle_deg", "of every flap", 60, 30, 75}},
       [](V v) { return multiple_z(v[0], int(v[1] + 0.5), v[2]); }},
      {"four_flap_z",
       "Z-plasty of four flaps",
       {{"limb_mm", "of all five limbs", 20, 5, 60}, {"angle_deg", "of each flap", 45, 30, 60}},
       [](V v) { return four_flap_z(v[0], v[1]); }},
      {"v_y",
       "V-Y advancement of an island on its fat",
       {{"width_mm", "of defect and island", 16, 5, 50},
        {"height_mm", "of the island", 28, 8, 90},
        {"advance_mm", "height of the defect", 6, 2, 25}},
       [](V v) { return v_y(v[0], v[1], std::min(v[2], 0.6 * v[1])); }},
      {"keystone",
       "Keystone island on its fat, over a spindle-shaped defect",
       {{"width_mm", "of the defect", 9, 4, 40},
        {"ratio", "length over width of the defect", 3, 2, 6},
        {"flap_ratio", "width of the island over that of the defect", 1.2, 1, 3},
        {"v_mm", "of each V that closes to a Y", 2.5, 1, 15}},
       [](V v) { return keystone(v[0], v[1], v[2], std::min(v[3], 0.6 * v[0] * v[2])); }},
      {"advancement",
       "Advancement flap with Burow's triangles",
       {{"width_mm", "of the square defect", 10, 5, 40},
        {"length_mm", "of the flap", 36, 10, 90},
        {"burow_mm", "height of the triangles", 7, 3, 40}},
       [](V v) { return advancement(v[0], std::max(v[1], 1.5 * v[0]), v[2]); }},
      {"rotation",
       "Rotation flap over a triangular defect",
       {{"radius_mm", "of the circle", 32, 10, 80},
        {"defect_deg", "at the circle's centre", 28, 10, 40},
        {"arc_deg", "of the flap", 120, 60, 170}},
       [](V v) { return rotation(v[0], v[1], v[2]); }},
      {"banner",
       "Banner flap: one lobe turns into a round defect; along the fold it is a nasolabial flap",
       {{"diameter_mm", "of the defect", 11, 4, 30},
        {"turn_deg", "of the flap about its pivot", 60, 40, 90},
        {"tip_ratio", "of the flap's point beyond its middle, in radii of the defect", 1.6, 1.2, 2.2}},
       [](V v) { return banner(v[0], v[1], v[2]); }},
      {"bilobed",
       "Bilobed flap for a round defect",
       {{"diameter_mm", "of the defect", 15, 4, 30}, {"turn_deg", "of each lobe about the pivot", 45, 35, 60}},
       [](V v) { return bilobed(v[0], v[1]); }},
      {"o_to_z",
       "Two flaps turn into a round defect",
       {{"diameter_mm", "of the defect", 16, 4, 40},
        {"cut_ratio", "length of each cut over the diameter", 1.6, 1, 2.5},
        {"tip_deg", "of each flap, between its cut and the defect's edge", 25, 10, 45}},
       [](V v) { return o_to_z(v[0], v[1], v[2]); }},
  };
}

}  // namespace

std::vector<double> Procedure::defaults() const {
  std::vector<double> v;
  for (const ProcedureParameter& p : parameters) v.push_back(p.value);
  return v;
}

const std::vector<Procedure>& procedures() {
  static const std::vector<Procedure> list = all();
  return list;
}

const Procedure& find_procedure(const std::string& name) {
  std::string list;
  for (const Procedure& p : procedures()) {
    if (p.name == name) return p;
    list += (list.empty() ? "" : ", ") + p.name;
  }
  throw InputError(name, 0, "no such procedure; expected one of: " + list);
}

std::vector<double> procedure_values(const Procedure& p, const std::vector<std::string>& settings) {
  std::vector<double> v = p.defaults();
  std::vector<bool> given(v.size());
  for (const std::string& s : settings) {
    const size_t equals = s.find('=');
    size_t i = 0;
    while (i < v.size() && p.parameters[i].name != s.substr(0, equals)) ++i;
    if (i == v.size() || equals == std::string::npos) {
      std::string list;
      for (const ProcedureParameter& q : p.parameters) list += (list.empty() ? "" : ", ") + q.name;
      throw InputError(p.name, 0, "--set " + s + " names no parameter; expected NAME=VALUE with one of: " + list);
    }
    if (given[i]) throw InputError(p.name, 0, "--set " + p.parameters[i].name + " is given twice; expected each once");
    given[i] = true;
    const auto r = std::from_chars(s.data() + equals + 1, s.data() + s.size(), v[i]);
    if (r.ec != std::errc() || r.ptr != s.data() + s.size() ||
        !(v[i] >= p.parameters[i].lo && v[i] <= p.parameters[i].hi))
      throw InputError(
          p.name, 0,
          "--set " + s + "; expected a number from " + plain(p.parameters[i].lo) + " to " + plain(p.parameters[i].hi));
  }
  return v;
}

}  // namespace limberg
