#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "app/import/lenient_json.h"
#include "app/import/peer_files.h"
#include "app/words/words.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"

namespace limberg {
namespace {

using JsonKind = LenientJson::Kind;

/// What is wrong with one act, at a line of the file.
struct BrokenAct {
  int line;
  std::string what;
};

const LenientJson& field_of(const LenientJson& of, const std::string& key, JsonKind kind) {
  const LenientJson* v = of.find(key);
  if (!v) throw BrokenAct{of.line, key + " is missing"};
  if (!v->is(kind))
    throw BrokenAct{v->line, fmt::format("{} is {}; expected {}", key, kind_words(v->kind), kind_words(kind))};
  return *v;
}

bool flag_of(const LenientJson& of, const std::string& key) {
  return of.find(key) && field_of(of, key, JsonKind::boolean).truth;
}

int whole_of(const LenientJson& v, const char* name) {
  if (!v.is(JsonKind::number) || v.number != std::floor(v.number) || !(std::abs(v.number) <= 1e6))
    throw BrokenAct{v.line, std::string(name) + " is no whole number; expected one of at most a million"};
  return int(v.number);
}

template <int N>
Eigen::Matrix<double, N, 1> numbers_of(const LenientJson& v, size_t from, const std::string& name) {
  if (!v.is(JsonKind::list) || v.item.size() != from + N)
    throw BrokenAct{v.line, fmt::format("{} is no list of {} numbers", name, from + N)};
  Eigen::Matrix<double, N, 1> out;
  for (size_t k = 0; k < size_t(N); ++k) {
    const LenientJson& e = v.item[from + k];
    if (!e.is(JsonKind::number) || !(std::abs(e.number) <= PeerLimits::coordinate))
      throw BrokenAct{e.line, name + " holds something else than numbers of at most 10000"};
    out[Eigen::Index(k)] = e.number;
  }
  return out;
}

/// `end`: of the names of a stitch's fields, "0" or "1".
PeerPlace place_of(const LenientJson& of, const std::string& end = "") {
  PeerPlace p;
  p.line = of.line;
  p.material = whole_of(field_of(of, "material" + end, JsonKind::number), "material");
  p.uv = numbers_of<2>(field_of(of, "historyTexture" + end, JsonKind::list), 0, "historyTexture" + end);
  if (of.find("displacement" + end))
    p.displacement = numbers_of<3>(field_of(of, "displacement" + end, JsonKind::list), 0, "displacement" + end);
  return p;
}

struct KindName {
  const char* name;
  PeerAct::Kind kind;
};
constexpr KindName kNames[] = {
    {"loadSceneFile", PeerAct::Kind::load_scene},
    {"makeIncision", PeerAct::Kind::incision},
    {"makeDeepCut", PeerAct::Kind::deep_cut},
    {"undermine", PeerAct::Kind::undermine},
    {"periostealUndermine", PeerAct::Kind::undermine_periosteum},
    {"excise", PeerAct::Kind::excise},
    {"addHook", PeerAct::Kind::add_hook},
    {"moveHook", PeerAct::Kind::move_hook},
    {"deleteHook", PeerAct::Kind::delete_hook},
    {"addSuture", PeerAct::Kind::add_suture},
    {"deleteSuture", PeerAct::Kind::delete_suture},
    {"promoteSutureApproximations", PeerAct::Kind::nothing},
    {"pausePhysics", PeerAct::Kind::nothing},
};

const LenientJson& list_of(const LenientJson& v, size_t least) {
  if (!v.is(JsonKind::list)) throw BrokenAct{v.line, fmt::format("is {}; expected a list", kind_words(v.kind))};
  if (v.item.size() < least)
    throw BrokenAct{v.line, fmt::format("has {} points; expected {} or more", v.item.size(), least)};
  if (v.item.size() > PeerLimits::posts) throw BrokenAct{v.line, "has more than 2000 points"};
  return v;
}

/// A list whose first entry holds flags, and whose others hold a point each under `key`.
void read_cut(PeerAct& a, const LenientJson& v, const char* key, const char* in, const char* out) {
  list_of(v, 3);
  const LenientJson& head = v.item[0];
  a.in = flag_of(head, in), a.out = flag_of(head, out);
  for (size_t i = 1; i < v.item.size(); ++i) {
    const LenientJson& p = field_of(v.item[i], key, JsonKind::object);
    PeerAct::Post post{place_of(p), Vec3::Zero(), false};
    if (a.kind == PeerAct::Kind::deep_cut) {
      post.normal = numbers_of<3>(field_of(p, "postNormal", JsonKind::list), 0, "postNormal");
      if (!(post.normal.norm() > 1e-6)) throw BrokenAct{p.line, "postNormal has no length"};
    }
    a.post.push_back(post);
  }
}

void read_outline(PeerAct& a, const LenientJson& v, const char* key) {
  for (const LenientJson& e : list_of(v, 2).item) {
    const LenientJson& p = field_of(e, key, JsonKind::object);
    a.post.push_back({place_of(p), Vec3::Zero(), flag_of(p, "incisionConnect")});
  }
}

void read_act(PeerAct& a, const LenientJson& v) {
  using K = PeerAct::Kind;
  switch (a.kind) {
    case K::load_scene:
      if (!v.is(JsonKind::text) || v.text.empty()) throw BrokenAct{v.line, "names no scene file"};
      a.scene = v.text;
      break;
    case K::incision:
      read_cut(a, v, "incisionPoint", "Tin", "Tout");
      break;
    case K::deep_cut:
      read_cut(a, v, "deepCutPoint", "openIn", "openOut");
      break;
    case K::undermine:
      read_outline(a, v, "underminePoint");
      break;
    case K::undermine_periosteum:
      read_outline(a, v, "periostealTriangle");
      break;
    case K::excise:
      a.post.push_back({place_of(v), Vec3::Zero(), false});
      break;
    case K::add_hook:
      a.post.push_back({place_of(v), Vec3::Zero(), false});
      a.number = whole_of(field_of(v, "hookNum", JsonKind::number), "hookNum");
      a.strong = flag_of(v, "strongHook");
      break;
    case K::move_hook:
      a.to = numbers_of<3>(v, 1, "moveHook");
      a.number = whole_of(v.item[0], "moveHook's number");
      break;
    case K::delete_hook:
    case K::delete_suture:
      a.number = whole_of(v, "the number");
      break;
    case K::add_suture:
      a.post = {{place_of(v, "0"), Vec3::Zero(), false}, {place_of(v, "1"), Vec3::Zero(), false}};
      a.number = whole_of(field_of(v, "sutureNum", JsonKind::number), "sutureNum");
      a.linked = flag_of(v, "linked");
      break;
    case K::nothing:
    case K::unknown:
      break;
  }
}

}  // namespace

const char* words_of(PeerAct::Kind kind) {
  switch (kind) {
    case PeerAct::Kind::load_scene:
      return english("scene");
    case PeerAct::Kind::incision:
      return english("incision");
    case PeerAct::Kind::deep_cut:
      return english("cut right through");
    case PeerAct::Kind::undermine:
      return english("undermining");
    case PeerAct::Kind::undermine_periosteum:
      return english("undermining of periosteum");
    case PeerAct::Kind::excise:
      return english("excision");
    case PeerAct::Kind::add_hook:
      return english("hook");
    case PeerAct::Kind::move_hook:
      return english("hook moved");
    case PeerAct::Kind::delete_hook:
      return english("hook taken out");
    case PeerAct::Kind::add_suture:
      return english("stitch");
    case PeerAct::Kind::delete_suture:
      return english("stitch cut");
    case PeerAct::Kind::nothing:
      return english("of the program");
    case PeerAct::Kind::unknown:
      return english("unknown");
  }
  return "";
}

PeerHistory parse_peer_history(std::string_view text, const std::string& file) {
  PeerHistory h;
  h.file = file;
  const LenientJson root = parse_lenient_json(text, file, &h.mended);
  if (!root.is(JsonKind::list))
    throw InputError(file, root.line, fmt::format("the history is {}; expected a list of acts", kind_words(root.kind)));
  if (root.item.size() > PeerLimits::acts)
    throw InputError(file, root.line, fmt::format("more than {} acts", PeerLimits::acts));
  for (const LenientJson& entry : root.item) {
    PeerAct a;
    a.line = entry.line;
    if (!entry.is(JsonKind::object) || entry.key.size() != 1) {
      a.wrong = "is no act; expected an object with one entry, the act's name";
    } else {
      a.name = entry.key[0], a.line = entry.item[0].line;
      for (const KindName& k : kNames)
        if (a.name == k.name) a.kind = k.kind;
      if (a.kind == PeerAct::Kind::unknown) a.wrong = limberg::quoted(a.name) + " is an act of no known kind";
      try {
        read_act(a, entry.item[0]);
      } catch (const BrokenAct& broken) {
        a.line = broken.line, a.wrong = broken.what;
      }
    }
    h.act.push_back(std::move(a));
  }
  return h;
}

}  // namespace limberg
