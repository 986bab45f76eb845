#include "sim/lattice/link_table.h"

#include <algorithm>
#include <utility>

namespace limberg {

void LinkTable::replace(std::span<const int32_t> squares, std::span<const Link> fresh) {
  auto square = squares.begin();
  auto link = fresh.begin();
  while (square != squares.end() || link != fresh.end()) {
    const int32_t first = square == squares.end() ? link->cell_axis
                          : link == fresh.end()   ? *square
                                                  : std::min(*square, link->cell_axis);
    const size_t b = size_t(first) / kBlock;
    const int32_t end = int32_t((b + 1) * kBlock);
    if (b >= block_.size()) block_.resize(b + 1);
    const std::shared_ptr<const Block> old = std::as_const(block_)[b];
    auto made = std::make_shared<Block>();
    auto was = old ? old->link.begin() : std::vector<Link>::const_iterator();
    const auto was_end = old ? old->link.end() : was;
    made->link.reserve((old ? old->link.size() : 0) + 8);
    for (int32_t s = int32_t(b * kBlock); s < end; ++s) {
      made->begin[size_t(s) % kBlock] = uint32_t(made->link.size());
      const bool gone = square != squares.end() && *square == s;
      if (gone) ++square;
      for (; was != was_end && was->cell_axis == s; ++was)
        if (!gone) made->link.push_back(*was);
      for (; link != fresh.end() && link->cell_axis == s; ++link) made->link.push_back(*link);
    }
    made->begin[kBlock] = uint32_t(made->link.size());
    size_ = size_ - (old ? old->link.size() : 0) + made->link.size();
    block_[b] = std::move(made);
  }
}

}  // namespace limberg
