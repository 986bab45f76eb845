#include "app/patient/scene_text.h"

#include <fmt/format.h>

#include <string>

#include "app/scene/first_scene.h"
#include "app/scene/quoted_toml.h"
#include "sim/skull/face/face_slide.h"

namespace limberg {

namespace {

std::string place(const Vec3& x) { return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", x.x(), x.y(), x.z()); }

/// The bones' section, and a place to go on with it.
std::string head_section(const PatientModel& p, bool face) {
  std::string bones, fixed;
  for (const PatientBone& b : p.bone) {
    bones += (bones.empty() ? "" : ", ") + quoted_toml(b.name + ".simplex");
    if (b.name != "mandible") fixed += (fixed.empty() ? "" : ", ") + quoted_toml(b.name);
  }
  std::string t = "[head]\nsource = \"files\"\nbones = [" + bones + "]\n";
  if (face) t += "face = \"face.simplex\"\n";
  t += "fixed = [" + fixed + "]\niterations_per_step = 12\n";
  // The picture is in left, posterior, superior: the head's frame turned by half a circle about z, and back.
  Eigen::Isometry3d half_turn = Eigen::Isometry3d::Identity();
  half_turn.linear() = Vec3(-1, -1, 1).asDiagonal();
  const Eigen::Isometry3d picture = half_turn * p.anatomy.to_head.inverse();
  t += "# To the frame of the CT: left, posterior, superior.\npicture_from_head = [";
  for (int i = 0; i < 3; ++i)
    t += fmt::format("{}[{:.12f}, {:.12f}, {:.12f}, {:.6f}]", i > 0 ? ", " : "", picture(i, 0), picture(i, 1),
                     picture(i, 2), picture(i, 3));
  return t + "]\n";
}

/// Masseter and temporalis of both sides, where the landmarks that they run between were found. Their constants are
/// engineering choices, those of the muscle round the mouth in the shipped scene `mouth`.
std::string muscles_section(const PatientModel& p) {
  struct Muscle {
    const char *name, *from, *to;
    double radius_mm;
  };
  std::string t;
  for (const char* side : {"R", "L"})
    for (const Muscle& m : {Muscle{"masseter", "Zy", "Go", 12}, Muscle{"temporalis", "Eu", "Zy", 20}}) {
      const std::string from = std::string(m.from) + "_" + side, to = std::string(m.to) + "_" + side;
      if (!find_landmark(p.anatomy.landmark, from) || !find_landmark(p.anatomy.landmark, to)) continue;
      t += fmt::format(
          "[[head.muscle]]\nname = \"{} {}\"\npath = [\"{}\", \"{}\"]\nradius_mm = {:.0f}\nyoung_kPa = 15\nk1_kPa = "
          "4\nk2 = 0.2\n\n",
          m.name, side, from, to, m.radius_mm);
    }
  return t.empty() ? t : "# Fibres within it; the CT does not tell them.\n" + t;
}

/// The scalp slides on the vault, as far down as the middle of the forehead.
std::string slide_section(const PatientModel& p) {
  const FoundLandmark *top = find_landmark(p.anatomy.landmark, "V"), *brow = find_landmark(p.anatomy.landmark, "g'");
  if (!top || !brow) return "";
  return fmt::format(
      "# The scalp slides on the vault; how easily, the CT does not tell.\n[[head.slide]]\nname = \"scalp\"\nat = "
      "\"V\"\nradius_mm = {:.0f}\nkPa_per_mm = {:g}\n\n",
      0.8 * (top->at_mm - brow->at_mm).norm(), simplex::FaceSlide{}.kPa_per_mm);
}

std::string landmarks_section(const PatientModel& p, bool skin) {
  std::string t = skin ? "\n[head.face_landmarks]\n" : "[head.landmarks]\n";
  for (const FoundLandmark& l : p.anatomy.landmark)
    if (l.on_skin == skin)
      t += quoted_toml(l.name) + " = " + place(l.at_mm) + fmt::format("  # within {:.1f} mm a coordinate\n", l.sd_mm);
  return t;
}

std::string camera_section(const PatientModel& p) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const PatientBone& b : p.bone)
    for (const Vec3& x : b.mesh.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  for (const Vec3& x : p.face.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return "\n[camera]\ntarget_mm = " + place(0.5 * (low + high)) + "\nfrom = [-0.6, 1.0, 0.16]\nup = [0, 0, 1]\n" +
         fmt::format("distance_mm = {:.0f}\nfov_deg = 26\n", 1.9 * (high - low).norm());
}

std::string scene_head(const std::string& name, std::string note) {
  std::erase_if(note, is_control);  // of a folder's name
  return "# Made by `limberg patient`; places in mm, x right, y forwards, z up, origin between the porions.\nname = " +
         quoted_toml(name) + "\nnote = " + quoted_toml(note) + "\n\n";
}

}  // namespace

std::string patient_scene(const PatientModel& p, double reach_mm, const std::string& note) {
  const bool face = p.face.slots() > 0;
  std::string t = scene_head("patient", note) + head_section(p, face) + "\n";
  if (face && reach_mm > 0)
    t += fmt::format(
             "# Soft tissue between bone and the skin over it.\n[[head.tissue]]\nname = \"soft tissue\"\nface = "
             "\"sn\"\nface_radius_mm = {:.0f}\nlayers = {}\nyoung_kPa = {:.0f}\nmode = \"finite_elements\"\n\n",
             reach_mm, kPatientTissueLayers, kPatientTissue_kPa) +
         muscles_section(p) + slide_section(p);
  t += landmarks_section(p, false);
  if (face) t += landmarks_section(p, true);
  return t + camera_section(p);
}

std::string patient_flesh_scene(const PatientModel& p, const std::string& note) {
  const FoundLandmark* sn = find_landmark(p.anatomy.landmark, "sn");
  const Vec3 origin = sn ? sn->at_mm : Vec3(0, 90, -30);
  std::string t = scene_head("patient_skin", note) + head_section(p, false) + landmarks_section(p, false);
  t += "\n# Script points [x, y] are mm seen from in front: x to the patient's left, y up.\n[body]\nsource = "
       "\"obj\"\nmesh = \"flesh.obj\"\nchart_origin_mm = " +
       place(origin) + "\nchart_e1 = [-1, 0, 0]\nchart_e2 = [0, 0, 1]\ntension_direction = [1, 0, 0]\n";
  for (const auto& [part, what] : {std::pair(FleshPart::skin, "skin"),
                                   {FleshPart::bone, "held"},
                                   {FleshPart::deep, "held_softly"},
                                   {FleshPart::side, "held"}})
    t += fmt::format("\n[[body.tag]]\nmaterial = \"{}\"\nwhat = \"{}\"\n", kFleshParts[size_t(part)], what);
  t += "\n# As in the shipped face; the CT does not tell them.\n" + layers_of_the_shipped_face(1.5) +
       "\n[lattice]\ncell_mm = 5\nwound_cell_mm = 2.5\nrefine_fronts = true\nrefine_pockets = "
       "false\n\n[solver]\niterations_per_step = 10\nseed = 1\n\n[tools]\nmax_depth_mm = 12\ndefault_depth_mm = 4\n";
  return t + camera_section(p);
}

std::string flesh_obj(const PatientFlesh& f) {
  std::string t = "# Soft tissue of a face from a CT, made by `limberg patient`: mm, x right, y forwards, z up.\n";
  for (const Vec3& X : f.X_mm) t += fmt::format("v {:.3f} {:.3f} {:.3f}\n", X.x(), X.y(), X.z());
  for (size_t part = 0; part < std::size(kFleshParts); ++part) {
    t += fmt::format("usemtl {}\n", kFleshParts[part]);
    for (size_t k = 0; k < f.tri.size(); ++k)
      if (size_t(f.part[k]) == part)
        t += fmt::format("f {} {} {}\n", f.tri[k][0] + 1, f.tri[k][1] + 1, f.tri[k][2] + 1);
  }
  return t;
}

}  // namespace limberg
