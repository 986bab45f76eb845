#include "app/patient/scene_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/commands/script.h"

namespace limberg {

namespace {

std::string place(const Vec3& x) { return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", x.x(), x.y(), x.z()); }

/// As a scene writes places; no -0.
Vec3 to_hundredths(const Vec3& x) { return ((100 * x).array().round() / 100 + 0.).matrix(); }

const FoundLandmark* find(const PatientModel& p, const std::string& name) {
  const auto& all = p.anatomy.landmark;
  const auto at = std::find_if(all.begin(), all.end(), [&](const FoundLandmark& l) { return l.name == name; });
  return at == all.end() ? nullptr : &*at;
}

/// A TOML string.
std::string quoted_toml(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    if (c == '"' || c == '\\')
      out += '\\', out += c;
    else if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f)
      out += c;
  return out + "\"";
}

}  // namespace

std::string patient_scene(const PatientModel& p, double reach_mm, const std::string& note) {
  std::string bones, fixed;
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const PatientBone& b : p.bone) {
    bones += (bones.empty() ? "" : ", ") + quoted_toml(b.name + ".simplex");
    if (b.name != "mandible") fixed += (fixed.empty() ? "" : ", ") + quoted_toml(b.name);
    for (const Vec3& x : b.mesh.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  const bool face = p.face.slots() > 0;
  for (const Vec3& x : p.face.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  std::string t = "# Made by `limberg patient`; places in mm, x right, y forwards, z up, origin between the porions.\n";
  t += "name = \"patient\"\nnote = " + quoted_toml(note) + "\n\n[head]\nsource = \"files\"\nbones = [" + bones + "]\n";
  if (face) t += "face = \"face.simplex\"\n";
  t += "fixed = [" + fixed + "]\niterations_per_step = 12\n\n";
  if (face && reach_mm > 0)
    t += fmt::format(
        "# Soft tissue between bone and the skin over it.\n[[head.tissue]]\nname = \"soft tissue\"\nface = "
        "\"sn\"\nface_radius_mm = {:.0f}\nlayers = {}\nyoung_kPa = {:.0f}\nmode = \"finite_elements\"\n\n",
        reach_mm, kPatientTissueLayers, kPatientTissue_kPa);
  for (const bool skin : {false, true}) {
    if (skin && !face) break;
    t += skin ? "\n[head.face_landmarks]\n" : "[head.landmarks]\n";
    for (const FoundLandmark& l : p.anatomy.landmark)
      if (l.on_skin == skin)
        t += quoted_toml(l.name) + " = " + place(l.at_mm) + fmt::format("  # within {:.1f} mm a coordinate\n", l.sd_mm);
  }
  const Vec3 middle = 0.5 * (low + high);
  t += "\n[camera]\ntarget_mm = " + place(middle) + "\nfrom = [-0.6, 1.0, 0.16]\nup = [0, 0, 1]\n" +
       fmt::format("distance_mm = {:.0f}\nfov_deg = 26\n", 1.9 * (high - low).norm());
  return t;
}

std::string genioplasty_script(const PatientModel& p) {
  const FoundLandmark *pog = find(p, "Pog"), *me = find(p, "Me");
  const auto jaw =
      std::find_if(p.bone.begin(), p.bone.end(), [](const PatientBone& x) { return x.name == "mandible"; });
  if (!pog || !me || jaw == p.bone.end()) return "";
  // The lowest 14 mm of the chin, where no roots of teeth are, by a plane that rises backwards by 15 degrees as the
  // lower border does. The piece is named by its lowest place.
  const Vec3 at(0, me->at_mm.y(), me->at_mm.z() + 14);
  CutBone cut;
  cut.point_mm = to_hundredths(at), cut.normal = Vec3(0, 0.26, 0.97), cut.radius_mm = 32;
  MoveFragment forwards;
  forwards.fragment.at_mm = to_hundredths(me->at_mm);
  forwards.by.translation_mm = {0, 6, 0}, forwards.seconds = 3;
  Script s;
  s.header.scene = "patient", s.header.note = "Genioplasty: the chin is cut off and carried 6 mm forwards";
  for (const Command& c : {Command(Stage{"before"}), Command(HeadCommand(cut)), Command(Stage{"chin cut"}),
                           Command(HeadCommand(forwards)), Command(Stage{"chin forwards"})})
    s.lines.push_back({0, c});
  return to_text(s);
}

}  // namespace limberg
