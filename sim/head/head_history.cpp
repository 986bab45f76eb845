// Undo and redo of a head: acts on bone are taken back by Bones, what they changed beside the bones comes from copies.
#include "sim/head/head.h"

namespace limberg {

namespace {
constexpr const char* kHeld = "a fragment is held; it has to be released first";
}

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

Outcome Head::undo() {
  if (bones_.held() >= 0) return {false, kHeld};
  if (done_.empty()) return {false, "there is nothing to undo"};
  Done d = std::move(done_.back());
  done_.pop_back();
  if (d.bones)
    if (Outcome o = bones_.undo(); !o.done) return done_.push_back(std::move(d)), o;
  swap_with(d);
  undone_.push_back(std::move(d));
  return {true, {}};
}

Outcome Head::redo() {
  if (bones_.held() >= 0) return {false, kHeld};
  if (undone_.empty()) return {false, "there is nothing to do again"};
  Done d = std::move(undone_.back());
  undone_.pop_back();
  if (d.bones)
    if (Outcome o = bones_.redo(); !o.done) return undone_.push_back(std::move(d)), o;
  swap_with(d);
  done_.push_back(std::move(d));
  return {true, {}};
}

}  // namespace limberg
