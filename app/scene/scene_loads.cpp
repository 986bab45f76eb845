#include "app/scene/scene_loads.h"

#include <array>

#include "app/scene/scene_lattice.h"
#include "sim/body/skin.h"

namespace limberg {
namespace {

constexpr size_t kMostLoads = 32;
constexpr std::array<const char*, 5> kSides{"-x", "+x", "-y", "+y", "-z"};

void read_sides(Table& t, const char* key, SideHold hold, std::array<SideHold, 5>& sides) {
  const toml::node* n = t.node(key);
  if (!n) return;
  const std::string expected = "; expected a list of \"-x\", \"+x\", \"-y\", \"+y\", \"-z\"";
  const toml::array* list = n->as_array();
  if (!list) t.fail(key, "is no list" + expected);
  for (const toml::node& e : *list) {
    const std::optional<std::string> name = e.value<std::string>();
    const auto side = name ? std::find(kSides.begin(), kSides.end(), *name) : kSides.end();
    if (side == kSides.end()) t.fail(key, "names a side that a block does not have" + expected);
    SideHold& now = sides[size_t(side - kSides.begin())];
    if (now != SideHold::held) t.fail(key, "names " + *name + ", which is named before; expected each side once");
    now = hold;
  }
}

}  // namespace

void read_sides(Table& body, Scene& s) {
  read_sides(body, "sliding_sides", SideHold::sliding, s.block.sides);
  read_sides(body, "free_sides", SideHold::free, s.block.sides);
  if (std::all_of(s.block.sides.begin(), s.block.sides.end(), [](SideHold h) { return h == SideHold::free; }))
    body.fail("free_sides", "names every side; expected one at least that holds the block or slides");
}

void read_loads(const toml::table& root, const std::string& file, Scene& s) {
  Table t = section(root, "loads", file);
  t.vector("gravity_m_s2", s.gravity_m_s2, 100);
  double size_mm = 0.5 * s.cell_mm;
  t.real("cell_mm", size_mm, 0, 100, true);
  s.load_level = read_level(t, "cell_mm", s.cell_mm, size_mm);
  if (const toml::node* n = t.node("patches")) {
    const toml::array* list = n->as_array();
    if (!list) t.fail("patches", "is no list; expected [{at_mm = [x, y], force_N = [x, y, z], radius_mm}, ...]");
    if (list->size() > kMostLoads)
      t.fail("patches", "is a list of " + std::to_string(list->size()) + " patches; expected at most " +
                            std::to_string(kMostLoads));
    for (const toml::node& e : *list) {
      const std::string name = "loads.patches " + std::to_string(s.loads.size() + 1);
      const int line = int(e.source().begin.line);
      if (!e.is_table())
        throw InputError(file, line, name + " is no table; expected {at_mm = [x, y], force_N = [x, y, z], radius_mm}");
      Table p(e.as_table(), name, file);
      for (const char* key : {"at_mm", "force_N"})
        if (!p.has(key)) p.fail(key, "is missing; expected at_mm = [x, y] and force_N = [x, y, z]");
      SkinLoad load;
      p.place("at_mm", load.at);
      p.vector("force_N", load.force_N, 100);
      p.real("radius_mm", load.radius_mm, 0, 20);
      p.finish();
      s.loads.push_back(load), s.load_line.push_back(line);
    }
  }
  t.finish();
}

void check_load_places(const Scene& s, const std::shared_ptr<const Body>& body) {
  if (s.loads.empty()) return;
  const Skin skin(body);
  for (size_t i = 0; i < s.loads.size(); ++i)
    if (const ChartPoint& p = s.loads[i].at; !skin.at(p))
      throw InputError(s.path, s.load_line[i],
                       "loads.patches " + std::to_string(i + 1) + " is at [" + number(p.x()) + ", " + number(p.y()) +
                           "], off the skin; expected a place on the skin");
}

}  // namespace limberg
