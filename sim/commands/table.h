#pragma once
// The table of all acts. Each command has one row, Act<C>: what it is called in a script, its fields, an example, what
// it needs of the patient, and how it is told in words. From the rows follow the reader and the writer of scripts
// (script.cpp), `limberg actions` (actions.h), the words of reports and of the window (words.h) and the ranges of the
// window's sliders. A new act is its struct (command.h), its row here and what the patient does with it.
//
//   template <>
//   struct Act<Wait> {
//     static constexpr const char* name = "wait";
//     static constexpr Needs needs = Needs::nothing;
//     static constexpr const char* help = "Lets time pass.";
//     static constexpr const char* example = R"({"action":"wait","seconds":1})";
//     static void fields(auto& v, auto& c) { v(Field::number("seconds", 0, 3600, "how long"), c.seconds); }
//   };
//
// fields() shows a visitor every field with its value, in the order of the line. A visitor has
//   v(field, value)                         of any type that a command holds
//   v.form(key, chosen, with, without)      of two kinds of line: is it that with `key`? `chosen`: as the command says
//   v.same_unless_given(value, other)       a field that may be left out and then has another field's value
// A row may also have
//   mark     the key that tells this row from another of the same name
//   check    what is wrong with the fields together, or an empty text
//   words    the act in a few words, for a list on a screen; otherwise its name
//   deed     what a report says of it under the picture of a stage; otherwise nothing
//   cuts_skin, sews     true: it may cut skin, it ties stitches
//   looks_back          true: what it does hangs on the order of the acts before it
//   leaves_patient      true: it changes nothing in the patient
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <type_traits>

#include "sim/commands/command.h"
#include "sim/commands/field.h"
#include "sim/geometry/blade_angle.h"
#include "sim/geometry/polyline.h"

namespace limberg {

/// What an act needs of the patient.
enum class Needs : uint8_t { nothing, skin, head };

/// What a report says of an act: a sentence of its own, or how many of its kind there were.
struct Deed {
  std::string sentence;        // without its full stop
  const char* one = nullptr;   // "One hook set"
  const char* many = nullptr;  // " hooks set", after their number; null: `one` is said once for all
};

template <class C>
struct Act;

// A row may also have a `noun`, of which titles are made: "excision".

// What rows share.
namespace row {

inline Field depth_of(const char* help) {
  return Field::number_above("depth_mm", 0, ScriptLimits::depth_mm, help).usually(0.5, 9);
}
inline constexpr Field kBite_mm =
    Field::number("depth_mm", 0, ScriptLimits::depth_mm,
                  "how deep the bites lie in the wound's walls; 0: through the edges of the skin", Stands::if_other);
inline constexpr Field kBlade_deg =
    Field::number(
        "angle_deg", kLeastBlade_deg, kMostBlade_deg,
        "between blade and skin, in the plane across the path, 90 is upright; a flatter blade does not come out "
        "where it should")
        .usually(30, 150);
inline constexpr Field kNumber = Field::number("id", 1, ScriptLimits::max_id, "the hook's number", Stands::always);
inline constexpr Field kSeconds = Field::number("seconds", 0, ScriptLimits::seconds, "how long it takes");
inline constexpr Field kSpacing_mm = Field::number_above("spacing_mm", 0, 1000, "between stitches").usually(1.5, 12);

inline constexpr const char* kSideHelp =
    "what it goes into: skin, a flap's underside, the bed that it was raised from, or the nearest cut face (these of "
    "places [x, y, z])";

/// Of a row's fields those that say how it is sewn.
void sewn(auto& v, auto& k) {
  v(kSpacing_mm, k.spacing_mm);
  v(kBite_mm, k.depth_mm);
  v(Field::flag("running", false, "one thread through all stitches, which may slide; single stitches otherwise"),
    k.running);
  v(Field::number("slack_mm", 0, 1000, "so much of a running thread is left over when it is tied", Stands::if_other),
    k.slack_mm);
}
std::string slack_is_of_a_running_suture(const auto& k) {
  return k.slack_mm > 0 && !k.running ? "\"slack_mm\" without \"running\":true; expected a running suture" : "";
}

}  // namespace row

double path_mm(const std::vector<ChartPoint>& path, bool closed = false);
double area_mm2(const std::vector<ChartPoint>& outline);
/// So many significant digits, without an exponent or needless zeros.
std::string rounded_text(double value, int digits);

template <>
struct Act<Incise> {
  static constexpr const char* name = "incise";
  static constexpr const char* noun = "incision";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help = "A cut along a path on the skin.";
  static constexpr const char* example = R"({"action":"incise","path":[[10,0],[30,0]],"depth_mm":4,"angle_deg":90})";
  static void fields(auto& v, auto& c) {
    v(Field::path("path", 2, "where the blade passes"), c.path);
    v(row::depth_of("of the cut, along the blade"), c.depth_mm);
    v(row::kBlade_deg, c.angle_deg);
    v(Field::flag("spline", false, "a curve through the points instead of straight pieces"), c.spline);
  }
  static std::string words(const Incise& c) {
    return fmt::format("incise {:.0f} mm, {:.3g} mm deep", path_mm(c.path), c.depth_mm);
  }
  static Deed deed(const Incise& c) {
    std::string s =
        "Incision of " + rounded_text(path_mm(c.path), 3) + " mm, " + rounded_text(c.depth_mm, 3) + " mm deep";
    if (std::abs(c.angle_deg - 90) > 0.5) s += ", blade at " + rounded_text(c.angle_deg, 3) + "°";
    return {s};
  }
};

template <>
struct Act<InciseMore> {
  static constexpr const char* name = "incise";
  static constexpr const char* mark = "stroke";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help =
      "A piece of a cut that opens while it is drawn: further pieces go on from its last point, the one without "
      "\"more\" "
      "ends it. Depth and angle are those of the first.";
  static constexpr const char* example =
      R"({"action":"incise","stroke":3,"path":[[10,0],[15,0]],"depth_mm":4,"more":true})";
  static void fields(auto& v, auto& c) {
    v(Field::number("stroke", 1, ScriptLimits::max_id, "the number of the stroke that it is a piece of",
                    Stands::always),
      c.stroke);
    v(Field::path("path", 1, "where the blade passes"), c.path);
    v(row::depth_of("of the cut, along the blade"), c.depth_mm);
    v(row::kBlade_deg, c.angle_deg);
    bool more = !c.last;
    v(Field::flag("more", false, "further pieces follow"), more);
    if constexpr (!std::is_const_v<std::remove_reference_t<decltype(c)>>) c.last = !more;
  }
  static std::string words(const InciseMore& c) {
    return fmt::format("incision {}, {:.3g} mm deep", c.stroke, c.depth_mm);
  }
};

template <>
struct Act<Undermine> {
  static constexpr const char* name = "undermine";
  static constexpr const char* noun = "undermining";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help = "A cut below the skin under an outline, at one depth or along what is held.";
  static constexpr const char* example =
      R"({"action":"undermine","outline":[[0,0],[20,0],[20,10],[0,10]],"depth_mm":4})";
  static void fields(auto& v, auto& c) {
    v(Field::path("outline", 3, "the pocket's rim on the skin"), c.outline);
    v(row::depth_of("of the pocket below the skin"), c.depth_mm);
    v(Field::number("above_held_mm", 0, 10,
                    "where what is held lies nearer below the skin, the pocket follows it so far above; 0: one depth",
                    Stands::if_other),
      c.above_held_mm);
  }
  static std::string words(const Undermine& c) {
    if (c.above_held_mm > 0)
      return fmt::format("undermine {:.0f} mm around, {:.2g} mm above what is held, at most at {:.3g} mm",
                         path_mm(c.outline, true), c.above_held_mm, c.depth_mm);
    return fmt::format("undermine {:.0f} mm around, at {:.3g} mm", path_mm(c.outline, true), c.depth_mm);
  }
  static Deed deed(const Undermine& c) {
    return {"Undermining of " + rounded_text(area_mm2(c.outline) / 100, 2) + " cm², " + rounded_text(c.depth_mm, 3) +
            " mm deep"};
  }
};

template <>
struct Act<Excise> {
  static constexpr const char* name = "excise";
  static constexpr const char* noun = "excision";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help = "A plug of tissue is cut round and below, and taken away.";
  static constexpr const char* example = R"({"action":"excise","outline":[[0,0],[20,0],[20,10],[0,10]],"depth_mm":4})";
  static void fields(auto& v, auto& c) {
    v(Field::path("outline", 3, "the plug's rim on the skin"), c.outline);
    v(row::depth_of("of the plug"), c.depth_mm);
    v(Field::flag(
          "floor", true,
          "the plug is cut below too; false: walls only, and what lies within must be free below, by undermining or by "
          "walls that reach through"),
      c.floor);
  }
  static std::string words(const Excise& c) {
    return fmt::format("excise {:.0f} mm around, {:.3g} mm deep", path_mm(c.outline, true), c.depth_mm);
  }
  static Deed deed(const Excise& c) {
    return {"Excision of " + rounded_text(area_mm2(c.outline), 3) + " mm², " + rounded_text(c.depth_mm, 3) +
            " mm deep"};
  }
};

template <>
struct Act<ExcisePiece> {
  static constexpr const char* name = "excise";
  static constexpr const char* noun = "excision";
  static constexpr const char* mark = "at";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help = "A piece that earlier cuts have freed all round is taken out by touching it.";
  static constexpr const char* example = R"({"action":"excise","at":[10,5]})";
  static void fields(auto& v, auto& c) { v(Field::given("at", "on the skin of the loose piece"), c.at); }
  static std::string words(const ExcisePiece&) { return "loose piece taken out"; }
  static Deed deed(const ExcisePiece&) { return {"", "A loose piece taken out", " loose pieces taken out"}; }
};

template <>
struct Act<CutThrough> {
  static constexpr const char* name = "cut_through";
  static constexpr const char* noun = "cut right through";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool cuts_skin = true;
  static constexpr const char* help =
      "A cut from one side of the body through to the other, as of a lip, a lid or an ear; the blade goes along the "
      "normals of the posts, evenly between them.";
  static constexpr const char* example =
      R"({"action":"cut_through","path":[[0,0,0],[0,8,0]],"normals":[[0,0,1],[0,0,1]],"open_end":true})";
  static void fields(auto& v, auto& c) {
    v(Field::path("path", 2, "posts on the skin"), c.path);
    v(Field::path("normals", 0, "which way the blade comes in at each post, out of the skin; none: the skin's own")
          .maybe(),
      c.normals);
    v(Field::flag("open_start", false, "it goes on over the free margin before the first post"), c.open_start);
    v(Field::flag("open_end", false, "it goes on over the free margin after the last post"), c.open_end);
    v(Field::flag(
          "from_bed", false,
          "it begins on the bed of a pocket, at places on it, and the flap above stays whole; else on the skin"),
      c.from_bed);
  }
  static std::string check(const CutThrough& c) {
    if (!c.normals.empty() && c.normals.size() != c.path.size())
      return fmt::format("\"normals\" has {} entries for {} posts; one for each was expected, or none",
                         c.normals.size(), c.path.size());
    for (const Vec3& n : c.normals)
      if (!(n.norm() > 1e-6)) return "\"normals\" holds a direction of no length; expected one out of the skin";
    return "";
  }
  static std::string words(const CutThrough& c) {
    return fmt::format("cut of {:.0f} mm {}right through", path_length(c.path), c.from_bed ? "from a bed " : "");
  }
  static Deed deed(const CutThrough& c) {
    return {"Cut of " + rounded_text(path_length(c.path), 3) + " mm right through"};
  }
};

template <>
struct Act<SetHook> {
  static constexpr const char* name = "hook";
  static constexpr Needs needs = Needs::skin;
  static constexpr const char* help = "A skin hook is set, to be moved.";
  static constexpr const char* example = R"({"action":"hook","id":1,"at":[14,-10]})";
  static void fields(auto& v, auto& c) {
    v(row::kNumber, c.id);
    v(Field::given("at", "where it holds the skin"), c.at);
    v(Field::choice("surface", kHeldSides, kHeldSides, row::kSideHelp, Stands::if_other), c.side);
  }
  static std::string words(const SetHook& c) { return fmt::format("hook {} set", c.id); }
  static Deed deed(const SetHook&) { return {"", "One hook set", " hooks set"}; }
};

template <>
struct Act<MoveHook> {
  static constexpr const char* name = "move";
  static constexpr Needs needs = Needs::skin;
  static constexpr const char* help = "The handle of a hook is moved.";
  static constexpr const char* example = R"({"action":"move","id":1,"to":[6,3,10],"seconds":1.5})";
  static void fields(auto& v, auto& c) {
    v(row::kNumber, c.id);
    v(Field::given("to", "in the world (of a block: z up, skin at 0)"), c.to_mm);
    v(row::kSeconds, c.seconds);
  }
  static std::string words(const MoveHook& c) { return fmt::format("hook {} carried and left there", c.id); }
  static Deed deed(const MoveHook&) { return {"", "The flap is moved with the hooks"}; }
};

template <>
struct Act<ReleaseHook> {
  static constexpr const char* name = "release";
  static constexpr Needs needs = Needs::skin;
  static constexpr const char* help = "A hook is taken out.";
  static constexpr const char* example = R"({"action":"release","id":1})";
  static void fields(auto& v, auto& c) { v(row::kNumber, c.id); }
  static std::string words(const ReleaseHook& c) { return fmt::format("hook {} released", c.id); }
  static Deed deed(const ReleaseHook&) { return {"", "The hooks are taken out"}; }
};

template <>
struct Act<Suture> {
  static constexpr const char* name = "suture";
  static constexpr const char* noun = "sutures";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool sews = true;
  static constexpr const char* help = "One stitch.";
  static constexpr const char* example = R"({"action":"suture","a":[0,-0.7],"b":[0,0.7]})";
  static void fields(auto& v, auto& c) {
    v(Field::given("a", "just beside one edge, in the tissue that is held"), c.a);
    v(Field::given("b", "just beside the other edge"), c.b);
    v(row::kBite_mm, c.depth_mm);
    v(Field::choice("surface_a", kHeldSides, kHeldSides, row::kSideHelp, Stands::if_other), c.side_a);
    v(Field::choice("surface_b", kHeldSides, kHeldSides, "the same at b", Stands::if_other), c.side_b);
  }
  static Deed deed(const Suture&) { return {"", "One key suture", " key sutures"}; }
};

template <>
struct Act<SutureRow> {
  static constexpr const char* name = "suture_row";
  static constexpr const char* noun = "sutures";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool sews = true;
  static constexpr const char* help = "Stitches along two paths beside the two edges, ends included.";
  static constexpr const char* example =
      R"({"action":"suture_row","a":[[-10,-0.7],[10,-0.7]],"b":[[-10,0.7],[10,0.7]],"spacing_mm":4})";
  static void fields(auto& v, auto& c) {
    v(Field::path("a", 2, "just beside one edge; of a running suture it may be curved"), c.a);
    v(Field::path("b", 2, "just beside the other edge, the same way"), c.b);
    row::sewn(v, c);
  }
  static std::string check(const SutureRow& c) {
    const double longer = std::max(path_mm(c.a), path_mm(c.b));
    if (longer / c.spacing_mm > double(ScriptLimits::row_sutures))
      return fmt::format("\"spacing_mm\" {:g} on a path of {:g} mm makes too many sutures; expected at most {}",
                         c.spacing_mm, longer, ScriptLimits::row_sutures);
    return row::slack_is_of_a_running_suture(c);
  }
  static std::string words(const SutureRow& c) { return fmt::format("row of sutures every {:.3g} mm", c.spacing_mm); }
  static Deed deed(const SutureRow&) { return {"", "One row of sutures", " rows of sutures"}; }
};

template <>
struct Act<SutureCorner> {
  static constexpr const char* name = "suture_corner";
  static constexpr const char* noun = "sutures";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool sews = true;
  static constexpr const char* help =
      "A half-buried mattress stitch: one thread from bank a through the flap's tip to bank b, all within the walls.";
  static constexpr const char* example =
      R"({"action":"suture_corner","tip":[0,-0.9],"a":[-1,0.7],"b":[1,0.7],"depth_mm":1})";
  static void fields(auto& v, auto& c) {
    v(Field::given("tip", "in the flap's tip"), c.tip);
    v(Field::given("a", "on one bank"), c.a);
    v(Field::given("b", "on the other bank"), c.b);
    v(Field::number_above("depth_mm", 0, ScriptLimits::depth_mm, "of the bites in the walls"), c.depth_mm);
  }
  static Deed deed(const SutureCorner&) { return {"", "One key suture", " key sutures"}; }
};

template <>
struct Act<SutureBite> {
  static constexpr const char* name = "suture_bite";
  static constexpr const char* noun = "sutures";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool sews = true, looks_back = true;
  static constexpr const char* help =
      "One bite of a running suture that is sewn bite after bite: the first ties the thread on, each further one goes "
      "on "
      "with it, \"suture_tie\" ends it.";
  static constexpr const char* example = R"({"action":"suture_bite","a":[0,-2],"b":[0,2]})";
  static void fields(auto& v, auto& c) {
    v(Field::given("a", "where the needle goes in, beside one edge: so far from it (6 mm at most) skin is held"), c.a);
    v(Field::given("b", "where it comes out, beside the other edge"), c.b);
    v(row::kBite_mm, c.depth_mm);
    v(Field::choice("surface_a", kHeldSides, kHeldSides, row::kSideHelp, Stands::if_other), c.side_a);
    v(Field::choice("surface_b", kHeldSides, kHeldSides, "the same at b", Stands::if_other), c.side_b);
  }
  static std::string words(const SutureBite&) { return "bite of a running suture"; }
  static Deed deed(const SutureBite&) { return {"", "One bite of a running suture", " bites of a running suture"}; }
};

template <>
struct Act<TieSuture> {
  static constexpr const char* name = "suture_tie";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool looks_back = true;
  static constexpr const char* help = "The thread that is sewn bite after bite is tied behind its last bite.";
  static constexpr const char* example = R"({"action":"suture_tie"})";
  static void fields(auto& v, auto& c) {
    v(Field::number("slack_mm", 0, 1000, "so much of the thread is left over when it is tied", Stands::if_other),
      c.slack_mm);
  }
  static std::string words(const TieSuture&) { return "running suture tied"; }
  static Deed deed(const TieSuture&) { return {"", "One running suture tied", " running sutures tied"}; }
};

template <>
struct Act<LetThreadGo> {
  static constexpr const char* name = "suture_let_go";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool looks_back = true;
  static constexpr const char* help =
      "The thread that is sewn bite after bite is let go without a knot: it slips until friction holds it, and the "
      "edges part again, most at its end. A further bite or \"suture_tie\" draws it tight.";
  static constexpr const char* example = R"({"action":"suture_let_go"})";
  static void fields(auto&, auto&) {}
  static std::string words(const LetThreadGo&) { return "thread let go"; }
  static Deed deed(const LetThreadGo&) { return {"", "One thread let go untied", " threads let go untied"}; }
};

template <>
struct Act<SutureBetween> {
  static constexpr const char* name = "suture_between";
  static constexpr const char* noun = "sutures";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool sews = true, looks_back = true;
  static constexpr const char* help = "A row along the wound's edges between two stitches.";
  static constexpr const char* example = R"({"action":"suture_between","from":1,"to":2,"spacing_mm":4})";
  static void fields(auto& v, auto& c) {
    v(Field::given("from", "a stitch by its number, in order of tying, or by its place"), c.from);
    v(Field::given("to", "another stitch of the same wound"), c.to);
    row::sewn(v, c.row);
  }
  static std::string check(const SutureBetween& c) { return row::slack_is_of_a_running_suture(c.row); }
  static Deed deed(const SutureBetween&) { return {"", "One row of sutures", " rows of sutures"}; }
};

template <>
struct Act<CutSuture> {
  static constexpr const char* name = "cut_suture";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool looks_back = true;
  static constexpr const char* help = "A thread is cut and taken out, the whole of it.";
  static constexpr const char* example = R"({"action":"cut_suture","id":3})";
  static void fields(auto& v, auto& c) {
    if (v.form("id", c.which.id > 0, " by a number", " by a place"))
      v(Field::number("id", 1, ScriptLimits::max_id, "a stitch by its number, in order of tying", Stands::always),
        c.which.id);
    else
      v(Field::given("at", "the stitch that is nearest to this place on the skin"), c.which.at);
  }
  static Deed deed(const CutSuture&) { return {"", "One thread cut", " threads cut"}; }
};

template <>
struct Act<Undo> {
  static constexpr const char* name = "undo";
  static constexpr Needs needs = Needs::nothing;
  static constexpr bool looks_back = true;
  static constexpr const char* help = "The last act that changed the patient is taken back.";
  static constexpr const char* example = R"({"action":"undo"})";
  static void fields(auto&, auto&) {}
  static Deed deed(const Undo&) { return {"", "One action taken back", " actions taken back"}; }
};

template <>
struct Act<Redo> {
  static constexpr const char* name = "redo";
  static constexpr Needs needs = Needs::nothing;
  static constexpr bool cuts_skin = true, looks_back = true;  // a cut may be done again
  static constexpr const char* help = "What was undone last is done again; a new act ends that.";
  static constexpr const char* example = R"({"action":"redo"})";
  static void fields(auto&, auto&) {}
  static Deed deed(const Redo&) { return {"", "One action done again", " actions done again"}; }
};

template <>
struct Act<Activate> {
  static constexpr const char* name = "activate";
  static constexpr Needs needs = Needs::skin;
  static constexpr const char* help =
      "A muscle of the scene ([[region]] with law \"muscle\") pulls along its fibres, or rests again. What lies "
      "between "
      "moves to its new rest.";
  static constexpr const char* example = R"({"action":"activate","region":"orbicularis oris","level":0.5})";
  static void fields(auto& v, auto& c) {
    v(Field::text("region", ScriptLimits::name_bytes, "what the scene calls the muscle"), c.region);
    v(Field::number("level", 0, 1, "how much of its greatest pull; 0: at rest"), c.level);
  }
  static std::string words(const Activate& c) { return fmt::format("{} at {:.0f} %", c.region, 100 * c.level); }
  static Deed deed(const Activate& c) { return {c.region + " active at " + rounded_text(100 * c.level, 3) + " %"}; }
};

template <>
struct Act<Stage> {
  static constexpr const char* name = "stage";
  static constexpr Needs needs = Needs::nothing;
  static constexpr bool leaves_patient = true;
  static constexpr const char* help = "A picture and a row in the report.";
  static constexpr const char* example = R"({"action":"stage","name":"flap cut"})";
  static void fields(auto& v, auto& c) {
    v(Field::text("name", ScriptLimits::name_bytes, "what the stage is called"), c.name);
  }
  static std::string words(const Stage& c) { return "stage: " + c.name; }
};

template <>
struct Act<Wait> {
  static constexpr const char* name = "wait";
  static constexpr Needs needs = Needs::nothing;
  static constexpr bool leaves_patient = true;
  static constexpr const char* help = "Lets time pass: the tissue comes to rest.";
  static constexpr const char* example = R"({"action":"wait","seconds":1})";
  static void fields(auto& v, auto& c) { v(Field::number("seconds", 0, ScriptLimits::seconds, "how long"), c.seconds); }
};

template <>
struct Act<Shown> {
  static constexpr const char* name = "shown";
  static constexpr Needs needs = Needs::nothing;
  static constexpr bool leaves_patient = true;
  static constexpr const char* help =
      "What follows was shown by the program and is not the learner's, until one with \"begins\":false; a lesson "
      "judges "
      "what is left.";
  static constexpr const char* example = R"({"action":"shown","begins":false})";
  static void fields(auto& v, auto& c) {
    v(Field::flag("begins", true, "the showing begins; false: it ends"), c.begins);
  }
  static std::string words(const Shown& c) { return c.begins ? "shown by the program:" : "end of what was shown"; }
};

template <>
struct Act<Mark> {
  static constexpr const char* name = "mark";
  static constexpr Needs needs = Needs::skin;
  static constexpr bool leaves_patient = true;
  static constexpr const char* help = "A line on the skin, drawn with a pen; the tissue stays as it is.";
  static constexpr const char* example = R"({"action":"mark","path":[[-10,5],[10,5]]})";
  static void fields(auto& v, auto& c) {
    v(Field::path("path", 1, "where the pen passes"), c.path);
    v(Field::flag("wipes", false, "a swab wipes off every line within 4 mm of the path"), c.wipes);
  }
  static std::string words(const Mark& c) {
    return c.wipes ? "lines of the pen wiped off" : fmt::format("pen: a line of {:.1f} mm", path_length(c.path));
  }
};

}  // namespace limberg

#include "sim/commands/table_head.h"

namespace limberg {

template <class C, class F>
void for_each_of(std::type_identity<C> command, F&& f) {
  f(command);
}
template <class F>
void for_each_of(std::type_identity<InSpace>, F&&) {}  // the same acts at other places
template <class... C, class F>
void for_each_of(std::type_identity<std::variant<C...>>, F&& f) {
  (for_each_of(std::type_identity<C>{}, f), ...);
}
/// Calls f(std::type_identity<C>) for every act C.
template <class F>
void for_each_act(F&& f) {
  for_each_of(std::type_identity<Command>{}, f);
}
/// Calls f(c) with the act itself; of one in space, with the act flattened.
template <class F>
decltype(auto) visit_act(const Command& command, F&& f) {
  return std::visit(
      [&]<class C>(const C& c) -> decltype(auto) {
        if constexpr (std::is_same_v<C, HeadCommand>)
          return std::visit(f, c);
        else if constexpr (std::is_same_v<C, InSpace>)
          return std::visit(f, flattened(c));
        else
          return f(c);
      },
      command);
}

}  // namespace limberg
