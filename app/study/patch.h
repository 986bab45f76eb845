#pragma once
// A patch of skin on which the studies carry out procedures of the repertoire, and what they measure of one afterwards.
//
// Lengths are those of the prestretched skin, so an elongation is already divided by the prestretch.
#include <memory>
#include <string>
#include <vector>

#include "app/study/skin_map.h"
#include "app/study/study.h"
#include "sim/body/skin.h"
#include "sim/measure/metrics.h"

namespace limberg::study {

enum class Support {
  fat,    // 1.5 mm of skin at 60 kPa on 8.5 mm of fat at 15 kPa; sides and base are held
  none,   // the same skin alone, its sides held: a plate
  plane,  // a membrane that cannot leave its plane (planar_law.h), its sides held
};

struct Patch {
  Support support = Support::fat;
  double side_mm = 120, prestretch_percent = 10, cell_mm = 4;
  double undermine_mm = 12;                                // margin of the pocket around the figure; on fat only
  double region_mm = 0;                                    // > 0: held outside this radius
  double spacing_mm = 3, inset_mm = 0.7, corner_mm = 0.9;  // of stitches
  double bite_mm = 1;  // half of what a stitch holds of its edge; no more than half the spacing
  bool contact = false;
  double depth_mm = 4;  // of cut and undermining; on fat only
  // Cells in which a cut ends are divided, so that it opens to its end; on fat only. Without, a slit stays shut over
  // the last cell, and a flap's tip that is to lie in its end comes to lie on the skin instead.
  bool fronts = true;
  // Where skin may stand up (places of the figure), and how far it
  // is pushed there, up and down, to find equilibria beside the
  // one that closing it leads to; and how far all skin is drawn
  // taut around it and let go again (taut_percent; 0: not). The
  // equilibrium of least energy counts. 0: not pushed, nor drawn.
  std::vector<Vec2> ears = {};
  double push_mm = 0;
  // Skin that was sewn up slack lies as the closing left it: a flap's tip over its neighbour, a fold. Drawn to this
  // stretch, prestretch included, it has one equilibrium, flat but for what stands up even then; let go from there it
  // stands up where its angles say.
  // Skin that has this prestretch is not drawn.
  double taut_percent = 12;
};

/// An operation done: the patient's figures and what it looks like.
struct Done {
  std::vector<Command> commands;
  Metrics metrics;
  std::shared_ptr<Snapshot> shown = std::make_shared<Snapshot>();
  std::shared_ptr<const SkinMap> map;
  std::shared_ptr<const SkinMap> under;  // the flap's underside: what was freed from its bed
  std::shared_ptr<const Skin> skin;
  double residual = 0, solve_ms = 0;
  double energy_uJ = 0;        // of the body at rest in the end
  double closing_uJ = 0;       // that, less what it had when all was cut and nothing sewn
  double open_elongation = 0;  // of a Z-plasty's central limb then
  int equilibria = 1;          // different ones that were found
  // What led to the one that counts: 0 the closing, 1 drawn taut and let go, 2 and 3 pushed up and down at the ears.
  int found_by = 0;
  double energy_as_closed_uJ = 0;  // of the first
  size_t nodes = 0;

  /// Highest skin above the flat within `radius_mm` of a place of the figure.
  double height_mm(const Vec2& place, double radius_mm) const;
  /// Volume above the flat and root of the mean square of the height there.
  DogEar shape(const Vec2& place, double radius_mm) const;
  /// Highest place there of the flap's middle surface, half way between its skin and its
  /// underside, above where it was at rest; both evened out over discs of even_mm. What a plate's
  /// height means: tissue that keeps its volume and is pressed together in its plane grows thicker
  /// and its skin higher, without leaving the plane. Where nothing is freed it cannot be said.
  double middle_height_mm(const Vec2& place, double radius_mm, double even_mm) const;
};

Done carry_out_on(const Patch& patch, const Figure& figure, const Run& with);

/// Forces, gaps, residual and size: the last columns of every row.
void add_common(Row& row, const Done& done);

/// Rows that differ in nothing but `key`, in its order.
std::vector<std::vector<const Row*>> groups(const std::vector<Row>& rows, const std::string& key,
                                            const std::vector<std::string>& parameters);

/// One line for each group.
NamedChart chart(const std::string& name, const std::string& title, const std::vector<Row>& rows, const std::string& x,
                 const std::string& x_title, const std::string& y, const std::string& y_title,
                 const std::vector<std::string>& parameters);

}  // namespace limberg::study
