#pragma once
// Which live faces meet at an edge (pair of points): 2 normally, 3 where a wall meets the skin, 4 where walls cross, 1
// at a crack front. Open addressing; faces at one edge are chained through their half-edges (3 * face + k). Inner edges
// (Face::inner) are left out: what meets there is known from the division.
//
// A cut asks in the end which edges it has touched: between begin_changes() and end_changes() every edge that gains or
// loses a face is noted once, with the place where it is found again without a search.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace limberg {

class EdgeMap {
 public:
  using Edge = std::pair<int32_t, int32_t>;  // ascending

  void reserve(size_t edges) {
    size_t n = 64;
    while (n < edges * 2) n *= 2;
    if (n > slot_.size()) rehash(n);
  }
  void reserve_faces(size_t faces) { next_.reserve(faces * 3); }

  /// Enters or removes those edges of a face whose bits are set.
  void add(int32_t face, const std::array<int32_t, 3>& v, uint8_t edges) {
    if (next_.size() < size_t(face) * 3 + 3) next_.resize(size_t(face) * 3 + 3, -1);
    if ((used_ + 3) * 2 > slot_.size()) grow();
    for (int k = 0; k < 3; ++k) {
      if (!(edges >> k & 1)) continue;
      Slot& s = slot_[find_or_enter(key(v[size_t(k)], v[k == 2 ? 0 : size_t(k + 1)]))];
      next_[size_t(face) * 3 + size_t(k)] = s.head;
      s.head = face * 3 + k;
      note(s);
    }
  }
  void remove(int32_t face, const std::array<int32_t, 3>& v, uint8_t edges) {
    for (int k = 0; k < 3; ++k) {
      if (!(edges >> k & 1)) continue;
      Slot& s = slot_[find(key(v[size_t(k)], v[k == 2 ? 0 : size_t(k + 1)]))];
      int32_t* at = &s.head;
      while (*at != face * 3 + k) at = &next_[size_t(*at)];
      *at = next_[size_t(*at)];
      note(s);
    }
  }
  /// First half-edge (3 * face + k) at this edge, -1 if there is none; then next().
  int32_t first(int32_t a, int32_t b) const {
    if (slot_.empty()) return -1;
    const Slot& s = slot_[find(key(a, b))];
    return s.key == kEmpty ? -1 : s.head;
  }
  int32_t next(int32_t half_edge) const { return next_[size_t(half_edge)]; }

  /// After this `faces` faces can be entered, the last of them named last_face, without asking for memory.
  void make_room(size_t faces, int32_t last_face) {
    if (next_.size() < size_t(last_face + 1) * 3) next_.resize(size_t(last_face + 1) * 3, -1);
    if ((used_ + 3 * faces) * 2 > slot_.size()) grow(3 * faces);
    changed_.reserve(changed_.size() + 3 * faces);
  }

  /// Soon to be added or removed.
  void prefetch(const std::array<int32_t, 3>& v, uint8_t edges) const {
    for (size_t k = 0; k < 3; ++k)
      if (edges >> k & 1) __builtin_prefetch(&slot_[Search(key(v[k], v[(k + 1) % 3]), slot_.size()).at], 1);
  }

  void begin_changes() {
    noting_ = true;
    changed_.clear();
    ++round_;
  }
  void end_changes() { noting_ = false; }
  /// Edges touched since begin_changes() that have a face, or had one: by the places
  /// where they are, in the order in which these were touched first. What a place
  /// holds now counts: an edge that has lost its faces may have left it to another.
  std::span<const uint32_t> changed() const { return changed_; }
  Edge edge(uint32_t slot) const { return {int32_t(uint32_t(slot_[slot].key)), int32_t(slot_[slot].key >> 32)}; }
  int32_t first(uint32_t slot) const { return slot_[slot].head; }

 private:
  static constexpr uint64_t kEmpty = ~uint64_t(0);
  struct Slot {
    uint64_t key = kEmpty;
    int32_t head = -1;   // -1: an edge that has no face any more; its place may be taken by another
    uint32_t round = 0;  // of changes, in which it was noted last
  };
  static uint64_t key(int32_t a, int32_t b) {
    if (a < b) std::swap(a, b);
    return uint64_t(uint32_t(a)) << 32 | uint32_t(b);
  }
  /// The places to look at, in order. The first ones lie in a window of 64 slots that belongs to 8 points with
  /// successive names, and to the edges of which one of these is the later end: what a cut makes lies together,
  /// neighbours in a mesh mostly do, and what cuts add to the edges of an old point does not crowd its window. A point
  /// with very many edges would fill its window and its neighbours' too, so after kNear steps the search goes on at a
  /// place that is spread over all.
  struct Search {
    size_t at, mask;
    uint64_t mixed;
    int steps = 0;
    Search(uint64_t k, size_t slots) : mask(slots - 1) {
      mixed = k * 0x9e3779b97f4a7c15ull;
      mixed ^= mixed >> 32;
      at = (size_t(k >> 35) * 64 + size_t(mixed & 63)) & mask;
    }
    void next() { at = (++steps == kNear ? size_t(mixed) : at + 1) & mask; }
    static constexpr int kNear = 48;
  };
  /// Its slot, or the empty one where the search ends.
  size_t find(uint64_t k) const {
    Search s(k, slot_.size());
    while (slot_[s.at].key != kEmpty && slot_[s.at].key != k) s.next();
    return s.at;
  }
  size_t find_or_enter(uint64_t k) {
    size_t free = slot_.size();
    Search s(k, slot_.size());
    for (; slot_[s.at].key != kEmpty; s.next()) {
      if (slot_[s.at].key == k) return s.at;
      if (slot_[s.at].head < 0 && free == slot_.size()) free = s.at;
    }
    if (free == slot_.size()) free = s.at, ++used_;
    slot_[free].key = k, slot_[free].head = -1;  // noted already, if its last edge was
    return free;
  }
  void note(Slot& s) {
    if (!noting_ || s.round == round_) return;
    s.round = round_;
    changed_.push_back(uint32_t(&s - slot_.data()));
  }
  void grow(size_t more = 3) {  // edges without faces are dropped on the way
    size_t live = more;
    for (const Slot& s : slot_) live += s.key != kEmpty && s.head >= 0;
    size_t n = 64;
    while (n < (live + 1) * 4) n *= 2;
    rehash(n);
  }
  void rehash(size_t n) {
    std::vector<Slot> old(n);
    old.swap(slot_);
    used_ = 0;
    for (const Slot& s : old) {
      if (s.key == kEmpty || s.head < 0) continue;
      slot_[find(s.key)] = s;
      ++used_;
    }
    std::erase_if(changed_, [&](uint32_t slot) { return old[slot].head < 0; });  // nothing is left to be done there
    for (uint32_t& slot : changed_) slot = uint32_t(find(old[slot].key));
  }

  std::vector<Slot> slot_;
  std::vector<int32_t> next_;
  size_t used_ = 0;  // slots that are not empty
  bool noting_ = false;
  uint32_t round_ = 0;
  std::vector<uint32_t> changed_;
};

}  // namespace limberg
