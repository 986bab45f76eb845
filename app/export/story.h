#pragma once
// An operation as files that other programs turn, measure and play, gathered while it is carried out:
//
//   at a moment     lattice.vtu, skin.vtp in its folder (vtk_files.h)
//   at the end      operation.glb (gltf.h), lattice.pvd and skin.pvd, which name the files of all moments, and the
//                   tables measures.csv, forces.csv, hands.csv (tables.h)
//
// What is written at the end is not there when the work was interrupted; every file is whole or not at all.
#include <string>
#include <vector>

#include "app/export/gltf.h"
#include "app/export/tables.h"
#include "app/export/vtk_files.h"
#include "app/scene/scene.h"
#include "sim/patient/world.h"

namespace limberg {

struct StoryKinds {
  bool glb = true, vtk = true, csv = true;
  bool collections = true;  // PVD: several moments are to come
};

/// What was found at a moment, for whoever compares: the numbers that the files hold.
struct StoryMoment {
  double t_s = 0;
  std::string state_hash;
  double displacement_max_mm = 0;  // of the lattice's nodes
  std::vector<std::string> files;  // beside the surfaces; without their folder
};

class ExportStory {
 public:
  /// `out_dir` is there. `scene` is kept by reference.
  ExportStory(const Scene& scene, const std::string& out_dir, const StoryKinds& kinds);

  /// What the hand or the script has done; figures of a kind of flap need it.
  void act(const Command& command) { acts_.push_back(command); }
  /// Writes into `folder`, which is `out_dir` or one in it.
  StoryMoment moment(const World& world, double t_s, const std::string& name, const std::string& folder);
  /// Between the moments: for the animation and the forces.
  void frame(const World& world, double t_s);
  void hands(double t_s, const HandState& hands);
  /// Writes the files of the whole; their names.
  std::vector<std::string> finish();

 private:
  std::string layers() const;

  const Scene& scene_;
  std::string out_dir_;
  StoryKinds kinds_;
  std::vector<Command> acts_;
  GltfStory gltf_;
  ExportTables tables_;
  std::vector<PvdEntry> lattices_, skins_;
  Snapshot now_;
};

}  // namespace limberg
