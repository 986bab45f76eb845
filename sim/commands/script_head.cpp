// Acts on skull and face, to and from a script's line.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim/commands/script_reader.h"

namespace limberg {

namespace {

using Json = nlohmann::ordered_json;
using L = ScriptLimits;

constexpr const char* kNames[] = {"osteotomy", "move_fragment",  "grab",     "drag",      "let_go",  "plate",
                                  "join",      "connect_tissue", "landmark", "superpose", "unplate", "sort"};
static_assert(std::variant_size_v<HeadCommand> == std::size(kNames));

constexpr double kDegree = std::numbers::pi / 180;

Json json(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }
Json json(const FragmentPick& p) { return p.id >= 0 ? Json(p.id) : json(p.at_mm); }

FragmentPick pick(const ScriptReader& r, const char* key) {
  if (r.is_list(key)) return {-1, r.place(key)};
  if (!r.has(key))
    r.fail(ScriptReader::quoted(key) + " is missing; expected the number of a fragment or a place [x, y, z] on it");
  return {int32_t(r.integer(key, 0, L::max_id)), Vec3::Zero()};
}

RigidMove move(const ScriptReader& r) {
  RigidMove m;
  if (r.has("translation_mm")) m.translation_mm = r.place("translation_mm");
  if (r.has("rotation_deg")) m.rotation_deg = r.place("rotation_deg");
  if (r.has("about")) m.about_mm = r.place("about");
  if (m.rotation_deg.norm() > 360) r.fail("\"rotation_deg\" turns by more than 360 degrees; expected less");
  return m;
}

void add(Json& j, const RigidMove& m) {
  j["translation_mm"] = json(m.translation_mm);
  if (m.rotation_deg != Vec3::Zero()) j["rotation_deg"] = json(m.rotation_deg);
  if (m.about_mm) j["about"] = json(*m.about_mm);
}

CutBone read_cut(const ScriptReader& r, const std::string& where) {
  CutBone c;
  c.must_divide = r.boolean("must_divide", true);
  if (r.has("contour")) {
    r.only({"action", "contour", "must_divide"}, where + " by a contour");
    c.contour_mm = r.places("contour", 3);
    return c;
  }
  r.only({"action", "point", "normal", "radius_mm", "of", "must_divide"}, where + " by a plane");
  c.point_mm = r.place("point");
  c.normal = r.place("normal");
  if (c.normal.norm() < 1e-6) r.fail("\"normal\" has no length; expected a direction");
  c.radius_mm = r.real("radius_mm", 0, 0, L::coordinate_mm, false);
  if (r.has("of")) c.of = pick(r, "of");
  return c;
}

ConnectTissue read_tissue(const ScriptReader& r, const std::string& where) {
  r.only({"action", "name", "face", "face_radius_mm", "bone", "bone_radius_mm", "layers", "young_kPa", "mode"}, where);
  ConnectTissue t;
  t.name = r.text("name", true, 60);
  t.face_mm = r.place("face");
  t.bone_mm = r.has("bone") ? r.place("bone") : t.face_mm;
  t.face_radius_mm = r.real("face_radius_mm", t.face_radius_mm, 0, 500, true);
  t.bone_radius_mm = r.real("bone_radius_mm", 0, 0, 500, false);
  if (r.has("layers")) t.layers = int(r.integer("layers", 1, 16));
  t.young_kPa = r.real("young_kPa", t.young_kPa, 0, 1e6, true);
  if (!r.has("mode")) return t;
  const std::string mode = r.text("mode", true, 40);
  const auto* at = std::find(std::begin(kTissueKinds), std::end(kTissueKinds), mode);
  if (at == std::end(kTissueKinds))
    r.fail("\"mode\" is \"" + ScriptReader::shown(mode) + "\"; expected " + kTissueKindList);
  t.mode = TissueKind(at - std::begin(kTissueKinds));
  return t;
}

}  // namespace

Eigen::Isometry3d isometry(const RigidMove& m, const Vec3& centre_mm) {
  const Vec3 about = m.about_mm.value_or(centre_mm);
  const double angle = m.rotation_deg.norm() * kDegree;
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  if (angle > 0) turn.linear() = Eigen::AngleAxisd(angle, m.rotation_deg.normalized()).toRotationMatrix();
  turn.translation() = about - turn.linear() * about + m.translation_mm;
  return turn;
}

RigidMove as_move(const Eigen::Isometry3d& map) {
  const Eigen::AngleAxisd turn(map.linear());
  RigidMove m;
  m.translation_mm = map.translation();
  m.rotation_deg = turn.axis() * (turn.angle() / kDegree);
  m.about_mm = Vec3::Zero();
  return m;
}

bool is_head_action(std::string_view action) {
  return std::find(std::begin(kNames), std::end(kNames), action) != std::end(kNames);
}

const char* head_action_name(const HeadCommand& command) { return kNames[command.index()]; }

HeadCommand read_head_action(const ScriptReader& r, const std::string& a, const std::string& where) {
  const auto seconds = [&] { return r.real("seconds", 2, 0, L::seconds, false); };
  const auto hand = [&] { return r.has("hand") ? int(r.integer("hand", 0, 1)) : 0; };
  if (a == "osteotomy") return read_cut(r, where);
  if (a == "move_fragment") {
    r.only({"action", "fragment", "translation_mm", "rotation_deg", "about", "seconds"}, where);
    return MoveFragment{pick(r, "fragment"), move(r), seconds()};
  }
  if (a == "grab") {
    r.only({"action", "fragment", "hand"}, where);
    return GrabFragment{pick(r, "fragment"), hand()};
  }
  if (a == "drag") {
    r.only({"action", "translation_mm", "rotation_deg", "about", "seconds", "hand"}, where);
    return DragFragment{move(r), seconds(), hand()};
  }
  if (a == "let_go") {
    r.only({"action", "snap", "hand"}, where);
    return LetGo{r.boolean("snap", false), hand()};
  }
  if (a == "plate") {
    r.only({"action", "a", "b"}, where);
    return PlateFragments{r.place("a"), r.place("b")};
  }
  if (a == "join") {
    r.only({"action", "a", "b"}, where);
    return JoinFragments{pick(r, "a"), pick(r, "b")};
  }
  if (a == "unplate") {
    r.only({"action", "fragment"}, where);
    return Unplate{pick(r, "fragment")};
  }
  if (a == "sort") {
    r.only({"action"}, where);
    return SortFragments{};
  }
  if (a == "connect_tissue") return read_tissue(r, where);
  if (a == "superpose") {
    r.only({"action", "on", "name"}, where);
    Superpose s;
    const std::string on = r.text("on", true, 40);
    const auto* at = std::find(std::begin(kSkullBeside), std::end(kSkullBeside), on);
    if (at == std::end(kSkullBeside))
      r.fail("\"on\" is \"" + ScriptReader::shown(on) + "\"; expected normal, mirror or off");
    s.on = SkullBeside(at - std::begin(kSkullBeside));
    if (r.has("name")) s.name = r.text("name", true, 40);
    return s;
  }
  r.only({"action", "name", "at", "on"}, where);
  PlaceLandmark l;
  l.name = r.text("name", true, 40);
  l.at_mm = r.place("at");
  if (r.has("on")) {
    const std::string on = r.text("on", true, 40);
    if (on != "bone" && on != "face") r.fail("\"on\" is \"" + ScriptReader::shown(on) + "\"; expected bone or face");
    l.on_face = on == "face";
  }
  return l;
}

std::string head_json_line(const HeadCommand& command) {
  Json j;
  j["action"] = head_action_name(command);
  if (const auto* c = std::get_if<CutBone>(&command)) {
    if (!c->contour_mm.empty()) {
      j["contour"] = Json::array();
      for (const Vec3& p : c->contour_mm) j["contour"].push_back(json(p));
    } else {
      j["point"] = json(c->point_mm), j["normal"] = json(c->normal);
      if (c->radius_mm > 0) j["radius_mm"] = c->radius_mm;
      if (c->of) j["of"] = json(*c->of);
    }
    if (!c->must_divide) j["must_divide"] = false;
  } else if (const auto* m = std::get_if<MoveFragment>(&command)) {
    j["fragment"] = json(m->fragment);
    add(j, m->by);
    j["seconds"] = m->seconds;
  } else if (const auto* g = std::get_if<GrabFragment>(&command)) {
    j["fragment"] = json(g->fragment);
    if (g->hand != 0) j["hand"] = g->hand;
  } else if (const auto* d = std::get_if<DragFragment>(&command)) {
    add(j, d->to);
    j["seconds"] = d->seconds;
    if (d->hand != 0) j["hand"] = d->hand;
  } else if (const auto* l = std::get_if<LetGo>(&command)) {
    if (l->snap) j["snap"] = true;
    if (l->hand != 0) j["hand"] = l->hand;
  } else if (const auto* p = std::get_if<PlateFragments>(&command)) {
    j["a"] = json(p->a_mm), j["b"] = json(p->b_mm);
  } else if (const auto* k = std::get_if<JoinFragments>(&command)) {
    j["a"] = json(k->a), j["b"] = json(k->b);
  } else if (const auto* t = std::get_if<ConnectTissue>(&command)) {
    j["name"] = t->name;
    j["face"] = json(t->face_mm), j["face_radius_mm"] = t->face_radius_mm;
    j["bone"] = json(t->bone_mm), j["bone_radius_mm"] = t->bone_radius_mm;
    j["layers"] = t->layers, j["young_kPa"] = t->young_kPa, j["mode"] = kTissueKinds[size_t(t->mode)];
  } else if (const auto* n = std::get_if<PlaceLandmark>(&command)) {
    j["name"] = n->name, j["at"] = json(n->at_mm);
    if (n->on_face) j["on"] = "face";
  } else if (const auto* u = std::get_if<Unplate>(&command)) {
    j["fragment"] = json(u->fragment);
  } else if (const auto* s = std::get_if<Superpose>(&command)) {
    j["on"] = kSkullBeside[size_t(s->on)];
    if (!s->name.empty()) j["name"] = s->name;
  }
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace limberg
