// Undo and redo of a head: acts on bone are taken back by Bones, what they changed beside the bones comes from copies.
#include "sim/skull/bone/words.h"
#include "sim/skull/head/head.h"

namespace limberg {

Head::Done Head::moment(bool bones, bool with_face) const {
  Done d;
  d.bones = bones;
  d.landmarks = landmarks_, d.tissues = tissues_;
  if (with_face && has_face_) d.face = std::make_unique<simplex::FaceModel>(face_);
  return d;
}

void Head::remember(Done before) {
  done_.push_back(std::move(before));
  undone_.clear();
}

/// What is kept in `other` and what is there change places; the bones have gone their way before.
void Head::swap_with(Done& other) {
  std::swap(landmarks_, other.landmarks);
  std::swap(tissues_, other.tissues);
  if (other.face) std::swap(face_, *other.face);
  placed_version_ = 0;
  place_bones();
  topology_changed();
}

/// The last act of `from` goes to `to`. A refusal of the bones leaves both as they are.
Outcome Head::go(std::vector<Done>& from, std::vector<Done>& to, const std::function<Outcome()>& bones) {
  if (from.back().bones)
    if (Outcome o = bones(); !o.done) return o;
  Done d = std::move(from.back());
  from.pop_back();
  swap_with(d);
  to.push_back(std::move(d));
  return {true, {}};
}

Outcome Head::undo() {
  if (bones_.held() >= 0) return {false, bone::kHeld};
  if (done_.empty()) return {false, "there is nothing to undo"};
  return go(done_, undone_, [this] { return bones_.undo(); });
}

Outcome Head::redo() {
  if (bones_.held() >= 0) return {false, bone::kHeld};
  if (undone_.empty()) return {false, "there is nothing to do again"};
  return go(undone_, done_, [this] { return bones_.redo(); });
}

}  // namespace limberg
