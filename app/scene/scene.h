#pragma once
// A scene: everything about a patient and a session that is chosen beforehand, from one TOML file.
//
//   name = "rhomboid"                      optional, else the file's name
//   note = "..."                           optional
//   [body]       source = "block" | "obj"
//                block: size_mm = [x, y, z], skin_cell_mm, sliding_sides and free_sides (scene_loads.h)
//                obj:   mesh = "file.obj" (relative to the scene file), scale_to_mm, deep_direction = [x, y, z],
//                       deep_center_mm, deep_angle_deg, deep_plane_mm (obj.h), chart_origin_mm, chart_e1,
//                chart_e2
//                both:  tension_direction = [x, y, z]; obj: where its lines run differently in different places,
//                tension_points = [[x, y, z, dx, dy, dz], ...] or tension_file of such rows
//   [[layer]]    name, thickness_mm, young_kPa, poisson,
//                density_kg_m3, prestretch_along, prestretch_across;
//                from the skin down, one at least. Instead of
//                young_kPa a law with its constants, or a tissue of
//                the library, and a Prony series: scene_layers.h
//   [[region]]   tissue of its own within the layers: muscle, cartilage, a scar: scene_regions.h
//   [[collider]] what the tissue lies against: scene_colliders.h
//   [lattice]    cell_mm, refine_fronts (cells in which a cut ends are
//                divided; false), refine_pockets (then also at the rim of
//                what is undermined; true), region_mm (> 0: tissue farther
//                than this from the chart's origin holds still and costs
//                the solver nothing; 0, the default: all of it moves),
//                wound_cell_mm and fine (smaller cells: scene_lattice.h)
//   [loads]      gravity_m_s2 = [x, y, z], patches of skin with a force on them: scene_loads.h
//   [build]      can_cut, dynamic, contact = "auto" | true | false
//                (do wound surfaces keep each other out? auto: as
//                soon as something has been cut, the default),
//                contact_friction (its coefficient, 0 to 1; 0, the default: none)
//   [springs]    suture_N_per_mm, suture_bite_mm (a stitch holds its
//                edge over so much to either side; 2), hook_N_per_mm,
//                hook_tip_mm (radius of the skin that a hook holds; 2)
//   [solver]     iterations_per_step, steps_per_s, damping_per_s, seed, focus,
//                integrator = "backward_euler" | "bdf2" (of dynamic scenes)
//   [tools]      max_depth_mm, default_depth_mm, default_spacing_mm, reach_mm, progressive_cut
//   [landmarks]  NAME = [x, y]: places on the skin whose displacement is measured
//   [head]       skull and face: scene_head.h. With a [head], [body] and [[layer]] may be left out
//   [camera]     target_mm = [x, y, z], from = [x, y, z] (direction
//                towards the eye), up = [x, y, z], distance_mm, fov_deg
//
// Reading is strict: an unknown key, a wrong type, a number that is not finite or out of its range is an InputError
// with the line, what is wrong and what was expected. Everything but [body] and [[layer]], or [head], has a default.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/scene/scene_head.h"
#include "sim/body/block.h"
#include "sim/body/obj.h"
#include "sim/body/tension_lines.h"
#include "sim/body/thickness.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"

namespace limberg {

struct Scene {
  enum class Source { block, obj };

  std::string name, note;
  std::string path;     // of the scene file, as given
  std::string text;     // the whole file; it goes into recordings
  uint64_t hash = 0;    // of the text and, for obj, of the mesh file's bytes, and of the tissues where one is named
  std::string tissues;  // text of the library that layers name tissues of; empty when none does
  std::shared_ptr<const LawCatalogue> laws;  // what layers may name

  bool flesh = true;  // there is a [body]: skin with flap tools
  std::optional<HeadScene> head;
  Source source = Source::block;
  BlockSpec block;                       // when source is block
  ObjSpec obj;                           // when source is obj; obj.path is resolved against the scene file's folder
  std::vector<ThicknessSpec> thickness;  // of each layer, where it is not as thick everywhere
  std::vector<int> layer_line;           // of the file
  std::vector<ColliderSpec> colliders;   // what the tissue lies against
  std::vector<RegionSpec> regions;       // tissue of its own
  std::vector<int> region_line;          // where in the file each stands
  TensionSpec tension;                   // of an obj's skin, where its lines of tension run differently by place
  std::string texture;  // of an obj's skin, a PNG or JPEG file; empty: what the OBJ's material names, if that is there

  double cell_mm = 3.5;
  bool refine_fronts = false, refine_pockets = true;
  double region_mm = 0;
  std::vector<FineZone> fine;  // smaller cells, as parts of cell_mm
  std::vector<int> fine_line;  // where in the file each stands
  int wound_level = 0;
  bool can_cut = true, dynamic = false;
  ContactChoice contact = ContactChoice::automatic;
  double contact_friction = 0;
  double suture_N_per_mm = 20, suture_bite_mm = 2, hook_N_per_mm = 0.5, hook_tip_mm = 2;
  uint64_t seed = 1;
  Vec3 gravity_m_s2 = Vec3::Zero();  // WorldSpec
  std::vector<SkinLoad> loads;
  std::vector<int> load_line;  // where in the file each stands
  int load_level = 1;          // halvings of the cells around each

  int iterations_per_step = 10;
  bool focus = true;  // in a session: StepSettings::focus
  double steps_per_s = 60;
  double damping_per_s = 0;
  Integrator integrator = Integrator::backward_euler;

  struct Tools {
    double max_depth_mm = 9;  // deeper cuts are refused
    double default_depth_mm = 4, default_spacing_mm = 4;
    double reach_mm = 3;                  // a tip nearer to the skin than this touches it
    std::optional<bool> progressive_cut;  // incisions open while they are drawn; unset: as the command does it
  } tools;

  std::vector<Landmark> landmarks;  // whose displacement is measured

  struct Camera {
    Vec3 target_mm = Vec3::Zero();
    Vec3 from{0, -0.6, 0.8};  // direction from the target to the eye
    Vec3 up{0, 0, 1};         // what is up in the picture; not along `from`
    double distance_mm = 300;
    double fov_deg = 26;  // vertical
    Vec3 eye_mm() const;
  } camera;

  const std::vector<Layer>& layers() const { return source == Source::block ? block.layers : obj.layers; }
};

/// The surfaces that a scene names, thicknesses and lines of tension, in order: what goes into its hash and its
/// recordings.
struct NamedFile {
  std::string path;
  const char* what;   // in messages
  bool given = true;  // by the scene itself; else by a file that it names, and it may be left out
};
std::vector<NamedFile> files_of(const Scene& scene);
/// Files on which only depends what is seen, or compared with: pictures, the surface of a face's colours, a normal
/// skull. They go into its recordings and not into its hash. InputError: a surface cannot be read.
std::vector<NamedFile> looks_of(const Scene& scene);
/// The picture on the skin of its body; empty: there is none.
std::string picture_on(const Scene& scene);
/// Throws InputError (missing file, folder, unreadable, empty, or as parse_scene).
Scene load_scene(const std::string& path);
/// `path` names the scene in messages; mesh files are looked for beside it. Reads the mesh file's bytes for the hash.
/// `laws`: what layers may name; null: the shipped ones.
Scene parse_scene(const std::string& text, const std::string& path, std::shared_ptr<const LawCatalogue> laws = nullptr);

/// Whether a scene of that text, with the files that lie beside it, is this one but for comments and layout.
bool differs_in_words_only(const Scene& scene, const std::string& text, uint64_t hash);

/// A scene's file by what a user typed: an existing path as it is, otherwise NAME.toml in the first of `folders` that
/// has it. Throws InputError that lists the names to be had.
std::string find_scene(const std::string& name_or_path, const std::vector<std::string>& folders);

/// Generates or loads and validates the body; of scenes with one. Throws InputError.
std::shared_ptr<const Body> build_body(const Scene& scene, SurfaceReport* report = nullptr);

WorldSpec world_spec(const Scene& scene, std::shared_ptr<const Body> body);

}  // namespace limberg
