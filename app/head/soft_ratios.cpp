#include "app/head/soft_ratios.h"

#include <cmath>
#include <initializer_list>
#include <optional>

namespace limberg {

namespace {

constexpr double kLeastMove_mm = 1, kSagittal = 0.8;

struct Pair {
  const char *soft, *bone;
};
constexpr Pair kPairs[] = {{"pog'", "Pog"}, {"sl", "B"},  {"li", "Ii"},      {"gn'", "Gn"},
                           {"me'", "Me"},   {"ls", "Is"}, {"sn", "A"},       {"g'", "G"},
                           {"f'", "F"},     {"n'", "N"},  {"go'_R", "Go_R"}, {"go'_L", "Go_L"}};

struct KnownRatio {
  const char *soft, *of;
  double low, high;
  const char* source;
};
/// From means of moves where a paper gives these: (11 - 0.8) / 11 and (6 - 2.8) / 6 for Veltkamp's 62 patients.
constexpr KnownRatio kKnownRatios[] = {
    {"pog'", "chin", 0.9, 0.93,
     "Veltkamp et al., Am J Orthod Dentofacial Orthop 122 (2002) 627: advanced with a genioplasty"},
    {"pog'", "mandible", 1, 1.1,
     "Naoumova et al., Eur J Orthod 30 (2008) 359: 1:1 in women, 1:1.1 in men, set back; Joss et al., J Oral "
     "Maxillofac "
     "Surg 68 (2010) 1260: near 1:1, advanced by a sagittal split"},
    {"sl", "mandible", 1, 1.1, "Naoumova et al., Eur J Orthod 30 (2008) 359, set back"},
    {"li", "mandible", 0.5, 0.6, "Veltkamp et al., Am J Orthod Dentofacial Orthop 122 (2002) 627: advanced"},
    {"ls", "maxilla", 0.5, 0.62,
     "Dann, Fonseca and Bell, J Oral Surg 34 (1976) 19; Mansour, Burstone and Legan, Am J Orthod 84 (1983) 37"},
};

std::optional<Vec3> place(const NamedPlaces& all, const std::string& name) {
  for (const auto& [n, x] : all)
    if (n == name) return x;
  return std::nullopt;
}

std::optional<Vec3> way(const NamedPlaces& before, const NamedPlaces& now, const std::string& name) {
  const auto a = place(before, name), b = place(now, name);
  if (!a || !b) return std::nullopt;
  return Vec3(*b - *a);
}

}  // namespace

std::vector<SoftRatio> soft_ratios(const NamedPlaces& before, const NamedPlaces& now) {
  const auto moved = [&](const char* name) {
    const auto m = way(before, now, name);
    return m && m->norm() >= kLeastMove_mm;
  };
  const bool teeth_below = moved("Ii");
  std::vector<SoftRatio> out;
  for (const Pair& p : kPairs) {
    const auto bone = way(before, now, p.bone), soft = way(before, now, p.soft);
    if (!bone || !soft || !(bone->norm() >= kLeastMove_mm)) continue;
    SoftRatio r;
    r.soft = p.soft, r.bone = p.bone, r.bone_mm = bone->norm(), r.soft_mm = soft->dot(*bone) / r.bone_mm;
    r.ratio = r.soft_mm / r.bone_mm;
    const auto is = [&](std::initializer_list<const char*> names) {
      for (const char* n : names)
        if (r.bone == n) return true;
      return false;
    };
    // The chin alone where the lower incisors have stayed.
    if (is({"Pog", "B", "Ii", "Gn", "Me", "Go_R", "Go_L"})) r.of = teeth_below ? "mandible" : "chin";
    if (is({"Is", "A"})) r.of = "maxilla";
    // Papers tell of moves forwards and back.
    if (std::abs(bone->y()) < kSagittal * r.bone_mm) r.of.clear();
    for (const KnownRatio& k : kKnownRatios)
      if (r.soft == k.soft && r.of == k.of) r.known_low = k.low, r.known_high = k.high, r.source = k.source;
    out.push_back(std::move(r));
  }
  return out;
}

}  // namespace limberg
