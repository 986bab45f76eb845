#include "app/export/story.h"

#include <algorithm>

#include "app/result/result.h"
#include "sim/base/whole_file.h"
#include "sim/measure/patient.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

ExportStory::ExportStory(const Scene& scene, const std::string& out_dir, const StoryKinds& kinds)
    : scene_(scene), out_dir_(out_dir), kinds_(kinds) {}

std::string ExportStory::layers() const {
  std::string text;
  if (!scene_.flesh) return text;
  for (size_t i = 0; i < scene_.layers().size(); ++i)
    text += (i ? ", " : "") + std::to_string(i) + " " + scene_.layers()[i].name;
  for (size_t r = 0; r < scene_.regions.size(); ++r)
    text += ", " + std::to_string(scene_.layers().size() + r) + " " + scene_.regions[r].name;
  return text;
}

StoryMoment ExportStory::moment(const World& world, double t_s, const std::string& name, const std::string& folder) {
  world.fill(now_);
  StoryMoment out{t_s, hex(world.state_hash()), 0, {}};
  if (kinds_.glb) gltf_.add(t_s, name, now_);
  if (kinds_.csv) tables_.forces(t_s, name, now_);
  if (kinds_.csv && world.skin())
    tables_.moment(t_s, name, out.state_hash, measure_world(world, acts_, {{}, scene_.landmarks, {}}));
  const VtkMoment told{name, out.state_hash, layers(), t_s};
  const auto leave = [&](const char* file, const std::string& bytes, std::vector<PvdEntry>& list) {
    write_whole_file(folder + "/" + file, bytes);
    out.files.push_back(file);
    const std::string below = folder.size() > out_dir_.size() ? folder.substr(out_dir_.size() + 1) + "/" : "";
    list.push_back({t_s, below + file});
  };
  if (const SoftTissue* skin = world.skin()) {
    for (const Vec3f& u : skin->solver().displacement_mm())
      out.displacement_max_mm = std::max(out.displacement_max_mm, double(u.norm()));
    if (kinds_.vtk) leave("lattice.vtu", vtu_bytes(lattice_fields(*skin), told), lattices_);
  }
  if (kinds_.vtk && has_surface(now_)) {
    std::vector<MembraneState> states;
    if (world.skin()) states = skin_states(now_.topology->view, now_.x_mm, *world.skin()->spec().body);
    leave("skin.vtp", vtp_bytes(now_, states, told), skins_);
  }
  return out;
}

void ExportStory::frame(const World& world, double t_s) {
  world.fill(now_);
  if (kinds_.glb) gltf_.add(t_s, "", now_);
  if (kinds_.csv) tables_.forces(t_s, "", now_);
}

void ExportStory::hands(double t_s, const HandState& hands) {
  if (kinds_.csv) tables_.hands(t_s, hands);
}

std::vector<std::string> ExportStory::finish() {
  std::vector<std::string> out;
  const auto leave = [&](const char* file, const std::string& bytes) {
    write_whole_file(out_dir_ + "/" + file, bytes);
    out.push_back(file);
  };
  if (!gltf_.empty()) leave("operation.glb", gltf_.bytes(scene_.name));
  if (kinds_.collections && !lattices_.empty()) leave("lattice.pvd", pvd_text(lattices_));
  if (kinds_.collections && !skins_.empty()) leave("skin.pvd", pvd_text(skins_));
  if (!tables_.measures().empty()) leave("measures.csv", tables_.measures());
  if (!tables_.forces().empty()) leave("forces.csv", tables_.forces());
  if (!tables_.hands().empty()) leave("hands.csv", tables_.hands());
  return out;
}

}  // namespace limberg
