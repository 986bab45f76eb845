#pragma once
// A value that is found when it is first asked for. Copies share it, and any thread may be the first to ask; later ones
// wait for the first.
//
//   Lazy<SharedArray<float>> depth([=] { return depths_of(points); });   // costs nothing yet
//   float d = depth.get()[7];                                            // now it is found
//
//   Lazy<Index> index;                                                   // whoever asks says how it is found
//   index.get([&] { return index_of(surface); });
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace limberg {

template <class T>
class Lazy {
 public:
  using Find = std::function<T()>;
  Lazy() : state_(std::make_shared<State>()) {}
  Lazy(T found) : Lazy() {
    get([&] { return std::move(found); });
  }
  /// `find` is called at most once and is given up then. What it reads must stay as it is until then.
  explicit Lazy(Find find) : Lazy() { state_->find = std::move(find); }

  const T& get() const {
    return get([this] { return state_->find ? state_->find() : T(); });
  }
  /// `find` is called if nobody has asked before. A call that throws has not found it; the next one tries again.
  template <class F>
  const T& get(F&& find) const {
    std::call_once(state_->once, [&] {
      state_->found = find();
      state_->find = nullptr;
    });
    return state_->found;
  }

 private:
  struct State {
    std::once_flag once;
    Find find;
    T found;
  };
  std::shared_ptr<State> state_;
};

}  // namespace limberg
