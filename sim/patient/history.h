#pragma once
// What was done to a patient, in order, and what was undone. There is one history, whichever part of the patient acted:
// every act gives it the value that takes the act back (commands/acted.h), and undo and redo hand that value to its
// part.
#include <utility>
#include <vector>

namespace limberg {

template <class Entry>
class History {
 public:
  /// So many acts can be taken back, the newest: what takes them back costs memory (docs/limits.md).
  static constexpr size_t kMost = 1000;

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  Entry& last() { return done_.back(); }
  Entry& last_undone() { return undone_.back(); }

  /// Room for one more: the next push, or way back or forth, cannot fail.
  void make_room() {
    const size_t all = done_.size() + undone_.size() + 1;
    for (std::vector<Entry>* v : {&done_, &undone_})
      if (v->capacity() < all) v->reserve(2 * all);
  }
  void push(Entry entry) {
    if (done_.size() >= kMost) done_.erase(done_.begin());
    done_.push_back(std::move(entry));
    undone_.clear();
  }
  void end_redo() { undone_.clear(); }
  void went_back() { move_last(done_, undone_); }
  void went_forth() { move_last(undone_, done_); }

 private:
  static void move_last(std::vector<Entry>& from, std::vector<Entry>& to) {
    to.push_back(std::move(from.back()));
    from.pop_back();
  }

  std::vector<Entry> done_, undone_;
};

}  // namespace limberg
