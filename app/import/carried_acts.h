#pragma once
// A peer's recorded operation as a script of ours, with an account of every act: carried as it is, changed, refused
// and why.
//
// Cuts are drawn once more on the unoperated model (cut_lines.h), and later acts are understood against them: an
// incision joined to the nearest cut by its T-in begins there; an undermining, whose points the peer joins to cuts, is
// closed along them; an excision by a place takes what the cuts enclose, or the piece that cuts through the body have
// freed; a stitch on a bank stays on the bank that it was recorded from.
#include <cstdint>
#include <string>
#include <vector>

#include "app/import/peer_model.h"

namespace limberg {

struct CarriedAct {
  enum class Fate : uint8_t {
    carried,
    changed,
    refused,
    passed  // nothing of the patient's
  };
  Fate fate = Fate::carried;
  int line = 0;  // of the history
  std::string name, words;
  std::vector<std::string> notes;  // what was changed, or why it was refused
  int places = 0;
  double moved_mm = 0;      // most, from where the file puts a place to the surface or the cut that it was laid on
  int first = 0, last = 0;  // its lines in the script; 0: none
};
const char* words_of(CarriedAct::Fate fate);

struct CarriedOperation {
  std::vector<CarriedAct> act;
  std::vector<std::string> script;  // without its first line
  std::vector<SurfaceSpot> worked;  // where on the surface
  double reach_mm = 0;              // the farthest that a hook is taken to from the middle of these
  Vec3 middle_mm = Vec3::Zero(), outwards = Vec3::UnitZ();
  int count(CarriedAct::Fate fate) const;
};

struct CarrySettings {
  double spacing_mm = 3;   // of rows
  double beside_mm = 0.3;  // a stitch's place is laid so far beside its cut
};

CarriedOperation carry(const PeerHistory& history, const PeerModel& model, const CarrySettings& settings);

}  // namespace limberg
