#include "app/patient/scene_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace limberg {

namespace {

std::string place(const Vec3& x) { return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", x.x(), x.y(), x.z()); }

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
  // The picture is in left, posterior, superior: the head's frame turned by half a circle about z, and back.
  Eigen::Isometry3d half_turn = Eigen::Isometry3d::Identity();
  half_turn.linear() = Vec3(-1, -1, 1).asDiagonal();
  const Eigen::Isometry3d picture = half_turn * p.anatomy.to_head.inverse();
  t.pop_back();  // a [head] goes on
  t += "# To the frame of the CT: left, posterior, superior.\npicture_from_head = [";
  for (int i = 0; i < 3; ++i)
    t += fmt::format("{}[{:.12f}, {:.12f}, {:.12f}, {:.6f}]", i > 0 ? ", " : "", picture(i, 0), picture(i, 1),
                     picture(i, 2), picture(i, 3));
  t += "]\n\n";
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

}  // namespace limberg
