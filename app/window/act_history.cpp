#include "app/window/act_history.h"

#include <algorithm>

#include "sim/commands/authorship.h"
#include "sim/patient/history.h"

namespace limberg {

void ActHistory::hear(const Notice& n) {
  if (n.kind == Notice::undone && standing_ > 0) --standing_;
  if (n.kind == Notice::redone && standing_ < entries_.size()) ++standing_;
  if (n.kind != Notice::done || !n.command || !is_undoable(*n.command)) return;
  const auto* piece = std::get_if<InciseMore>(n.command.get());
  if (piece && standing_ > 0 && entries_[standing_ - 1].stroke == piece->stroke) return;  // of the same act
  entries_.resize(standing_);
  Entry e;
  e.number = ++number_, e.text = n.text.data(), e.t_s = n.t_s, e.stroke = piece ? piece->stroke : 0;
  entries_.push_back(std::move(e));
  if (entries_.size() > History<int>::kMost) {  // as the patient does
    start_ = std::move(entries_.front());       // one goes back as far as to it
    entries_.erase(entries_.begin());
  }
  standing_ = entries_.size();
}

ActHistory::Entry* ActHistory::unseen(bool at_rest) {
  Entry& e = standing_ == 0 ? start_ : entries_[standing_ - 1];
  return e.taken == 0 || (e.taken == 1 && at_rest) ? &e : nullptr;
}

Image thumbnail(const Image& image, int x0, int y0, int x1, int y1, int width, int height) {
  x0 = std::clamp(x0, 0, image.width), x1 = std::clamp(x1, x0, image.width);
  y0 = std::clamp(y0, 0, image.height), y1 = std::clamp(y1, y0, image.height);
  // The largest part of that shape, in its middle.
  const double step = std::min(double(x1 - x0) / width, double(y1 - y0) / height);
  Image small(width, height);
  if (step < 1) return small;
  const double left = x0 + 0.5 * ((x1 - x0) - step * width), top = y0 + 0.5 * ((y1 - y0) - step * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int r = 0, g = 0, b = 0, n = 0;
      for (int j = int(top + step * y); j < int(top + step * (y + 1)); ++j)
        for (int i = int(left + step * x); i < int(left + step * (x + 1)); ++i) {
          const Rgb8 c = image.at(i, j);
          r += c.r, g += c.g, b += c.b, ++n;
        }
      if (n > 0) small.set(x, y, {uint8_t(r / n), uint8_t(g / n), uint8_t(b / n)});
    }
  return small;
}

}  // namespace limberg
