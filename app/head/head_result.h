#pragma once
// `head` in result.json: fragments and what they are to each other, landmarks, lengths before and after, tissue.
#include "app/result/schema.h"

namespace limberg {

/// head/fragments: where its middle went, in the frame of the scan, and by how much it is turned.
struct ResultFragment {
  int64_t id;
  MaybeText name;
  bool fixed;
  double volume_mm3;
  ResultVector translation_mm;
  double rotation_deg;
};
void fields(ResultFragment& x, auto&& f) {
  f("id", x.id), f("name", x.name), f("fixed", x.fixed), f("volume_mm3", x.volume_mm3);
  f("translation_mm", x.translation_mm), f("rotation_deg", x.rotation_deg);
}

/// head/gaps: between two fragments by their numbers.
struct ResultGap {
  int64_t a, b;
  double gap_mean_mm, gap_max_mm, overlap_max_mm, overlap_mm3;
};
void fields(ResultGap& x, auto&& f) {
  f("a", x.a), f("b", x.b), f("gap_mean_mm", x.gap_mean_mm), f("gap_max_mm", x.gap_max_mm);
  f("overlap_max_mm", x.overlap_max_mm), f("overlap_mm3", x.overlap_mm3);
}

/// head/fits: two fragments whose cut rings fit. line: of a script, that puts them together.
struct ResultFit {
  int64_t stays, moves;
  double length_mm, residual_mm;
  MaybeText line;
};
void fields(ResultFit& x, auto&& f) {
  f("stays", x.stays), f("moves", x.moves), f("length_mm", x.length_mm), f("residual_mm", x.residual_mm);
  f("line", x.line);
}

/// head/landmarks
struct ResultHeadLandmark {
  MaybeText name;
  ResultVector moved_mm;
};
void fields(ResultHeadLandmark& x, auto&& f) { f("name", x.name), f("moved_mm", x.moved_mm); }

/// head/cephalometry, head/asymmetry, head/picked
struct ResultMeasure {
  MaybeText name, unit;
  double before, after;
};
void fields(ResultMeasure& x, auto&& f) {
  f("name", x.name), f("unit", x.unit), f("before", x.before), f("after", x.after);
}

/// head/tissues. free_motions: of springs.
struct ResultTissue {
  MaybeText name;
  int64_t layers;
  double young_kPa;
  MaybeText mode, free_motions;
};
void fields(ResultTissue& x, auto&& f) {
  f("name", x.name), f("layers", x.layers), f("young_kPa", x.young_kPa), f("mode", x.mode);
  f("free_motions", x.free_motions);
}

/// head/soft_to_hard: soft_mm is the skin's move along the bone's. known_low, known_high: in patients, by source.
struct ResultSoftRatio {
  MaybeText soft, bone;
  double bone_mm, soft_mm, ratio;
  Maybe known_low, known_high;
  MaybeText source;
};
void fields(ResultSoftRatio& x, auto&& f) {
  f("soft", x.soft), f("bone", x.bone), f("bone_mm", x.bone_mm), f("soft_mm", x.soft_mm), f("ratio", x.ratio);
  f("known_low", x.known_low), f("known_high", x.known_high), f("source", x.source);
}

/// head/bone_outside: of the place where bone stands out of the skin farthest; depth_mm 0: nowhere.
struct ResultBoneOutside {
  double depth_mm, area_mm2;
  ResultVector at_mm;
  int64_t fragment;
};
void fields(ResultBoneOutside& x, auto&& f) {
  f("depth_mm", x.depth_mm), f("area_mm2", x.area_mm2), f("at_mm", x.at_mm), f("fragment", x.fragment);
}

struct ResultHead {
  MaybeList<ResultFragment> fragments;
  std::vector<ResultGap> gaps;
  MaybeList<ResultFit> fits;
  MaybeList<ResultHeadLandmark> landmarks;
  MaybeList<ResultMeasure> cephalometry, asymmetry, picked;
  MaybeList<ResultSoftRatio> soft_to_hard;
  MaybeList<ResultBoneOutside> bone_outside;  // one, where there is a face
  Maybe face_moved_max_mm, face_moved_mean_mm, face_stretch_p99;
  MaybeList<ResultTissue> tissues;
  MaybeList<std::string> warnings;
};
void fields(ResultHead& x, auto&& f) {
  f("fragments", x.fragments), f("gaps", x.gaps), f("fits", x.fits), f("landmarks", x.landmarks);
  f("cephalometry", x.cephalometry), f("asymmetry", x.asymmetry), f("picked", x.picked);
  f("soft_to_hard", x.soft_to_hard), f("bone_outside", x.bone_outside);
  f("face_moved_max_mm", x.face_moved_max_mm), f("face_moved_mean_mm", x.face_moved_mean_mm),
      f("face_stretch_p99", x.face_stretch_p99);
  f("tissues", x.tissues), f("warnings", x.warnings);
}

/// metrics: of bones.
struct ResultBones {
  Maybe face_moved_max_mm;
  MaybeCount fragments;
  Maybe fragment_moved_max_mm;
};
void fields(ResultBones& x, auto&& f) {
  f("face_moved_max_mm", x.face_moved_max_mm), f("fragments", x.fragments);
  f("fragment_moved_max_mm", x.fragment_moved_max_mm);
}

}  // namespace limberg
