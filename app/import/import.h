#pragma once
// From a peer's scene (.smd) or recorded operation (.hst) to a scene and a script of ours, with an account of every
// act:
//
//   NAME.toml, NAME.obj   the patient in mm; `limberg check` takes it, `limberg operate` runs it
//   NAME.jpg or .png      the picture of its skin, as the peer has it
//   NAME-collider-1.obj   what tissue is kept out of, the teeth say, in mm; and so on
//   NAME.jsonl            the operation
//   NAME.html, NAME.json  what was carried, changed, refused, and how far places moved
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/import/carried_acts.h"
#include "app/import/peer_files.h"
#include "app/import/peer_model.h"
#include "app/words/words.h"
#include "sim/body/collider.h"

namespace limberg {

struct ImportSettings {
  std::string input;                // .hst or .smd
  std::vector<std::string> models;  // folders where models are looked for, after the input's own
  std::string out;                  // a folder
  double unit_mm = 0;               // of the models' numbers; 0: guessed by their size
  double cell_mm = 0;               // of the scene's lattice; 0: chosen
  double spacing_mm = 3;            // of rows of stitches
};

struct Imported {
  std::string name, history_file, scene_file, model_file, bed_file;  // as found; empty: none
  std::string texture_file, texture, texture_why;                    // the skin's picture, as found; its bytes; why not
  PeerScene scene;
  PeerModel model;
  std::vector<std::shared_ptr<const Collider>> colliders;  // in mm
  struct Volume {
    std::string file;                       // as it is named
    std::shared_ptr<const Collider> solid;  // in mm
    double stiffness = 1;                   // in that of the other tissue
  };
  std::vector<Volume> volumes;  // tissue of another kind
  CarriedOperation operation;
  std::vector<std::string> colliders_left_out, volumes_left_out;
  std::vector<std::string> mended, missing;  // let pass in the files; of the peer's scene what ours has not
  double unit_mm = 0, cell_mm = 0, region_mm = 0, skin_mm = 0, spacing_mm = 0, bite_mm = 0;
  bool unit_guessed = false;
  int64_t triangles = 0, held = 0;
};

/// Reads everything and converts. Throws InputError; writes nothing.
Imported import_peer(const ImportSettings& settings);

/// The files of it, as text.
std::string scene_toml(const Imported& x);
std::string surface_obj(const Imported& x);
/// How thick the skin is by place, and the name of that file; no name: there are no deep points.
std::string thickness_text(const Imported& x);
std::string thickness_name(const Imported& x);
std::string collider_obj(const Collider& c);
/// "NAME.jpg"; empty: there is no picture.
std::string picture_name(const Imported& x);
std::string collider_name(const Imported& x, size_t i);
std::string volume_name(const Imported& x, size_t i);
/// Of every collider and volume the name of its file and its surface.
std::vector<std::pair<std::string, std::shared_ptr<const Collider>>> solid_files(const Imported& x);
std::string script_text(const Imported& x);
std::string import_page(const Imported& x, const Words& w = {});
std::string import_json(const Imported& x);

}  // namespace limberg
