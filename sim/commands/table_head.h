#pragma once
// The rows of the acts on skull and face. Part of table.h, which says what a row is.
//
// Places are in mm in the frame of the head (x right, y forward, z up, origin between the ears), on the bones where
// they were at first. A fragment is given by its number or by a place [x, y, z] on it.
#include "sim/commands/table.h"

namespace limberg {

namespace row {

/// A turn about a place by the angle |rotation_deg| about its direction, then a shift.
void moved(auto& v, auto& m) {
  v(Field::optional("translation_mm", "the shift", Stands::written), m.translation_mm);
  v(Field::optional("rotation_deg", "the turn: its angle is the vector's length, at most 360"), m.rotation_deg);
  v(Field::optional("about", "the place that it turns about; left out: the fragment's centre"), m.about_mm);
}
inline std::string turns_too_far(const RigidMove& m) {
  return m.rotation_deg.norm() > 360 ? "\"rotation_deg\" turns by more than 360 degrees; expected less" : "";
}
inline constexpr Field kHand =
    Field::number("hand", 0, kHands - 1, "for hands that hold a fragment each", Stands::if_other);
inline constexpr const char* kGrounds[] = {"bone", "face"};

}  // namespace row

template <>
struct Act<CutBone> {
  static constexpr const char* name = "osteotomy";
  static constexpr const char* noun = "osteotomy";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "A cut through all of the bone, along a closed line through places on its surface, or by a plane.";
  static constexpr const char* example = R"({"action":"osteotomy","point":[0,80,-70],"normal":[0,0,1],"radius_mm":30})";
  static void fields(auto& v, auto& c) {
    if (v.form("contour", !c.contour_mm.empty(), " by a contour", " by a plane")) {
      v(Field::path("contour", 3, "the closed line: dense as a cursor draws it, or picked places"), c.contour_mm);
    } else {
      v(Field::given("point", "a place on the plane"), c.point_mm);
      v(Field::given("normal", "the plane's direction"), c.normal);
      v(Field::number("radius_mm", 0, ScriptLimits::coordinate_mm,
                      "only what the plane cuts within that distance of the point; 0: all", Stands::if_other)
            .usually(0, 120),
        c.radius_mm);
      v(Field::optional("of", "only this fragment"), c.of);
    }
    v(Field::flag("must_divide", true, "false: a cut that frees nothing is allowed"), c.must_divide);
  }
  static std::string check(const CutBone& c) {
    return c.contour_mm.empty() && c.normal.norm() < 1e-6 ? "\"normal\" has no length; expected a direction" : "";
  }
  static std::string words(const CutBone& c) {
    return c.contour_mm.empty() ? "osteotomy by a plane"
                                : fmt::format("osteotomy by a contour of {} places", c.contour_mm.size());
  }
  static Deed deed(const CutBone& c) {
    return {c.contour_mm.empty() ? "Osteotomy by a plane" : "Osteotomy along a closed line"};
  }
};

template <>
struct Act<CutBoneByBlade> {
  static constexpr const char* name = "osteotomy";
  static constexpr const char* noun = "osteotomy";
  static constexpr const char* mark = "rays";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "A cut by planes that meet in a corner, each between a direction from there and the next. Two are a plane that "
      "ends, three a step, four a sagittal split. None may end within bone.";
  static constexpr const char* example =
      R"({"action":"osteotomy","corner":[-60,45,-38],"rays":[[0,1,0],[1,0,0],[0,0,-1]],"reach_mm":150})";
  static void fields(auto& v, auto& c) {
    v(Field::given("corner", "where the planes meet"), c.corner_mm);
    v(Field::path("rays", 2,
                  "directions from the corner, 5 to 150 degrees from each to the next, two to eight of them"),
      c.rays);
    v(Field::number_above("reach_mm", 0, 500, "how far each plane goes along its directions").usually(20, 300),
      c.reach_mm);
    v(Field::optional("of", "only this fragment; left out: the one nearest to the corner"), c.of);
    v(Field::flag("must_divide", true, "false: a cut that frees nothing is allowed"), c.must_divide);
  }
  static std::string check(const CutBoneByBlade& c) {
    return c.rays.size() > kMostBladeRays
               ? fmt::format("\"rays\" holds {} directions; expected two to {}", c.rays.size(), kMostBladeRays)
               : "";
  }
  static std::string words(const CutBoneByBlade& c) {
    return fmt::format("osteotomy by {} planes that meet in a corner", std::max<size_t>(c.rays.size(), 1) - 1);
  }
  static Deed deed(const CutBoneByBlade& c) {
    return {c.rays.size() == 2 ? "Osteotomy by a plane that ends"
            : c.rays.size() == 3
                ? "Stepped osteotomy"
                : fmt::format("Osteotomy by {} planes that meet in a corner", std::max<size_t>(c.rays.size(), 1) - 1)};
  }
};

template <>
struct Act<MoveFragment> {
  static constexpr const char* name = "move_fragment";
  static constexpr const char* noun = "fragments moved";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "A fragment is moved by so much from where it is: turned, as things lie now, then shifted.";
  static constexpr const char* example =
      R"({"action":"move_fragment","fragment":1,"translation_mm":[0,8,0],"rotation_deg":[3,0,0],"seconds":2})";
  static void fields(auto& v, auto& c) {
    v(Field::given("fragment", "which"), c.fragment);
    row::moved(v, c.by);
    v(row::kSeconds, c.seconds);
  }
  static std::string check(const MoveFragment& c) { return row::turns_too_far(c.by); }
  static std::string words(const MoveFragment& c) {
    const double mm = c.by.translation_mm.norm(), deg = c.by.rotation_deg.norm();
    return deg > 0 ? fmt::format("fragment moved by {:.1f} mm, turned by {:.1f} degrees", mm, deg)
                   : fmt::format("fragment moved by {:.1f} mm", mm);
  }
  static Deed deed(const MoveFragment&) { return {"", "One fragment moved", " fragments moved"}; }
};

template <>
struct Act<GrabFragment> {
  static constexpr const char* name = "grab";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "A hand holds a fragment from now on; what is in its way stops it.";
  static constexpr const char* example = R"({"action":"grab","fragment":1})";
  static void fields(auto& v, auto& c) {
    v(Field::given("fragment", "which"), c.fragment);
    v(row::kHand, c.hand);
  }
  static std::string words(const GrabFragment&) { return "fragment grabbed"; }
};

template <>
struct Act<DragFragment> {
  static constexpr const char* name = "drag";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "Where the hand takes the fragment, from where it was grabbed.";
  static constexpr const char* example = R"({"action":"drag","translation_mm":[0,8,0],"seconds":2})";
  static void fields(auto& v, auto& c) {
    row::moved(v, c.to);
    v(row::kSeconds, c.seconds);
    v(row::kHand, c.hand);
  }
  static std::string check(const DragFragment& c) { return row::turns_too_far(c.to); }
  static std::string words(const DragFragment& c) {
    return fmt::format("fragment taken by {:.1f} mm in {:.1f} s", c.to.translation_mm.norm(), c.seconds);
  }
};

template <>
struct Act<LetGo> {
  static constexpr const char* name = "let_go";
  static constexpr const char* noun = "fragments moved";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "The hand opens.";
  static constexpr const char* example = R"({"action":"let_go","snap":true})";
  static void fields(auto& v, auto& c) {
    v(Field::flag("snap", false, "the fragment goes into the nearest of its cuts"), c.snap);
    v(row::kHand, c.hand);
  }
  static std::string words(const LetGo& c) { return c.snap ? "fragment let go, into its cut" : "fragment let go"; }
  static Deed deed(const LetGo&) { return {"", "One fragment moved", " fragments moved"}; }
};

template <>
struct Act<PlateFragments> {
  static constexpr const char* name = "plate";
  static constexpr const char* noun = "plates";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "A plate from bone to bone: its two fragments move together.";
  static constexpr const char* example = R"({"action":"plate","a":[10,80,-60],"b":[10,80,-66]})";
  static void fields(auto& v, auto& c) {
    v(Field::given("a", "a place on one fragment"), c.a_mm);
    v(Field::given("b", "a place on the other"), c.b_mm);
  }
  static std::string words(const PlateFragments&) { return "plate across two fragments"; }
  static Deed deed(const PlateFragments&) { return {"", "One plate", " plates"}; }
};

template <>
struct Act<JoinFragments> {
  static constexpr const char* name = "join";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "Two fragments become one.";
  static constexpr const char* example = R"({"action":"join","a":0,"b":1})";
  static void fields(auto& v, auto& c) {
    v(Field::given("a", "one of them"), c.a);
    v(Field::given("b", "the other"), c.b);
    v(Field::number("smooth_mm", 0, 60,
                    "the seam is smoothed so far to both sides, the volume kept; 0: it stays as it is",
                    Stands::if_other)
          .usually(0, 20),
      c.smooth_mm);
  }
  static std::string words(const JoinFragments&) { return "two fragments joined"; }
  static Deed deed(const JoinFragments&) { return {"", "Two fragments joined", " pairs of fragments joined"}; }
};

template <>
struct Act<SplitFace> {
  static constexpr const char* name = "split_face";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "The bone's mesh is made finer: the face at a place becomes two, by a new edge across its longest direction "
      "(T2).";
  static constexpr const char* example = R"({"action":"split_face","at":[0,84,60]})";
  static void fields(auto& v, auto& c) { v(Field::given("at", "a place on the bone's surface"), c.at_mm); }
  static std::string words(const SplitFace&) { return "a face of the bone's mesh split"; }
};

template <>
struct Act<MergeFaces> {
  static constexpr const char* name = "merge_faces";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "The bone's mesh is made coarser: the edge nearest to a place is deleted, the faces on its sides become one "
      "(T1).";
  static constexpr const char* example = R"({"action":"merge_faces","at":[0,84,60]})";
  static void fields(auto& v, auto& c) { v(Field::given("at", "a place on the bone's surface"), c.at_mm); }
  static std::string words(const MergeFaces&) { return "two faces of the bone's mesh merged"; }
};

template <>
struct Act<SmoothSurface> {
  static constexpr const char* name = "smooth_surface";
  static constexpr const char* noun = "bone smoothed";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "The surface of the bone about a place is smoothed by its curvature; the bone keeps its volume.";
  static constexpr const char* example = R"({"action":"smooth_surface","at":[0,84,60],"radius_mm":15})";
  static void fields(auto& v, auto& c) {
    v(Field::given("at", "the middle of the region, on the bone's surface"), c.at_mm);
    v(Field::number_above("radius_mm", 0, 100, "how far it reaches, along the surface").usually(2, 40), c.radius_mm);
  }
  static std::string words(const SmoothSurface& c) {
    return fmt::format("the bone's surface smoothed within {:g} mm", c.radius_mm);
  }
  static Deed deed(const SmoothSurface&) { return {"", "One region of bone smoothed", " regions of bone smoothed"}; }
};

template <>
struct Act<PushSurface> {
  static constexpr const char* name = "push_surface";
  static constexpr const char* noun = "bone pushed";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "A ball goes from one place to another and pushes the bone's surface out of its way; the surface stays so.";
  static constexpr const char* example = R"({"action":"push_surface","from":[0,96,60],"to":[0,88,60],"radius_mm":8})";
  static void fields(auto& v, auto& c) {
    v(Field::given("from", "where the ball's middle begins"), c.from_mm);
    v(Field::given("to", "where it ends"), c.to_mm);
    v(Field::number_above("radius_mm", 0, 60, "of the ball").usually(2, 25), c.radius_mm);
    v(Field::optional("of", "the fragment that feels it; left out: the one nearest to where the ball ends"), c.of);
  }
  static std::string words(const PushSurface& c) {
    return fmt::format("the bone's surface pushed over {:.1f} mm", (c.to_mm - c.from_mm).norm());
  }
  static Deed deed(const PushSurface&) {
    return {"", "One push at the bone's surface", " pushes at the bone's surface"};
  }
};

template <>
struct Act<ConnectTissue> {
  static constexpr const char* name = "connect_tissue";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "Tissue between a region of the face and one of the bone.";
  static constexpr const char* example =
      R"({"action":"connect_tissue","name":"chin","face":[0,90,-80],"face_radius_mm":25,"bone":[0,80,-80],"bone_radius_mm":40,"layers":3,"young_kPa":10,"mode":"finite_elements"})";
  static void fields(auto& v, auto& c) {
    v(Field::text("name", 60, "what the tissue is called"), c.name);
    if (v.form("face_outline", !c.face_outline_mm.empty(), " in an outline", " round a place")) {
      v(Field::path("face_outline", 3, "a closed line on the face round its region: picked places, or dense"),
        c.face_outline_mm);
      if constexpr (!std::is_const_v<std::remove_reference_t<decltype(c)>>) c.face_mm = middle_of(c.face_outline_mm);
    } else {
      v(Field::given("face", "the middle of the region of the face"), c.face_mm);
      v(Field::number_above("face_radius_mm", 0, 500, "how far the region of the face reaches").usually(8, 80),
        c.face_radius_mm);
    }
    v.same_unless_given(c.bone_mm, c.face_mm);
    v(Field::optional("bone", "the middle of the region of the bone; left out: that of the face", Stands::written),
      c.bone_mm);
    v(Field::number("bone_radius_mm", 0, 500, "how far the region of the bone reaches; 0: all bone").usually(0, 120),
      c.bone_radius_mm);
    v(Field::number("layers", 1, 16, "of cells between face and bone").usually(1, 6), c.layers);
    v(Field::number_above("young_kPa", 0, 1e6, "Young's modulus").usually(1, 60), c.young_kPa);
    v(Field::choice("mode", kTissueKinds, kTissueKindWords, "how it hands on motion", Stands::written), c.mode);
  }
  static std::string words(const ConnectTissue& c) { return "tissue: " + c.name; }
  static Deed deed(const ConnectTissue&) { return {"Tissue between face and bone"}; }
};

template <>
struct Act<PlaceLandmark> {
  static constexpr const char* name = "landmark";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "A named place, set on the nearest bone or face; a name that is there is moved.";
  static constexpr const char* example = R"({"action":"landmark","name":"Pog","at":[0,95,-80],"on":"bone"})";
  enum class Ground : uint8_t { bone, face };
  static void fields(auto& v, auto& c) {
    v(Field::text("name", 40, "what it is called"), c.name);
    v(Field::given("at", "where"), c.at_mm);
    Ground on = c.on_face ? Ground::face : Ground::bone;
    v(Field::choice("on", row::kGrounds, row::kGrounds, "what it is set on", Stands::if_other), on);
    if constexpr (!std::is_const_v<std::remove_reference_t<decltype(c)>>) c.on_face = on == Ground::face;
  }
  static std::string words(const PlaceLandmark& c) { return "landmark " + c.name; }
};

template <>
struct Act<Superpose> {
  static constexpr const char* name = "superpose";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "The skull is laid upon a normal one or upon its mirror image and shown so from now on; how far it is from it "
      "now "
      "stands in the report. No part of undo.";
  static constexpr const char* example = R"({"action":"superpose","on":"normal","name":"advanced"})";
  static void fields(auto& v, auto& c) {
    v(Field::choice("on", kSkullBeside, kSkullBesideWords, "what it is laid upon; off: it is shown alone again"), c.on);
    v(Field::text("name", 40, "what this moment is called in the report", Stands::if_other), c.name);
  }
  static std::string words(const Superpose& c) { return kSkullBesideWords[size_t(c.on)]; }
};

template <>
struct Act<Unplate> {
  static constexpr const char* name = "unplate";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help = "The plates on a fragment are taken off.";
  static constexpr const char* example = R"({"action":"unplate","fragment":1})";
  static void fields(auto& v, auto& c) { v(Field::given("fragment", "which"), c.fragment); }
  static std::string words(const Unplate&) { return "plates taken off"; }
  static Deed deed(const Unplate&) {
    return {"", "The plates on one fragment taken off", " times the plates on a fragment taken off"};
  }
};

template <>
struct Act<SortFragments> {
  static constexpr const char* name = "sort";
  static constexpr Needs needs = Needs::head;
  static constexpr const char* help =
      "Fragments are put together by their cut rings, wherever they lie: what fits and is verified goes to a bone that "
      "does not move, or to the one with the smallest number.";
  static constexpr const char* example = R"({"action":"sort"})";
  static void fields(auto&, auto&) {}
  static std::string words(const SortFragments&) { return "fragments sorted by their cut rings"; }
  static Deed deed(const SortFragments&) {
    return {"", "Fragments put together by their cut rings", " times fragments put together by their cut rings"};
  }
};

}  // namespace limberg
