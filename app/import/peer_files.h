#pragma once
// The files of a peer, SkinFlaps (Wang, Cutting, Sifakis): a scene (.smd), a recorded operation (.hst), deep points of
// a skin (.bed). Read as they are, in the peer's own units; what they mean for a patient of ours is found in
// peer_model.h and carried_acts.h.
//
// Readers throw InputError with the line where the text is broken. An act that is whole as JSON, but not as an act, is
// kept with what is wrong about it: the rest of the operation can still be carried.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct PeerScene {
  std::string file;
  std::string object;   // OBJ of the tissue, as it is named
  std::string texture;  // picture of its skin, as it is named; empty: not said
  int object_line = 0;
  std::vector<std::string> scenery, volumes, colliders;  // OBJs: drawn only; tissue of another kind; kept out of
  std::vector<std::string> collider_texture;             // picture of each, as it is named; empty: not said
  std::vector<double> volume_stiffness;                  // of each, in that of the other tissue; 0: not said
  int subdivisions = 0, levels = 0;                      // of the peer's lattice; 0: not said
  double stitch_spacing = 0;                             // of rows, in the file's units; 0: not said
  double strain_least = 0, strain_most = 0;              // 0: not said
  std::vector<std::string> mended;
};
PeerScene parse_peer_scene(std::string_view text, const std::string& file);

/// A place as the peer keeps it: on a texture, then so far over the surface, in units of its lattice.
struct PeerPlace {
  int line = 0;
  int material = 0;
  Vec2 uv = Vec2::Zero();
  Vec3 displacement = Vec3::Zero();
};

struct PeerAct {
  enum class Kind : uint8_t {
    load_scene,
    incision,
    deep_cut,
    undermine,
    undermine_periosteum,
    excise,
    add_hook,
    move_hook,
    delete_hook,
    add_suture,
    delete_suture,
    nothing,  // what changes no patient: a pause of the clock, say
    unknown
  };
  Kind kind = Kind::unknown;
  int line = 0;
  std::string name;   // the peer's
  std::string wrong;  // why it cannot be read; the rest of the act may then be missing
  std::string scene;  // load_scene

  struct Post {
    PeerPlace place;
    Vec3 normal = Vec3::Zero();  // deep_cut: outwards
    bool connect = false;        // undermining: joined to the nearest cut
  };
  std::vector<Post> post;        // of cuts and undermining; one of hooks and excisions, two of a stitch
  bool in = false, out = false;  // T-ins of an incision, open ends of a deep cut
  int number = 0;                // of a hook or a stitch
  bool linked = false, strong = false;
  Vec3 to = Vec3::Zero();  // move_hook, in the file's units
};
const char* words_of(PeerAct::Kind kind);

struct PeerHistory {
  std::string file;
  std::vector<PeerAct> act;
  std::vector<std::string> mended;
};
PeerHistory parse_peer_history(std::string_view text, const std::string& file);

/// Deep points of vertices: index and place, in the file's units, in the order of the file.
struct PeerBed {
  std::vector<int32_t> vertex;
  std::vector<Vec3> deep;
};
PeerBed parse_peer_bed(std::string_view text, const std::string& file);

struct PeerLimits {
  static constexpr size_t acts = 5000, posts = 2000;  // of an operation; of one act
  static constexpr double coordinate = 1e4;           // in the file's units
  static constexpr int32_t vertices = 2'000'000;
};

}  // namespace limberg
