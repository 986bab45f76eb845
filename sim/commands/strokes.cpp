#include "sim/commands/strokes.h"

namespace limberg {

std::vector<Command> join_strokes(std::span<const Command> commands) {
  std::vector<Command> out;
  int stroke = 0;    // being drawn; 0: none
  size_t place = 0;  // where it stands in `out`
  for (const Command& c : commands) {
    const auto* piece = std::get_if<InciseMore>(&c);
    if (!piece) {
      out.push_back(c);
      continue;
    }
    if (stroke != piece->stroke) {
      stroke = piece->stroke;
      place = out.size();
      Incise whole;
      whole.depth_mm = piece->depth_mm;
      whole.angle_deg = piece->angle_deg;
      out.push_back(std::move(whole));
    }
    std::vector<ChartPoint>& path = std::get<Incise>(out[place]).path;
    for (const ChartPoint& p : piece->path)
      if (path.empty() || path.back() != p) path.push_back(p);
    if (piece->last) stroke = 0;
  }
  return out;
}

}  // namespace limberg
