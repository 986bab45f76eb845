#pragma once
// An array that is found when it is first read. Copies share it, and any thread may be the first reader.
//
//   LazyArray<float> depth([=] { return depths_of(points); });   // costs nothing yet
//   float d = depth[7];                                          // now it is found; later
//                                                                readers wait for the first one
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "sim/base/shared_array.h"

namespace limberg {

template <class T>
class LazyArray {
 public:
  using Find = std::function<SharedArray<T>()>;
  LazyArray() = default;
  LazyArray(SharedArray<T> found) : state_(std::make_shared<State>()) {
    std::call_once(state_->once, [&] { state_->found = std::move(found); });
  }
  /// `find` is called at most once and is given up then. What it reads must stay as it is until then.
  explicit LazyArray(Find find) : state_(std::make_shared<State>()) { state_->find = std::move(find); }

  const SharedArray<T>& all() const {
    static const SharedArray<T> none;
    if (!state_) return none;
    std::call_once(state_->once, [this] {
      state_->found = state_->find();
      state_->find = nullptr;
    });
    return state_->found;
  }
  size_t size() const { return all().size(); }
  const T& operator[](size_t i) const { return all()[i]; }

 private:
  struct State {
    std::once_flag once;
    Find find;
    SharedArray<T> found;
  };
  std::shared_ptr<State> state_;
};

}  // namespace limberg
