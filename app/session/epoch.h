#pragma once
// Frees old versions of a shared object on its owner's thread, once every reader has moved past them.
//
// The owner keeps each version by shared_ptr; readers hold raw pointers that they got with a snapshot and pay nothing
// but one atomic store when they begin to use a newer version. No lock, no reference count on a reader's thread, and
// never a free there.
//
//     owner                                  reader i
//     versions.retain(v, object);            (takes a snapshot of version v, drops all older pointers)
//     ... publishes a snapshot naming v      versions.moved_to(i, v);
//     versions.collect();
//
// Versions only grow. A reader that is done for good says retire(i).
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace limberg {

template <class T, int kReaders>
class Versions {
 public:
  static constexpr uint64_t kDone = std::numeric_limits<uint64_t>::max();

  // Owner's thread.
  void retain(uint64_t version, std::shared_ptr<const T> object) {
    if (!kept_.empty() && version <= kept_.back().first) {
      if (version == kept_.back().first && object == kept_.back().second) return;
      throw std::logic_error("topology versions must grow");
    }
    kept_.emplace_back(version, std::move(object));
  }
  /// Frees every version that is older than what all readers use; the newest one is always kept. Returns how many.
  size_t collect() {
    uint64_t oldest = kDone;
    for (const auto& r : reader_) oldest = std::min(oldest, r.at.load(std::memory_order_acquire));
    size_t n = 0;
    while (n + 1 < kept_.size() && kept_[n].first < oldest) ++n;
    kept_.erase(kept_.begin(), kept_.begin() + std::ptrdiff_t(n));
    return n;
  }
  size_t kept() const { return kept_.size(); }

  // Reader's thread. Release: what the reader did with older versions happens before the owner frees them.
  void moved_to(int reader, uint64_t version) noexcept { reader_[reader].at.store(version, std::memory_order_release); }
  void retire(int reader) noexcept { moved_to(reader, kDone); }

 private:
  struct alignas(64) Reader {
    std::atomic<uint64_t> at{0};  // the version it uses; 0: it has not begun, nothing may be freed
  };
  Reader reader_[kReaders];
  std::vector<std::pair<uint64_t, std::shared_ptr<const T>>> kept_;
};

}  // namespace limberg
