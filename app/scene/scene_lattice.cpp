#include "app/scene/scene_lattice.h"

#include "sim/body/skin.h"
#include "sim/lattice/lattice.h"

namespace limberg {
namespace {

constexpr size_t kMostZones = 32;
constexpr double kMostCells = 2e6;

// The size as so many halvings of cell_mm, the nearest by ratio.
int halvings(double cell_mm, double size_mm) {
  constexpr double kHalfStep = 1.4142135623730951;
  int level = 0;
  while (level < kLevels && size_mm * kHalfStep < cell_mm / double(1 << level)) ++level;
  return level;
}

std::string sizes(double cell_mm) {
  return "; expected " + number(cell_mm / (1 << kLevels)) + " to " + number(cell_mm) +
         " mm, an eighth of cell_mm to it";
}

// About how many cells a zone is divided into.
double cells_of(const FineZone& z, double cell_mm) {
  const double size = cell_mm / double(1 << z.level), deep = std::min(z.depth_mm, z.radius_mm);
  return ((z.to - z.at).norm() + 2 * z.radius_mm) * 2 * z.radius_mm * deep / (size * size * size);
}

void read_fine(Table& lattice, const std::string& file, Scene& s) {
  const toml::node* n = lattice.node("fine");
  if (!n) return;
  const toml::array* list = n->as_array();
  if (!list) lattice.fail("fine", "is no list; expected [{at_mm = [x, y], radius_mm, cell_mm}, ...]");
  if (list->size() > kMostZones)
    lattice.fail("fine", "is a list of " + std::to_string(list->size()) + " zones; expected at most " +
                             std::to_string(kMostZones));
  double cells = 0;
  for (const toml::node& e : *list) {
    const std::string name = "lattice.fine " + std::to_string(s.fine.size() + 1);
    const int line = int(e.source().begin.line);
    if (!e.is_table())
      throw InputError(file, line, name + " is no table; expected {at_mm = [x, y], radius_mm, cell_mm}");
    Table t(e.as_table(), name, file);
    FineZone z;
    for (const char* key : {"at_mm", "radius_mm", "cell_mm"})
      if (!t.has(key)) t.fail(key, "is missing; expected at_mm = [x, y], radius_mm and cell_mm");
    t.place("at_mm", z.at);
    z.to = z.at;
    t.place("to_mm", z.to);
    t.real("radius_mm", z.radius_mm, 0, 1000, true);
    double size_mm = s.cell_mm;
    t.real("cell_mm", size_mm, 0, 100, true);
    z.level = read_level(t, "cell_mm", s.cell_mm, size_mm);
    if (t.has("depth_mm")) z.depth_mm = 0;
    t.real("depth_mm", z.depth_mm, 0, 1000, true);
    t.finish();
    if (cells += cells_of(z, s.cell_mm); cells > kMostCells)
      t.fail("radius_mm", "makes more than 2 million cells; expected larger cells or a smaller zone");
    s.fine.push_back(z), s.fine_line.push_back(line);
  }
}

}  // namespace

int read_level(Table& t, const char* key, double cell_mm, double size_mm) {
  constexpr double kRounding = 1e-4;
  if (size_mm > cell_mm * (1 + kRounding) || size_mm < cell_mm / (1 << kLevels) * (1 - kRounding))
    t.fail(key, "is " + number(size_mm) + sizes(cell_mm));
  return halvings(cell_mm, size_mm);
}

void read_lattice(const toml::table& root, const std::string& file, Scene& s) {
  Table t = section(root, "lattice", file);
  const bool block = s.flesh && s.source == Scene::Source::block;
  t.real("cell_mm", s.cell_mm, 0.2, 100);
  if (block && s.cell_mm > s.block.size_mm.minCoeff())
    t.fail("cell_mm", "is " + number(s.cell_mm) + ", larger than the block's side of " +
                          number(s.block.size_mm.minCoeff()) + " mm; expected cells that fit into it");
  if (block && s.block.size_mm.prod() / (s.cell_mm * s.cell_mm * s.cell_mm) > kMostCells)
    t.fail("cell_mm", "makes more than 2 million cells; expected larger cells");
  t.boolean("refine_fronts", s.refine_fronts);
  t.boolean("refine_pockets", s.refine_pockets);
  t.real("region_mm", s.region_mm, 0, 1e5);
  double wound_mm = 0;
  t.real("wound_cell_mm", wound_mm, 0, 100);
  if (wound_mm > 0) s.wound_level = read_level(t, "wound_cell_mm", s.cell_mm, wound_mm);
  read_fine(t, file, s);
  t.finish();
}

void check_fine_places(const Scene& s, const std::shared_ptr<const Body>& body) {
  if (s.fine.empty()) return;
  const Skin skin(body);
  for (size_t i = 0; i < s.fine.size(); ++i)
    for (const ChartPoint& p : {s.fine[i].at, s.fine[i].to})
      if (!skin.at(p))
        throw InputError(s.path, s.fine_line[i],
                         "lattice.fine " + std::to_string(i + 1) + " is at [" + number(p.x()) + ", " + number(p.y()) +
                             "], off the skin; expected a place on the skin");
}

}  // namespace limberg
